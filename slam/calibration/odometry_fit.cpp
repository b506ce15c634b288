#include "slam/calibration/odometry_fit.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/linear_algebra.hpp"
#include "slam/calibration/closed_form.hpp"
#include "slam/calibration/motion_samples.hpp"

namespace marco::slam {
namespace {

constexpr double kPi = std::numbers::pi;

// Where the axle is by the odometry alone: the line on which nothing slides sideways. Poses that
// are not the axle's own, because the robot's frame is elsewhere or looks elsewhere, seem to slide
// as they turn or drive. How far to its side the poses are, no sliding tells.
// @returns the pose of the axle in the robot's frame, as OdometryCalibration's; nothing changed
// where nothing slides, and where the robot does so (mecanum wheels).
OdometryCalibration axle_of(const std::vector<LaserMotion>& motions, const OdometryTravel& travel) {
  constexpr double kSlides = 0.02;         // of the way: less is rounding, and wheels that slip
  constexpr double kLeastTurnedRad = 0.5;  // root of the sum of squares: else x is not observable
  OdometryCalibration axle;
  Eigen::Matrix3d form = Eigen::Matrix3d::Zero();
  for (const LaserMotion& motion : motions) {
    const ArcMotion counted = travel.between_moments(motion.begin_s, motion.end_s);
    const Eigen::Vector3d row(counted.ahead_m, counted.left_m, counted.turn_rad);
    form += row * row.transpose();
  }
  const double way2 = form(0, 0) + form(1, 1);
  if (form(1, 1) < kSlides * kSlides * way2) return axle;
  // Least squares of -sin(yaw) ahead + cos(yaw) (left + x turn); x by Schur's complement.
  const bool turns = form(2, 2) > kLeastTurnedRad * kLeastTurnedRad;
  const Eigen::Vector2d coupling = form.topRightCorner<2, 1>();
  Eigen::Matrix2d sliding = form.topLeftCorner<2, 2>();
  if (turns) sliding -= coupling * coupling.transpose() / form(2, 2);
  const auto [values, vectors] = eigenpairs_of(sliding);
  if (values.x() > kSlides * kSlides * way2) return axle;
  Eigen::Vector2d across = vectors.col(0);
  if (across.y() < 0.0) across = -across;
  axle.axle_yaw_deg = rad_to_deg(std::atan2(-across.x(), across.y()));
  if (turns && across.y() > 0.1) {
    axle.axle_x_m = -coupling.dot(across) / (form(2, 2) * across.y());
  }
  return axle;
}

ModelPrior prior_of(const Pose2& robot_from_laser) {
  ModelPrior prior;
  prior.mean = to_vector({1.0, 1.0, kCountedTrackM, robot_from_laser}, 0.0);
  prior.sigma << 0.3, 0.3, 0.3 * kCountedTrackM, 0.3, 0.3, 0.5, 0.3;
  return prior;
}

// @param known_late_s  where the time is not looked for
SamplesAt samples_of(const std::vector<LaserMotion>& motions,
                     const OdometryTravel& travel,
                     OdometryCalibration signs,
                     std::optional<double> known_late_s = {}) {
  return [&motions, &travel, signs, known_late_s](double late_s) mutable {
    signs.late_s = known_late_s.value_or(late_s);
    return motion_samples(motions, travel, signs);
  };
}

// A standing robot gives no information, and makes the errors look small.
std::vector<LaserMotion> moving(const std::vector<LaserMotion>& motions,
                                const OdometryTravel& travel,
                                double late_s) {
  constexpr double kLeastM = 0.02, kLeastDeg = 1.0;  // in one motion
  const auto moves = [](double way_m, double turn_rad) {
    return way_m > kLeastM || std::abs(turn_rad) > deg_to_rad(kLeastDeg);
  };
  std::vector<LaserMotion> result;
  for (const LaserMotion& motion : motions) {
    const ArcMotion counted =
        travel.between_moments(motion.begin_s + late_s, motion.end_s + late_s);
    if (moves(motion.moved.translation_m().norm(), motion.moved.theta_rad) ||
        moves(std::hypot(counted.ahead_m, counted.left_m), counted.turn_rad)) {
      result.push_back(motion);
    }
  }
  return result;
}

RefinedModel refine_from_scratch(const SamplesAt& samples_at,
                                 const TurnCorrelation& turns,
                                 const ModelPrior& prior) {
  std::vector<MotionSample> samples = samples_at(turns.late_s);
  if (samples.empty()) return {};
  const Pose2 robot_from_axle = samples.front().robot_from_axle;
  for (MotionSample& sample : samples) sample.robot_from_axle = {};
  if (auto closed = calibrate_in_closed_form(samples)) {
    Pose2& laser = closed->model.robot_from_laser;
    laser = robot_from_axle * laser;
    return refine(samples_at, to_vector(closed->model, turns.late_s), prior);
  }
  double way_m = 0.0, counted_m = 0.0;
  for (const MotionSample& sample : samples) {
    way_m += sample.laser_moved.translation_m().norm();
    counted_m += axle_motion(sample.wheels, {1.0, 1.0, kCountedTrackM, {}}).translation_m().norm();
  }
  constexpr double kLeastWayM = 0.5;  // below it the ratio is noise
  const double scale = counted_m > kLeastWayM ? std::max(way_m / counted_m, 0.1) : 1.0;
  const double turn_scale = std::abs(turns.slope) > 0.1 ? std::abs(turns.slope) : scale;
  RefinedModel best;
  for (int quarter = 0; quarter < 4; ++quarter) {
    const Pose2 laser =
        Pose2::from_vector(prior.mean.segment<3>(kLaserX)) * Pose2{0.0, 0.0, 0.5 * kPi * quarter};
    const RobotModel start{scale, scale, kCountedTrackM * scale / turn_scale, laser};
    const RefinedModel found = refine(samples_at, to_vector(start, turns.late_s), prior);
    if (quarter == 0 || found.unlikeliness < best.unlikeliness) best = found;
  }
  return best;
}

// The axle the other way round, and the laser with it.
ModelVector turned_round(ModelVector parameters, const Pose2& robot_from_axle) {
  const Pose2 turned = robot_from_axle * Pose2{0.0, 0.0, kPi} * robot_from_axle.inverse();
  const Pose2 laser = turned * to_model(parameters).robot_from_laser;
  parameters.segment<3>(kLaserX) = laser.vector();
  return parameters;
}

// Two wheels that count backwards on an axle of negative length, looking back, are two wheels that
// count forwards on an ordinary one.
ModelVector with_positive_track(ModelVector parameters, const Pose2& robot_from_axle) {
  if (parameters[kTrack] >= 0.0) return parameters;
  for (const ModelParameter one : {kLeftScale, kRightScale, kTrack}) parameters[one] *= -1.0;
  return turned_round(parameters, robot_from_axle);
}

Missing missing_of(const std::vector<MotionSample>& samples, const RefinedModel& found) {
  constexpr double kTurned = kPi / 4, kDrivenM = 0.5;  // of what moves by more than noise
  const std::array<bool, kModelParameters>& observed = found.observed;
  if (std::all_of(observed.begin(), observed.begin() + kLate, [](bool b) { return b; })) {
    return Missing::nothing;
  }
  double turned_rad = 0.0, driven_m = 0.0;
  for (const MotionSample& sample : samples) {
    const Pose2 moved = axle_motion(sample.wheels, to_model(found.parameters));
    if (std::abs(moved.theta_rad) > 4.0 * found.spread.straight.z()) {
      turned_rad += std::abs(moved.theta_rad);
    }
    const double way_m = moved.translation_m().norm();
    if (way_m > 4.0 * found.spread.straight.head<2>().maxCoeff()) driven_m += way_m;
  }
  if (turned_rad < kTurned) return driven_m < kDrivenM ? Missing::motion : Missing::turns;
  return driven_m < kDrivenM ? Missing::ways : Missing::other_arcs;
}

class Fitter {
 public:
  Fitter(const OdometryTravel& travel, const TurnCorrelation& turns, const Pose2& laser)
      : travel_(travel), turns_(turns), prior_(prior_of(laser)) {
    // Midway between two samples of odometry their mean has half of their noise. Where a motion
    // holds few samples, the fit would move the time there, so that turns alone tell it.
    constexpr double kDenseS = 0.1;  // five in the shortest motion: the noise changes by a tenth
    if (travel.interval_s() > kDenseS) known_late_s_ = turns.is_late_found ? turns.late_s : 0.0;
  }

  RefinedModel fit(const std::vector<LaserMotion>& motions) const {
    const RefinedModel found = refine_from_scratch(samples_at(motions), turns_, prior_);
    if (found.parameters[kTrack] > 0.0) return with_time(found);
    return refit(motions, with_positive_track(found.parameters, signs.robot_from_axle()));
  }
  RefinedModel refit(const std::vector<LaserMotion>& motions, const ModelVector& start) const {
    return with_time(refine(samples_at(motions), start, prior_));
  }
  double error(const std::vector<LaserMotion>& motions,
               const ModelVector& parameters,
               const ErrorSpread& spread) const {
    const auto samples = samples_of(motions, travel_, signs)(parameters[kLate]);
    return squared_error(samples, to_model(parameters), spread);
  }
  const ModelPrior& prior() const { return prior_; }

  OdometryCalibration signs;

 private:
  SamplesAt samples_at(const std::vector<LaserMotion>& motions) const {
    return samples_of(motions, travel_, signs, known_late_s_);
  }
  RefinedModel with_time(RefinedModel model) const {
    if (!known_late_s_) return model;
    model.parameters[kLate] = *known_late_s_;
    model.observed[kLate] = turns_.is_late_found;
    model.covariance.row(kLate).setZero();
    model.covariance.col(kLate).setZero();
    model.covariance(kLate, kLate) = turns_.sigma_late_s * turns_.sigma_late_s;
    return model;
  }

  const OdometryTravel& travel_;
  const TurnCorrelation& turns_;
  ModelPrior prior_;
  std::optional<double> known_late_s_;
};

bool drives_backwards(const std::vector<LaserMotion>& motions,
                      const OdometryTravel& travel,
                      double late_s) {
  double ahead_m = 0.0;
  for (const LaserMotion& motion : motions) {
    ahead_m += travel.between_moments(motion.begin_s + late_s, motion.end_s + late_s).ahead_m;
  }
  return ahead_m < 0.0;
}

}  // namespace

const char* to_string(Missing missing) {
  switch (missing) {
    case Missing::motion:
      return "motion";
    case Missing::turns:
      return "turns";
    case Missing::ways:
      return "driving besides turns on the spot";
    case Missing::other_arcs:
      return "arcs with another radius";
    case Missing::changes_of_speed:
      return "changes of speed";
    case Missing::nothing:
      break;
  }
  return "nothing";
}

OdometryFit fit_odometry(const std::vector<LaserMotion>& all,
                         const OdometryTravel& travel,
                         const TurnCorrelation& turns,
                         double turn_sign,
                         const Pose2& robot_from_laser) {
  constexpr double kOppositeDeg = 15.0;  // so close to backwards the motion does not show the front
  constexpr std::size_t kFewest = 20;    // motions, of three equations each: for seven parameters
  const std::vector<LaserMotion> motions = moving(all, travel, turns.late_s);
  Fitter fitter(travel, turns, robot_from_laser);
  fitter.signs = axle_of(motions, travel);
  fitter.signs.turn_sign = turn_sign;
  OdometryFit fit;
  fit.robot_from_laser = robot_from_laser;
  fit.found.turn_sign = turn_sign;
  fit.missing = Missing::motion;
  if (motions.size() < kFewest) return fit;
  fit.model = fitter.fit(motions);
  const double off_rad =
      normalize_angle(fit.model.parameters[kLaserYaw] - robot_from_laser.theta_rad);
  fit.ambiguous_front =
      fit.model.observed[kLaserYaw] && std::abs(off_rad) > kPi - deg_to_rad(kOppositeDeg);
  // Robots drive ahead more than back.
  if (fit.ambiguous_front && drives_backwards(motions, travel, turns.late_s)) {
    fitter.signs.forward_sign = -1.0;
    fit.model =
        fitter.refit(motions, turned_round(fit.model.parameters, fitter.signs.robot_from_axle()));
  }
  fit.missing = missing_of(motion_samples(motions, travel, fitter.signs), fit.model);
  const ModelVector& found = fit.model.parameters;
  fit.robot_from_laser = to_model(found).robot_from_laser;
  fit.found = fitter.signs;
  fit.found.left_scale = found[kLeftScale];
  fit.found.right_scale = found[kRightScale];
  fit.found.track_scale = found[kTrack] / kCountedTrackM;
  fit.found.late_s = found[kLate];

  const auto [seen, held_out] = split(motions);
  const RefinedModel blind = fitter.refit(seen, found);
  fit.error = fitter.error(held_out, blind.parameters, blind.spread);
  fit.error_before = fitter.error(held_out, fitter.prior().mean, blind.spread);
  for (int i = 0; i < kModelParameters; ++i) {
    ModelVector without = blind.parameters;
    without[i] = fitter.prior().mean[i];
    fit.better[static_cast<std::size_t>(i)] =
        fitter.error(held_out, without, blind.spread) > fit.error;
  }
  return fit;
}

}  // namespace marco::slam
