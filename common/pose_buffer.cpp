#include "common/pose_buffer.hpp"

#include <algorithm>

#include "lcm_tools/base/check.hpp"

namespace marco {

PoseBuffer::PoseBuffer(std::size_t capacity) : capacity_(capacity) {
  require(capacity >= 2, "PoseBuffer: capacity must be at least 2");
}

void PoseBuffer::add(Utime utime, const Pose2& frame_from_robot) {
  while (!samples_.empty() && samples_.back().utime >= utime) samples_.pop_back();
  samples_.push_back({utime, frame_from_robot});
  if (samples_.size() > capacity_) samples_.pop_front();
}

std::optional<Pose2> PoseBuffer::at(Utime utime, Duration reach) const {
  if (samples_.empty() || utime < samples_.front().utime) return std::nullopt;
  const auto after = std::lower_bound(samples_.begin(), samples_.end(), utime,
                                      [](const Sample& s, Utime t) { return s.utime < t; });
  if (after != samples_.end() && after->utime == utime) return after->pose;
  if (after == samples_.end()) {
    if (utime - samples_.back().utime > reach) return std::nullopt;
    if (samples_.size() < 2) return samples_.back().pose;
    const Sample& last = samples_.back();
    // Stamps of a stalled logger lie microseconds apart: no step's velocity holds for longer.
    const auto newer =
        std::lower_bound(samples_.begin(), samples_.end() - 1, last.utime - (utime - last.utime),
                         [](const Sample& s, Utime t) { return s.utime <= t; });
    const Sample& before = newer == samples_.begin() ? *newer : *(newer - 1);
    const double base_s = (last.utime - before.utime).seconds();
    const double part = std::min(1.0, (utime - last.utime).seconds() / base_s);
    const Pose2 step = between(before.pose, last.pose);
    return last.pose * Pose2{step.x_m * part, step.y_m * part, step.theta_rad * part};
  }
  const Sample& before = *(after - 1);
  const double part = (utime - before.utime).seconds() / (after->utime - before.utime).seconds();
  return interpolate(before.pose, after->pose, part);
}

std::optional<Pose2> PoseBuffer::motion_during(Utime begin, Duration length) const {
  if (samples_.empty() || begin - newest() > length) return std::nullopt;
  const Utime end = std::min(begin + length, newest());
  const auto at_begin = at(end - length), at_end = at(end);
  if (!at_begin || !at_end) return std::nullopt;
  return between(*at_begin, *at_end);
}

Trajectory PoseBuffer::samples() const {
  Trajectory samples;
  for (const Sample& sample : samples_) samples.push_back({sample.utime, sample.pose});
  return samples;
}

}  // namespace marco
