#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "lcm_tools/log/log_walk.hpp"

namespace marco::logs {

struct CsvResult {
  WalkResult walk;
  std::vector<std::string> files;  ///< names, in the order their first message came
};

/// One table a channel, `FOLDER/CHANNEL.csv` (CHANNEL.TYPE.csv for a second type on it): the
/// event's number and time, then a column a value. Arrays of a fixed length up to 64 have a column
/// an element; all others are one cell with their values in a row, separated by spaces. Byte arrays
/// are base64. Messages that do not decode have no table.
/// @throws std::invalid_argument when the folder exists and is not empty and shall be kept;
/// std::runtime_error as OutputFile.
CsvResult export_csv(WalkInput& input,
                     const Types& types,
                     const std::filesystem::path& folder,
                     Existing existing,
                     const OnProgress& on_progress);

/// A channel's name as part of a file's name.
std::string file_name_of(std::string_view channel);

}  // namespace marco::logs
