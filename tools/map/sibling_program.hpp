#pragma once

#include <string>
#include <vector>

namespace marco {

/// Whether a program of ours is in this program's folder: a build may omit parts of Marco.
bool has_sibling(const char* name);

/// Runs a program of ours from this program's folder and waits for its end. The program is killed
/// when this thread ends before it: it may write into a folder that another run uses next.
/// @returns its exit code, -1 when a signal ended it.
/// @throws std::runtime_error naming the program when it cannot be started.
int run_sibling(const char* name, std::vector<std::string> arguments);

}  // namespace marco
