#pragma once

#include <optional>

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

/// The same for a truth of another clock, of which only the times of arrival tell how the clocks
/// are related: the delay of at most half a second that fits best is found as well.
TrajectoryFit fit_to_truth_of_other_clock(const Trajectory& estimate, const Trajectory& truth);

/// The truth in the estimate's frame, by the best fit; empty when there is none.
Trajectory truth_on_estimate(const Trajectory& estimate, const Trajectory& truth);

/// Odometry in the estimate's frame, by their first poses; empty when one of them is.
Trajectory odometry_on_estimate(const Trajectory& estimate, const Trajectory& odometry);

}  // namespace marco
