#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include "slam/localization/localizer.hpp"

namespace marco::testing {

/// One scan of a trial and where it was really taken, in the map's frame.
struct TrialStep {
  slam::SlamInput input;
  Pose2 map_from_robot;
};

/// What became of robots that were switched on somewhere.
struct TrialTally {
  int trials = 0;
  int found = 0;                ///< within 10 cm and 2 degrees at the end of their drive
  int wrong = 0;                ///< said to be sure more than 50 cm or 10 degrees from the truth
  std::vector<double> path_m;   ///< until sure
  std::vector<double> error_m;  ///< at the end, of those that were sure
  std::vector<double> error_deg;
  std::vector<double> search_ms;  ///< of each scan that was searched in the whole map

  static double part(std::vector<double> values, double part) {
    if (values.empty()) return 0.0;
    std::sort(values.begin(), values.end());
    return values[static_cast<std::size_t>(part * static_cast<double>(values.size() - 1))];
  }
  void print(const std::string& name) const {
    std::printf(
        "%s: %d trials, %.1f %% within 10 cm / 2 deg, %d confident and wrong; driven until sure: "
        "median %.2f m, p95 %.2f m; error at the end: median %.3f m / %.2f deg, p95 %.3f m / %.2f "
        "deg; search median %.1f ms, p95 %.1f ms\n",
        name.c_str(), trials, 100.0 * found / std::max(1, trials), wrong, part(path_m, 0.5),
        part(path_m, 0.95), part(error_m, 0.5), part(error_deg, 0.5), part(error_m, 0.95),
        part(error_deg, 0.95), part(search_ms, 0.5), part(search_ms, 0.95));
  }
};

/// Switches the robot on at the first step and drives it through the others.
inline void run_trial(slam::Localizer& localizer,
                      const std::vector<TrialStep>& steps,
                      TrialTally& tally) {
  localizer.forget_place();
  ++tally.trials;
  bool sure = false, wrong = false;
  double driven_m = 0.0, error_m = 0.0, error_deg = 0.0;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (i > 0) {
      driven_m +=
          between(steps[i - 1].map_from_robot, steps[i].map_from_robot).translation_m().norm();
    }
    const bool was_localized = localizer.is_localized();
    const auto before = std::chrono::steady_clock::now();
    const slam::SlamUpdate update = localizer.process(steps[i].input);
    const double ms =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - before)
            .count();
    if (!was_localized && update.became_key) tally.search_ms.push_back(ms);
    if (update.status == slam::SlamUpdate::Status::lost) continue;
    if (!sure) tally.path_m.push_back(driven_m);
    sure = true;
    const Pose2 off = between(steps[i].map_from_robot, update.world_from_robot);
    error_m = off.translation_m().norm();
    error_deg = std::abs(rad_to_deg(off.theta_rad));
    wrong = wrong || error_m > 0.5 || error_deg > 10.0;
  }
  if (sure) {
    tally.error_m.push_back(error_m);
    tally.error_deg.push_back(error_deg);
  }
  if (wrong) ++tally.wrong;
  if (localizer.is_localized() && error_m <= 0.10 && error_deg <= 2.0) ++tally.found;
}

}  // namespace marco::testing
