#pragma once

#include <string>

namespace marco::process {

/// `name` as a file name: other characters than letters, digits, '.', '_', '-' as %XX.
std::string file_name_of(const std::string& name);

/// Where this user's `program` keeps what outlives it: in XDG_STATE_HOME, else in ~/.local/state,
/// else in /tmp.
std::string state_folder(const std::string& program);

}  // namespace marco::process
