#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/pose2.hpp"
#include "lcm_tools/base/utime.hpp"
#include "slam/line_slam/line_mapper.hpp"

namespace marco::slam {

/// What marco-line-slam must know to resume after it died.
struct LineCheckpoint {
  Utime utime;  ///< of the last scan taken
  int64_t map_revision = 0;
  LineMapper::Stored mapper;
};

/// The checkpoint as bytes, sealed (common/byte_archive.hpp).
std::vector<uint8_t> encode_checkpoint(const LineCheckpoint& checkpoint);
/// @throws std::invalid_argument saying what is wrong: no checkpoint, cut short, damaged.
LineCheckpoint decode_checkpoint(const std::vector<uint8_t>& bytes);

/// Writes a temporary file, then renames it: the checkpoint is complete at any moment.
/// @throws std::runtime_error naming the path.
void save_checkpoint(const std::string& path, const LineCheckpoint& checkpoint);
/// @returns nothing when there is no such file. @throws as decode_checkpoint, naming the path.
std::optional<LineCheckpoint> load_checkpoint(const std::string& path);

}  // namespace marco::slam
