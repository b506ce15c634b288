#pragma once

#include <filesystem>
#include <optional>

#include "lcm_tools/files/event_log.hpp"
#include "lcmtypes/grid_joiner.hpp"
#include "tools/log/ros_export.hpp"

namespace marco::logs {

/// What SLAM and cameras published, from an LCM log, in the order of its file: SLAM_POSE,
/// TRAJECTORY, GRID_MAP and pictures.
class SlamResults {
 public:
  SlamResults(const std::filesystem::path& log, RosExport& out) : log_(log.string()), out_(out) {}

  /// Writes the next ones up to the first that is later. Broken messages are ignored.
  void write_until(Utime utime);

 private:
  /// Of the first bytes of a message of ours; nothing for other messages.
  std::optional<Utime> stamp_of_result(const files::LogEventHead& head) const;
  void write(const std::string& channel, std::span<const uint8_t> bytes, Utime event_time);
  void write_image(const std::string& channel, std::span<const uint8_t> bytes);
  void write_maps(const std::vector<JoinedGrid>& maps);

  files::EventLogReader log_;
  RosExport& out_;
  GridJoiner grids_;
  std::optional<Utime> due_;  // of the event that was read last, and not written
  std::string channel_;
  Utime event_time_;
  bool ended_ = false;
};

}  // namespace marco::logs
