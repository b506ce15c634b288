#include "slam/calibration/closed_form.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "common/linear_algebra.hpp"

namespace marco::slam {
namespace {

// Twice the five unknowns of the position's form.
constexpr std::size_t kFewestSamples = 10;
using Matrix5 = Eigen::Matrix<double, 5, 5>;
using Rows = Eigen::Matrix<double, 2, 5>;

// Scales of the wheels over the track, the left one's negative.
std::optional<Eigen::Vector2d> turn_by_wheels(const std::vector<MotionSample>& samples) {
  // Above it both wheels turned so alike that noise decides how they differ.
  constexpr double kWorstCondition = 75.0;
  NormalEquations<2> sum;
  for (const MotionSample& sample : samples) {
    Eigen::Vector2d counted = Eigen::Vector2d::Zero();
    for (const WheelStep& step : sample.wheels) counted += Eigen::Vector2d(step.left, step.right);
    sum.add(counted, sample.laser_moved.theta_rad, 1.0);
  }
  const Eigen::Vector2d spread = eigenpairs_of(sum.information).first;
  if (!(spread.y() <= kWorstCondition * spread.x())) return std::nullopt;
  return solve_symmetric(sum.information, sum.gradient);
}

// The position's error as a linear form (the authors' Q).
Rows position_rows(const MotionSample& sample, const RobotModel& unit) {
  const Pose2 moved = axle_motion(sample.wheels, unit);
  const double c = std::cos(moved.theta_rad), s = std::sin(moved.theta_rad);
  const Pose2& laser = sample.laser_moved;
  return (Rows() << -moved.x_m, 1.0 - c, s, laser.x_m, -laser.y_m,  //
          -moved.y_m, -s, 1.0 - c, laser.y_m, laser.x_m)
      .finished();
}

std::optional<ClosedFormResult> solve(std::vector<MotionSample> samples) {
  if (samples.size() < kFewestSamples) return std::nullopt;
  const auto turn_by_wheel = turn_by_wheels(samples);
  if (!turn_by_wheel) return std::nullopt;
  const RobotModel unit{-turn_by_wheel->x(), turn_by_wheel->y(), 1.0, {}};  // for a track of 1 m
  Matrix5 form = Matrix5::Zero();
  for (const MotionSample& sample : samples) {
    const Rows rows = position_rows(sample, unit);
    form += rows.transpose() * rows;
  }
  const Eigen::LDLT<Eigen::Matrix3d> lengths(form.topLeftCorner<3, 3>());
  const Eigen::Matrix<double, 3, 2> coupling = form.topRightCorner<3, 2>();
  const Eigen::Matrix<double, 3, 2> solved = lengths.solve(coupling);
  const Eigen::Matrix2d heading_form =
      form.bottomRightCorner<2, 2>() - coupling.transpose() * solved;
  const auto [values, vectors] = eigenpairs_of(heading_form);
  Eigen::Vector2d heading = vectors.col(0);
  Eigen::Vector3d track_x_y = -solved * heading;
  if (track_x_y.x() < 0.0) {
    heading = -heading;
    track_x_y = -track_x_y;
  }
  if (!(track_x_y.x() > 0.0) || !track_x_y.allFinite()) return std::nullopt;
  const double track_m = track_x_y.x();
  ClosedFormResult result;
  result.model = {track_m * unit.left_scale,
                  track_m * unit.right_scale,
                  track_m,
                  {track_x_y.y(), track_x_y.z(), std::atan2(heading.y(), heading.x())}};
  result.heading_ratio = values.y() / std::max(values.x(), 1e-300);
  result.kept = std::move(samples);
  return result;
}

// Drops the worst of 100 by angle, and by position.
std::vector<MotionSample> without_worst(const ClosedFormResult& found) {
  constexpr double kKept = 0.99;  // outliers are wrong matches and slipping wheels, a few of 100
  const std::size_t count = found.kept.size();
  std::vector<double> angles, distances;
  for (const MotionSample& sample : found.kept) {
    const Eigen::Vector3d error = error_of(sample, found.model);
    angles.push_back(std::abs(error.z()));
    distances.push_back(error.head<2>().norm());
  }
  const auto rank = std::min(
      count - 1, static_cast<std::size_t>(std::lround(kKept * static_cast<double>(count))));
  const auto limit_of = [&](std::vector<double> values) {
    const auto at = values.begin() + static_cast<std::ptrdiff_t>(rank);
    std::nth_element(values.begin(), at, values.end());
    return *at;
  };
  const double worst_angle = limit_of(angles), worst_distance = limit_of(distances);
  std::vector<MotionSample> kept;
  for (std::size_t i = 0; i < count; ++i) {
    if (angles[i] <= worst_angle && distances[i] <= worst_distance) kept.push_back(found.kept[i]);
  }
  return kept;
}

}  // namespace

std::optional<ClosedFormResult> calibrate_in_closed_form(std::vector<MotionSample> samples) {
  constexpr int kTrimmings = 4;  // with them 8 % at most are dropped
  auto found = solve(std::move(samples));
  for (int i = 0; i < kTrimmings && found; ++i) found = solve(without_worst(*found));
  return found;
}

}  // namespace marco::slam
