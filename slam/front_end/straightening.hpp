#pragma once

#include <optional>
#include <vector>

#include "common/input/deskew.hpp"
#include "slam/front_end/motion_model.hpp"
#include "slam/front_end/scan_matcher.hpp"

namespace marco::slam {

/// A scan, deskewed in one way, and its match.
struct MatchedScan {
  DeskewedScan scan;
  OrientedPoints points;  ///< of its hits
  ScanMatch match;
  /// How badly it fits (see ScanMatch), and would with each of the rival times of its beams; empty
  /// unless the robot turns fast enough to tell.
  std::vector<double> misfits_m2;
};

/// Straightens a scan by the motion that its own match shows. It was deskewed by a predicted
/// velocity, which errs wherever a robot begins or ceases to turn. The match still finds the pose
/// at the scan's middle, and that with the scan before's the velocity: the scan is deskewed by it
/// and matched again. References what it is made of; made again for each scan.
class Straightening {
 public:
  /// What is common to all scans.
  struct Matching {
    const ScanMatcher& matcher;
    const NormalOptions& normals;
    const LocalMap& map;
    const MotionModel& motion;  ///< at the scan before
    Pose2 world_from_before;    ///< at its first beam
  };
  /// @param prior  of the pose at the scan's first beam
  /// @param first_from_middle  of the scan as it was predicted
  Straightening(const Matching& matching,
                Utime utime,
                const PosePrior& prior,
                const Pose2& first_from_middle)
      : with_(matching),
        utime_(utime),
        prior_(prior),
        predicted_middle_(prior.map_from_robot * first_from_middle) {}

  /// @returns the scan as it is where straightening does not matter, or its match becomes worse.
  MatchedScan straightened(MatchedScan scan) const;

  /// Deskewed by another velocity and matched again, from the pose at its middle.
  MatchedScan again(const MatchedScan& scan, const Velocity2& velocity) const {
    return again(scan, scan.scan.time_of_hit_s, velocity);
  }

  /// The scan as it would be at other turn rates than predicted: in steps that matches can make up
  /// for, the nearest first, up to the robot's limit; nothing of a short scan.
  static std::vector<DeskewedScan> bent(const DeskewedScan& scan, double max_turn_rate_rad_per_s);

  /// See MatchedScan. @param rival_times_s  of the beams, one a beam each
  std::vector<double> misfits_m2(const MatchedScan& scan,
                                 const std::vector<std::vector<float>>& rival_times_s) const;

 private:
  /// That the match shows.
  std::optional<Velocity2> velocity_of(const MatchedScan& scan) const;
  MatchedScan again(const MatchedScan& scan,
                    std::vector<float> time_of_hit_s,
                    const Velocity2& velocity) const;

  const Matching with_;
  Utime utime_;
  PosePrior prior_;
  Pose2 predicted_middle_;
};

}  // namespace marco::slam
