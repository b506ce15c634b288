#pragma once

#include <cstdint>
#include <optional>

#include "common/pose_buffer.hpp"
#include "common/samples.hpp"

namespace marco {

/// Whether odometry says that the robot stood between two of its poses: they differ by less than
/// wheels can tell.
bool stood_still(const Pose2& before, const Pose2& now);

/// Odometry, to be asked for the pose at a scan. Odometry with a scan's own stamp, delivered
/// together with it, belongs to it: it holds for the scan, however wrong the stamp. Some loggers,
/// though, look such odometry up by the scan's stamp before they write it; it then belongs to
/// another moment wherever the stamp had to be repaired. Which it is, the repaired scans of a
/// moving robot tell: by odometry that was looked up it moved as little as the stamps, by odometry
/// that came along it moved on. Not thread-safe.
class OdometryTrack {
 public:
  /// A scan as far as odometry is concerned.
  struct AtScan {
    Utime stamp;     ///< as delivered
    Utime repaired;  ///< StampRepair's
    double period_s = 0.0;
    std::optional<Pose2> own;  ///< delivered with it
  };

  /// Whether the base's driver or board was restarted before `sample`, so that it counts from
  /// another origin: no robot goes so far between two samples (1 m and 5 m/s, or 1 rad and 7 rad/s,
  /// over 10 s at most), nor stands at zero to the millimetre after it was elsewhere.
  bool restarts_at(const OdometrySample& sample) const;
  void add(const OdometrySample& sample);
  void clear();

  /// The newest sample's pose where it has this stamp.
  std::optional<Pose2> own_of(Utime stamp) const;
  /// Notes a scan, in order of arrival: what is_looked_up() is told by.
  void note(const AtScan& scan);
  bool is_looked_up() const;

  /// Whether the pose at `scan`, and `duration_s` later, is known, or will never be: a source that
  /// has been silent for `patience_s` is not waited for.
  bool covers(const AtScan& scan, double duration_s, double patience_s) const;
  std::optional<Pose2> at(const AtScan& scan, double reach_s) const;
  /// From the scan's first beam on; see PoseBuffer::motion_during.
  std::optional<Pose2> motion_during(const AtScan& scan, double duration_s) const;

  const PoseBuffer& samples() const { return samples_; }

  template <class Visitor>
  void visit(Visitor& v) {
    v("samples", samples_);
    v("own_before", own_before_);
    v("stamp_before", stamp_before_);
    v("beat_step", beat_step_);
    v("looked_up", looked_up_);
  }

 private:
  /// The moment on the samples' clock.
  Utime moment_of(const AtScan& scan) const;

  PoseBuffer samples_;               ///< by their own stamps
  std::optional<Pose2> own_before_;  ///< of the last scan
  Utime stamp_before_;
  Pose2 beat_step_;        ///< between the last two regular scans, by their own odometry
  int32_t looked_up_ = 0;  ///< scans that tell so, less those that deny it
};

}  // namespace marco
