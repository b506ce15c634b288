#pragma once

#include <deque>
#include <optional>

#include "common/pose2.hpp"
#include "common/trajectory.hpp"
#include "lcm_tools/base/utime.hpp"

namespace marco {

/// The last poses of one source, interpolated at any time between them.
///
/// After a stamp that steps backwards, samples at or after it are dropped: a log with a bursty
/// clock still answers exactly at the stamp of the sample that was just added. Keeps `capacity`
/// samples. Not thread-safe.
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

  /// The pose at `utime`, interpolated between its neighbours; extrapolated up to `reach` beyond
  /// the newest sample, by the velocity over as long a time before it, and no longer than that.
  /// Nothing before the oldest or beyond reach.
  std::optional<Pose2> at(Utime utime, Duration reach = {}) const;

  /// The motion from `begin` for `length`, in the frame at its begin. Where the samples end
  /// earlier, the motion of the last `length` up to the newest one. Nothing when they end before
  /// `begin`, or start too late.
  std::optional<Pose2> motion_during(Utime begin, Duration length) const;

  /// All samples, oldest first; adding them to an empty buffer gives an equal one.
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
