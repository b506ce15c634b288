// Somebody drives a guarded base at random, or as badly as he can: guard_runs_long_test has more.
#include "guard_runs.hpp"

#include <gtest/gtest.h>

namespace marco::drivers {
namespace {

using testing::Commander;
using testing::GuardRun;
using testing::GuardTally;

class GuardRuns : public ::testing::TestWithParam<Commander> {};
INSTANTIATE_TEST_SUITE_P(Commanders, GuardRuns, ::testing::ValuesIn(testing::kCommanders));

TEST_P(GuardRuns, NothingThatWasSeenIsTouched) {
  constexpr int kRuns = 3 * testing::kMixtures;
  GuardTally tally;
  for (int i = 0; i < kRuns; ++i) {
    GuardRun run = testing::mixed_run(GetParam(), i);
    run.seconds = 6.0;
    tally.add(testing::drive(run, 100 + i, 500 + i));
  }
  tally.print("guard");
  EXPECT_EQ(tally.touched, 0);
  EXPECT_GT(tally.way_m, 0.5 * kRuns);
}

// Both rules on the same orders in the same worlds.
TEST_P(GuardRuns, TheBaseStandsNoMoreThanByTheSlowRule) {
  GuardTally guard, slow;
  for (int i = 0; i < 6; ++i) {
    GuardRun run = testing::mixed_run(GetParam(), 3 * i);  // all around
    run.seconds = 8.0;
    guard.add(testing::drive(run, 700 + i, 800 + i));
    run.rule = testing::Rule::swept_arc;
    slow.add(testing::drive(run, 700 + i, 800 + i));
  }
  EXPECT_LE(guard.stopped_steps, slow.stopped_steps);
}

}  // namespace
}  // namespace marco::drivers
