#include "slam/calibration/self_calibration.hpp"

#include <algorithm>
#include <cmath>

#include "slam/calibration/beam_fit.hpp"
#include "slam/calibration/gyro_fit.hpp"
#include "slam/calibration/odometry_fit.hpp"

namespace marco::slam {
namespace {

constexpr double kClearCorrelation = 0.5;  // of turns, for a sign
// Reading odometry at other moments than its own has its price.
constexpr double kLeastLateS = 0.02;
constexpr double kGyroLateKnownS = 0.15;
// What scan matching gets wrong alike at each motion is in no residual: of simulated drives the
// laser's place came out up to 2 mm off, and the time 0.5 ms.
constexpr double kMatchedPlaceM = 1e-3, kMatchedTimeS = 3e-4;
// Nor is how speed changes between two samples of odometry: of 88 drawn drives with 0.2 to 0.8 s
// between them the time came out 2.4 % of that off (rms).
constexpr double kBetweenSamples = 0.025;

bool is_usable(const InputCheck& check) {
  return check.state == InputState::good || check.state == InputState::stalled;
}

int sign_of(const InputCheck& check) {
  if (!is_usable(check) || std::abs(check.turns.correlation) < kClearCorrelation) return 0;
  return check.turns.correlation < 0.0 ? -1 : 1;
}

std::vector<LaserMotion> mirrored(std::vector<LaserMotion> motions) {
  for (LaserMotion& motion : motions) {
    motion.moved = {motion.moved.x_m, -motion.moved.y_m, -motion.moved.theta_rad};
  }
  return motions;
}

// More motions make a long drive's values no better, only later.
std::vector<LaserMotion> evenly_taken(const std::vector<LaserMotion>& motions) {
  constexpr std::size_t kMost = 600;  // 5 to 15 minutes of driving
  std::vector<LaserMotion> taken;
  for (std::size_t i = 0; i < std::min(kMost, motions.size()); ++i) {
    taken.push_back(motions[i * motions.size() / std::min(kMost, motions.size())]);
  }
  return taken;
}

// Who counts turns the wrong way round.
struct TurnSigns {
  bool laser_upside_down = false;
  bool odometry_wrong = false;
  bool gyro_upside_down = false;
  bool is_guess = false;  ///< there are only two to compare
};

TurnSigns decide_signs(int odometry_by_laser, int gyro_by_laser) {
  TurnSigns signs;
  if (odometry_by_laser < 0 && gyro_by_laser > 0) {
    signs.odometry_wrong = true;
  } else if (odometry_by_laser < 0 && gyro_by_laser < 0) {
    signs.laser_upside_down = true;
  } else if (odometry_by_laser < 0) {
    signs.laser_upside_down = signs.is_guess = true;
  } else if (gyro_by_laser < 0) {
    // With odometry it is two against one; without, a gyroscope is turned round more often.
    signs.gyro_upside_down = true;
    signs.is_guess = odometry_by_laser == 0;
  }
  return signs;
}

class Calibrator {
 public:
  explicit Calibrator(const CalibrationInput& input)
      : input_(input),
        odometry_(input.odometry),
        gyro_(input.gyro_heading),
        motions_(evenly_taken(laser_motions(input.world_from_laser))) {}

  SelfCalibration run() {
    result_.calibration.laser = {"", input_.robot_from_laser.x_m, input_.robot_from_laser.y_m,
                                 rad_to_deg(input_.robot_from_laser.theta_rad),
                                 input_.laser_upside_down};
    result_.odometry =
        check_input(known_motions(motions_, odometry_), odometry_, InputKind::odometry);
    result_.gyro = check_input(known_motions(motions_, gyro_), gyro_, InputKind::gyro);
    signs_ = decide_signs(sign_of(result_.odometry), sign_of(result_.gyro));
    remark_on_inputs();
    if (is_usable(result_.odometry)) take_odometry();
    if (is_usable(result_.gyro)) take_gyro();
    remark_on_signs();
    return std::move(result_);
  }

 private:
  std::vector<LaserMotion> odometry_motions() const {
    const auto motions =
        evenly_taken(laser_motions(input_.world_from_laser, motion_length_s(odometry_)));
    return check_input(known_motions(motions, odometry_), odometry_, InputKind::odometry).moving;
  }

  void take_odometry() {
    const auto moving = odometry_motions();
    const auto motions = signs_.laser_upside_down ? mirrored(moving) : moving;
    TurnCorrelation turns = result_.odometry.turns;
    turns.slope = std::abs(turns.slope);
    const OdometryFit fit = fit_odometry(
        motions, odometry_, turns, signs_.odometry_wrong ? -1.0 : 1.0, input_.robot_from_laser);
    note_laser(fit);
    note_wheels(fit);
    if (fit.ambiguous_front) note_front(fit);
    if (fit.error_before > 0.0 && fit.error >= fit.error_before) {
      result_.remarks.emplace_back("no better than before on the held-out motions");
    }
  }

  void note_laser(const OdometryFit& fit) {
    LaserCalibration& laser = result_.calibration.laser;
    take(fit, kLaserX, "laser.x_m", laser.x_m, fit.robot_from_laser.x_m);
    take(fit, kLaserY, "laser.y_m", laser.y_m, fit.robot_from_laser.y_m);
    const double turned_rad =
        normalize_angle(fit.robot_from_laser.theta_rad - input_.robot_from_laser.theta_rad);
    take(fit, kLaserYaw, "laser.yaw_deg", laser.yaw_deg, laser.yaw_deg + rad_to_deg(turned_rad),
         rad_to_deg(1.0));
    if (std::abs(laser.yaw_deg) > 180.0) laser.yaw_deg -= std::copysign(360.0, laser.yaw_deg);
    const double assumed = input_.laser_upside_down ? 1.0 : 0.0;
    note_sign("laser.upside_down", signs_.laser_upside_down, assumed, 1.0 - assumed);
    laser.upside_down = signs_.laser_upside_down != input_.laser_upside_down;
    const bool changed = std::any_of(
        result_.parameters.begin(), result_.parameters.end(),
        [](const CalibratedParameter& p) { return p.verdict == ParameterVerdict::applied; });
    if (changed) laser.channel = input_.channel;
  }

  void note_wheels(const OdometryFit& fit) {
    OdometryCalibration& odometry = result_.calibration.odometry;
    note_sign("odometry.forward_sign", fit.found.forward_sign < 0.0, 1.0, -1.0);
    note_sign("odometry.turn_sign", fit.found.turn_sign < 0.0, 1.0, -1.0);
    odometry.forward_sign = fit.found.forward_sign;
    odometry.turn_sign = fit.found.turn_sign;
    odometry.axle_x_m = fit.found.axle_x_m;
    odometry.axle_yaw_deg = fit.found.axle_yaw_deg;
    take(fit, kLeftScale, "odometry.left_scale", odometry.left_scale, fit.found.left_scale);
    take(fit, kRightScale, "odometry.right_scale", odometry.right_scale, fit.found.right_scale);
    take(fit, kTrack, "odometry.track_scale", odometry.track_scale, fit.found.track_scale,
         1.0 / kCountedTrackM);
    take(fit, kLate, "odometry.late_s", odometry.late_s, fit.found.late_s);
  }

  // @param value  as assumed; changed where it is applied. @param unit  of one of the fit's
  void take(const OdometryFit& fit,
            ModelParameter parameter,
            const std::string& name,
            double& value,
            double found,
            double unit = 1.0) {
    const auto i = static_cast<std::size_t>(parameter);
    CalibratedParameter entry{name, value, found, 0.0, ParameterVerdict::not_observed, ""};
    if (fit.model.observed[i]) {
      entry.sigma = std::hypot(unit * std::sqrt(fit.model.covariance(parameter, parameter)),
                               systematic_of(fit, parameter));
      const double least = parameter == kLate ? kLeastLateS : 0.0;
      const bool far = std::abs(found - value) > std::max(kSure * entry.sigma, least);
      entry.verdict = !far            ? ParameterVerdict::as_assumed
                      : fit.better[i] ? ParameterVerdict::applied
                                      : ParameterVerdict::no_better;
    } else {
      entry.missing =
          to_string(parameter == kLate && fit.missing != Missing::motion ? Missing::changes_of_speed
                                                                         : fit.missing);
    }
    if (entry.verdict == ParameterVerdict::applied) value = found;
    result_.parameters.push_back(entry);
  }

  double systematic_of(const OdometryFit& fit, ModelParameter parameter) const {
    if (parameter == kLaserX || parameter == kLaserY) {
      return std::hypot(kMatchedPlaceM,
                        mean_way_to_samples_m(motions_, odometry_, fit.found.late_s));
    }
    if (parameter != kLate) return 0.0;
    return std::hypot(kMatchedTimeS, kBetweenSamples * odometry_.interval_s());
  }

  void note_sign(const std::string& name, bool changed, double before, double other) {
    result_.parameters.push_back(
        {name, before, changed ? other : before, 0.0,
         changed ? ParameterVerdict::applied : ParameterVerdict::as_assumed, ""});
  }

  void note_front(const OdometryFit& fit) {
    const bool counts_back = fit.found.forward_sign < 0.0;
    result_.remarks.emplace_back(
        counts_back
            ? "odometry counts distance with the wrong sign, or the laser looks back: both give "
              "the same map. The robot would mostly drive backwards, so odometry is corrected"
            : "the laser looks back, or odometry counts distance with the wrong sign: both give "
              "the same map. By its odometry the robot mostly drives forward, so odometry is "
              "trusted");
    for (CalibratedParameter& parameter : result_.parameters) {
      const bool other =
          parameter.name == (counts_back ? "laser.yaw_deg" : "odometry.forward_sign");
      if (other && parameter.verdict == ParameterVerdict::as_assumed) {
        parameter.verdict = ParameterVerdict::undecidable;
      }
    }
  }

  void take_gyro() {
    const InputCheck& check = result_.gyro;
    const auto motions = signs_.laser_upside_down ? mirrored(check.moving) : check.moving;
    const GyroFit fit = fit_gyro(motions, gyro_);
    GyroCalibration& gyro = result_.calibration.gyro;
    take_gyro("gyro.scale", gyro.scale, fit.found.scale, fit.sigma.scale, fit.better[0]);
    take_gyro("gyro.bias_rad_per_s", gyro.bias_rad_per_s, fit.found.bias_rad_per_s,
              fit.sigma.bias_rad_per_s, fit.better[1]);
    take_gyro("gyro.late_s", gyro.late_s, fit.found.late_s, fit.sigma.late_s, fit.better[2]);
  }

  void take_gyro(const std::string& name, double& value, double found, double sigma, bool better) {
    CalibratedParameter entry{name, value, found, sigma, ParameterVerdict::as_assumed, ""};
    if (name == "gyro.late_s" && sigma > kGyroLateKnownS) {
      entry.verdict = ParameterVerdict::not_observed;
      entry.missing = to_string(Missing::changes_of_speed);
    } else if (std::abs(found - value) > kSure * sigma) {
      entry.verdict = better ? ParameterVerdict::applied : ParameterVerdict::no_better;
    }
    if (entry.verdict == ParameterVerdict::applied) value = found;
    result_.parameters.push_back(entry);
  }

  void remark_on_inputs() {
    const auto remark = [&](const char* what, const InputCheck& check) {
      if (check.state == InputState::good || check.state == InputState::none) return;
      std::string text = std::string(what) + " " + to_string(check.state);
      if (check.state == InputState::stalled) {
        text += ": in " + std::to_string(std::lround(100.0 * check.stalled_share)) +
                " of 100 motions of the laser";
      }
      if (check.state == InputState::foreign) {
        text += ": another robot's, or noise (" + std::to_string(check.turns.turns) + " turns)";
      }
      result_.remarks.push_back(text);
    };
    remark("odometry", result_.odometry);
    remark("the gyroscope", result_.gyro);
  }

  void remark_on_signs() {
    if (!signs_.is_guess) return;
    result_.open_question =
        signs_.laser_upside_down
            ? "scans turn opposite to odometry: the laser is upside down, or odometry counts turns "
              "with the wrong sign. Odometry is trusted; if it is wrong, the map is a mirror "
              "image, and odometry.turn_sign = -1 (--calibration) fixes it"
            : "scans turn opposite to the gyroscope: one of both is upside down. The laser is "
              "trusted; if it is wrong, the map is a mirror image, and clockwise = true "
              "(--foreign) fixes it. If it is right, set gyro.scale = -1 (--calibration)";
  }

  const CalibrationInput& input_;
  OdometryTravel odometry_;
  OdometryTravel gyro_;
  std::vector<LaserMotion> motions_;
  TurnSigns signs_;
  SelfCalibration result_;
};

}  // namespace

const CalibratedParameter* SelfCalibration::find(const std::string& name) const {
  const auto found = std::find_if(parameters.begin(), parameters.end(),
                                  [&](const CalibratedParameter& p) { return p.name == name; });
  return found == parameters.end() ? nullptr : &*found;
}

std::string reason_of(const CalibratedParameter& parameter) {
  switch (parameter.verdict) {
    case ParameterVerdict::applied:
      return "applied";
    case ParameterVerdict::as_assumed:
      return "as assumed";
    case ParameterVerdict::no_better:
      return "no better in a trial";
    case ParameterVerdict::undecidable:
      return "the drive cannot decide";
    case ParameterVerdict::not_observed:
      break;
  }
  return "not observable: the drive lacks " + parameter.missing;
}

SelfCalibration self_calibrate(const CalibrationInput& input) { return Calibrator(input).run(); }

}  // namespace marco::slam
