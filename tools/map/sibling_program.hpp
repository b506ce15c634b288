#pragma once

#include <string>
#include <vector>

namespace marco {

/// Runs a program of ours that lies beside this one and waits for its end.
/// @returns its exit code, -1 when a signal ended it.
/// @throws std::runtime_error naming the program when it cannot be started.
int run_sibling(const char* name, std::vector<std::string> arguments);

}  // namespace marco
