#pragma once

#include <string>

#include "lcm_tools/procman/process/descriptor.hpp"

namespace marco::procman {

/// `name` as a file name: other characters than letters, digits, '.', '_', '-' as %XX.
std::string file_name_of(const std::string& name);

/// Where deputies keep the sockets of running commands: in XDG_RUNTIME_DIR, else in /tmp.
std::string default_runtime_folder();

/// Where `program` keeps what outlives it: in XDG_STATE_HOME, else in ~/.local/state, else in /tmp.
std::string state_folder(const std::string& program);

/// Where deputies write the commands' output: in XDG_STATE_HOME, else in ~/.local/state.
std::string default_output_folder();

/// Makes the runtime folder, for this user only, and locks it for as long as the result lives.
/// @throws std::runtime_error when it is another user's, or another deputy's.
Descriptor lock_runtime_folder(const std::string& runtime_folder);

/// Whether a deputy with this id of this user runs on this host, in the default runtime folder.
bool deputy_is_at_work(const std::string& deputy_id);

}  // namespace marco::procman
