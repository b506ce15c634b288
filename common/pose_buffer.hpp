#pragma once

#include <deque>
#include <optional>

#include "common/pose2.hpp"
#include "common/trajectory.hpp"
#include "lcm_tools/base/utime.hpp"

namespace marco {

/// The last poses of one source, to be asked for any moment between them.
///
/// A stamp that steps backwards is taken as the truth: samples at or after it are forgotten, so
/// that a log with a bursty clock still answers exactly at each sample's own stamp right after it
/// was added. Keeps `capacity` samples. Not thread-safe.
class PoseBuffer {
 public:
  PoseBuffer() : PoseBuffer(4000) {}
  explicit PoseBuffer(std::size_t capacity);

  void add(Utime utime, const Pose2& frame_from_robot);
  void clear() { samples_.clear(); }
  bool empty() const { return samples_.empty(); }
  Utime newest() const { return samples_.back().utime; }
  Utime oldest() const { return samples_.front().utime; }
  const Pose2& newest_pose() const { return samples_.back().pose; }

  /// The pose at `utime`, interpolated between its neighbours; extrapolated with the last step's
  /// velocity up to `reach` beyond the newest sample. Nothing before the oldest or beyond reach.
  std::optional<Pose2> at(Utime utime, Duration reach = {}) const;

  /// The motion in `length` from `begin` on, in the frame at its begin. Samples that do not reach
  /// its end yet answer for as long a time up to the newest one. Nothing when they do not reach
  /// `begin` at all, or do not go back as far.
  std::optional<Pose2> motion_during(Utime begin, Duration length) const;

  /// All it holds, oldest first; adding them to an empty buffer makes the same again.
  Trajectory samples() const;

 private:
  struct Sample {
    Utime utime;
    Pose2 pose;
  };
  std::size_t capacity_;
  std::deque<Sample> samples_;
};

}  // namespace marco
