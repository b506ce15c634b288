#pragma once

#include <string>
#include <vector>

#include "common/pose2.hpp"
#include "lcm_tools/base/options.hpp"
#include "simulator/simulation_options.hpp"

namespace marco::sim {

/// One step of a tour.
struct TourStep {
  std::string kind = "go";   ///< go (to x, y), face (a heading), sweep (the tilt), pan, wait
  std::vector<double> to_m;  ///< go
  double heading_deg = 0.0;  ///< face
  std::vector<double> pans_deg = {0};  ///< sweep: one sweep of the tilt at each
  double tilt_from_deg = -20.0;
  double tilt_to_deg = 45.0;
  double pan_from_deg = -90.0;  ///< pan, at tilt 0
  double pan_to_deg = 90.0;
  double rows = 100;     ///< sweep, pan: scans from one end to the other
  double seconds = 1.0;  ///< wait

  template <class Visitor>
  void visit(Visitor& v) {
    v("kind", kind);
    v("to_m", to_m);
    v("heading_deg", heading_deg);
    v("pans_deg", pans_deg);
    v("tilt_from_deg", tilt_from_deg, Limits{-90.0, 90.0});
    v("tilt_to_deg", tilt_to_deg, Limits{-90.0, 90.0});
    v("pan_from_deg", pan_from_deg, Limits{-720.0, 720.0});
    v("pan_to_deg", pan_to_deg, Limits{-720.0, 720.0});
    v("rows", rows, Limits{2.0, 10000.0});
    v("seconds", seconds, kNotNegative);
  }
};

/// A tour file (config/tours/*.toml).
struct Tour {
  std::vector<double> start_m = {0, 0};
  double start_heading_deg = 0.0;
  std::vector<TourStep> steps;

  template <class Visitor>
  void visit(Visitor& v) {
    v("start_m", start_m);
    v("start_heading_deg", start_heading_deg);
    v("steps", steps);
  }
};

/// The pose of the robot and the angles of its pan-tilt at one moment.
struct RobotState {
  Pose2 world_from_robot;
  double pan_rad = 0.0;
  double tilt_rad = 0.0;
};

/// A tour as a function of time: straight lines and turns on the spot with trapezoidal speed
/// profiles, the pan-tilt at constant rates. In closed form, independent of any step size.
class MotionPlan {
 public:
  /// @throws std::invalid_argument naming the invalid step.
  MotionPlan(const Tour& tour, const RobotOptions& robot, double scans_per_s);

  double duration_s() const { return phases_.empty() ? 0.0 : phases_.back().end_s; }
  RobotState at(double seconds) const;

 private:
  /// One quantity moves by `amount` from `start_s` to `end_s`.
  struct Phase {
    enum class Kind { drive, turn, pan, tilt, wait };
    Kind kind;
    double start_s;
    double end_s;
    double amount;        ///< m or rad
    double acceleration;  ///< 0 = constant rate
    RobotState from;
  };
  void append(Phase::Kind kind, double amount, double rate, double acceleration);
  void go(const TourStep& step);
  void turn_to(double heading_rad);
  void sweep(const TourStep& step, double scans_per_s);
  void pan(const TourStep& step, double scans_per_s);
  static RobotState advance(const Phase& phase, double seconds);

  RobotOptions robot_;
  RobotState now_;
  std::vector<Phase> phases_;
};

}  // namespace marco::sim
