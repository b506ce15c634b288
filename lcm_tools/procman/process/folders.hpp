#pragma once

#include <string>

namespace marco::procman {

/// `name` as a file name: other characters than letters, digits, '.', '_', '-' as %XX.
std::string file_name_of(const std::string& name);

/// Where deputies keep the sockets of running commands: in XDG_RUNTIME_DIR, else in /tmp.
std::string default_runtime_folder();

/// Where deputies write the commands' output: in XDG_STATE_HOME, else in ~/.local/state.
std::string default_output_folder();

/// Locked by the deputy that uses this runtime folder of its own.
std::string lock_path(const std::string& runtime_folder);

/// Whether a deputy of this user and id is at work on this host, with the default runtime folder.
bool deputy_is_at_work(const std::string& deputy_id);

}  // namespace marco::procman
