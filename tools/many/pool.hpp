#pragma once

#include <string>
#include <vector>

#include "tools/many/job.hpp"

namespace marco::many {

/// Does what is not done yet, `jobs` at a time, each in a process of its own (marco-map-many
/// --task). One that is killed is begun again when the others are through, five times at most.
/// Ctrl-C: waits for those that run, which get the same signal, and begins no others.
/// @param command  after which a task's number follows
void run_jobs(const Store& store,
              const std::vector<Entry>& entries,
              int jobs,
              const std::vector<std::string>& command);

}  // namespace marco::many
