#pragma once

#include <string>
#include <vector>

namespace marco {

/// Whether a program of ours lies beside this one: parts of Marco may be left out of a build.
bool has_sibling(const char* name);

/// Runs a program of ours that lies beside this one and waits for its end. The program is killed
/// when this thread ends before it: it may write into a folder that another run uses next.
/// @returns its exit code, -1 when a signal ended it.
/// @throws std::runtime_error naming the program when it cannot be started.
int run_sibling(const char* name, std::vector<std::string> arguments);

}  // namespace marco
