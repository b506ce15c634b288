#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
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
  int found = 0;               ///< within 10 cm and 2 degrees at the end of their drive
  int wrong = 0;               ///< said to be sure more than 50 cm or 10 degrees from the truth
  std::vector<double> path_m;  ///< until sure
  std::vector<double> contradicted;  ///< part of the beams, when it became sure
  std::vector<double> error_m;       ///< at the end, of those that were sure
  std::vector<double> error_deg;
  std::vector<double> search_ms;  ///< CPU time of each scan that was searched in the whole map

  static double part(std::vector<double> values, double part) {
    if (values.empty()) return 0.0;
    std::sort(values.begin(), values.end());
    return values[static_cast<std::size_t>(part * static_cast<double>(values.size() - 1))];
  }
  void print(const std::string& name) const {
    std::printf(
        "%s: %d trials, %.1f %% within 10 cm / 2 deg, %d confident and wrong; driven until sure: "
        "median %.2f m, p95 %.2f m, contradicted then p50 %.3f p95 %.3f; error at the end: median "
        "%.3f m / %.2f deg, p95 %.3f m / %.2f "
        "deg; search median %.1f ms, p95 %.1f ms\n",
        name.c_str(), trials, 100.0 * found / std::max(1, trials), wrong, part(path_m, 0.5),
        part(path_m, 0.95), part(contradicted, 0.5), part(contradicted, 0.95), part(error_m, 0.5),
        part(error_deg, 0.5), part(error_m, 0.95), part(error_deg, 0.95), part(search_ms, 0.5),
        part(search_ms, 0.95));
  }
};

/// Of this thread: what a search costs, whatever else the machine does.
inline double cpu_ms() {
  timespec now = {};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

/// Switches the robot on at the first step and drives it through the others.
/// @returns what was wrong, "" when it found itself and never said otherwise.
inline std::string run_trial(slam::Localizer& localizer,
                             const std::vector<TrialStep>& steps,
                             TrialTally& tally) {
  localizer.forget_place();
  ++tally.trials;
  bool sure = false, wrong = false;
  slam::Agreement said;
  double driven_m = 0.0, error_m = 0.0, error_deg = 0.0;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (i > 0) {
      driven_m +=
          between(steps[i - 1].map_from_robot, steps[i].map_from_robot).translation_m().norm();
    }
    const bool was_localized = localizer.is_localized();
    const double before_ms = cpu_ms();
    const slam::SlamUpdate update = localizer.process(steps[i].input);
    if (!was_localized && update.became_key) tally.search_ms.push_back(cpu_ms() - before_ms);
    if (update.status == slam::SlamUpdate::Status::lost) continue;
    if (!sure) {
      tally.path_m.push_back(driven_m);
      tally.contradicted.push_back(localizer.estimate().candidates.front().contradicted());
      said = localizer.estimate().candidates.front();
    }
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
  const bool found = localizer.is_localized() && error_m <= 0.10 && error_deg <= 2.0;
  if (found) ++tally.found;
  if (found && !wrong) return {};
  char text[200];
  const slam::PlaceEstimate& estimate = localizer.estimate();
  const auto evidence = [&](std::size_t i) {
    return i < estimate.candidates.size() ? estimate.candidates[i].evidence() : 0.0;
  };
  std::snprintf(
      text, sizeof(text),
      "%s%s, off by %.2f m %.1f deg; %zu candidates, %.2f and %.2f; when sure %.2f explained, "
      "%.2f contradicted",
      wrong ? "WRONG, " : "", localizer.is_localized() ? "sure" : "not sure", error_m, error_deg,
      estimate.candidates.size(), evidence(0), evidence(1), said.explained, said.contradicted());
  return text;
}

}  // namespace marco::testing
