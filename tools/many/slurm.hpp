#pragma once

#include <string>
#include <vector>

#include "tools/many/job.hpp"

namespace marco::many {

/// Numbers as Slurm's --array takes them: "1-3,7".
std::string array_of(const std::vector<std::size_t>& numbers);

/// A word that a shell takes as it is.
std::string quoted(const std::string& word);

/// Submits what is not done yet as one array job, `jobs` tasks at a time, and a job behind it that
/// writes the table. Slurm schedules them and begins those of a broken node again.
/// @param command  the arguments of marco-map-many that every task has
/// @returns a line for the user. @throws std::runtime_error when sbatch refuses, or is not there.
std::string submit(const Store& store,
                   const std::vector<Entry>& entries,
                   int jobs,
                   const std::vector<std::string>& command);

}  // namespace marco::many
