#pragma once

#include <optional>

#include "common/samples.hpp"
#include "common/trajectory.hpp"

namespace marco {

/// The error of a path after its best rigid alignment with the truth.
struct TrajectoryFit {
  std::size_t count = 0;      ///< poses with truth before and after them
  Pose2 truth_from_estimate;  ///< frame of the truth from frame of the estimate
  double rms_m = 0.0;
  double max_m = 0.0;
  Duration truth_late;  ///< by which the truth's stamps are late; 0 where that was not asked for
};

/// Least squares of the positions over rotation and translation, no scale (Umeyama 1991). The truth
/// is interpolated at each estimate's stamp; estimates outside its span, or in a gap above
/// `max_gap`, are left out. @returns count < 2 when there is nothing to fit.
TrajectoryFit fit_to_truth(const Trajectory& estimate,
                           const Trajectory& truth,
                           Duration max_gap = Duration::from_seconds(1.0));

/// The true poses of recordings.
struct RecordedTruth {
  Trajectory poses;
  bool is_by_arrival = false;  ///< one of them at least: see TruePose

  void add(const TruePose& pose);
};

/// The same for what recordings hold. Where the times of arrival alone tell how its clock and the
/// scans' are related, the delay of at most half a second that fits best is found as well.
TrajectoryFit fit_to_truth(const Trajectory& estimate, const RecordedTruth& truth);

/// The truth in the estimate's frame, by the best fit; empty when there is none.
Trajectory truth_on_estimate(const Trajectory& estimate, const RecordedTruth& truth);

/// Odometry in the estimate's frame, by their first poses; empty when one of them is.
Trajectory odometry_on_estimate(const Trajectory& estimate, const Trajectory& odometry);

}  // namespace marco
