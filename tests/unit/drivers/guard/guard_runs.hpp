#pragma once

#include <array>
#include <cstdio>

#include "guard_run.hpp"

namespace marco::drivers::testing {

constexpr std::array kCommanders{Commander::random, Commander::hostile, Commander::jerky,
                                 Commander::backwards};
constexpr std::array kViewsDeg{360.0, 180.0, 240.0};
constexpr std::array kDelaysS{0.1, 0.05, 0.3};
constexpr std::array kControlHz{50.0, 20.0};
/// One of each view, delay and rate.
constexpr int kMixtures = 18;

inline GuardRun mixed_run(Commander commander, int mixture) {
  GuardRun run;
  run.commander = commander;
  run.view_deg = kViewsDeg[static_cast<std::size_t>(mixture % 3)];
  run.delay_s = kDelaysS[static_cast<std::size_t>(mixture / 3 % 3)];
  run.control_hz = kControlHz[static_cast<std::size_t>(mixture / 9 % 2)];
  return run;
}

struct GuardTally {
  int runs = 0, touched = 0, fast = 0, unseen = 0;
  int64_t steps = 0, stopped_steps = 0;
  double way_m = 0.0;

  void add(const GuardOutcome& outcome) {
    constexpr double kSlowMPerS = 0.02;
    ++runs;
    steps += outcome.steps;
    stopped_steps += outcome.stopped_steps;
    way_m += outcome.way_m;
    if (!outcome.touch) return;
    // What no beam met in the last 30 s the guard cannot know.
    if (!outcome.touch->was_seen) {
      ++unseen;
    } else {
      ++touched;
      fast += outcome.touch->speed_m_per_s > kSlowMPerS ? 1 : 0;
    }
  }
  double stopped_part() const {
    return static_cast<double>(stopped_steps) / static_cast<double>(steps);
  }
  void print(const char* what) const {
    std::printf(
        "%s: %d runs, %.0f m, touched %d, %d of these faster than 2 cm/s, touched unseen "
        "%d; no motion at %.3f of the steps\n",
        what, runs, way_m, touched, fast, unseen, stopped_part());
  }
};

/// World and drive are drawn by their numbers.
inline GuardOutcome drive(const GuardRun& run, unsigned world_seed, unsigned drive_seed) {
  std::mt19937 random(world_seed);
  const GuardWorld world = GuardWorld::random(random);
  return GuardDrive(run, world, drive_seed).drive();
}

}  // namespace marco::drivers::testing
