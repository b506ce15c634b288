// 10 000 drives in 100 worlds: what guard_runs_test does, until chance has no say.
#include <gtest/gtest.h>

#include "guard_runs.hpp"

namespace marco::drivers {
namespace {

using testing::Commander;
using testing::GuardRun;
using testing::GuardTally;

class GuardRunsLong : public ::testing::TestWithParam<Commander> {};
INSTANTIATE_TEST_SUITE_P(Commanders, GuardRunsLong, ::testing::ValuesIn(testing::kCommanders));

constexpr const char* kNames[] = {"random", "hostile", "jerky", "backwards"};

const char* name(Commander commander) { return kNames[static_cast<int>(commander)]; }

TEST_P(GuardRunsLong, NothingThatWasSeenIsTouchedFast) {
  GuardTally tally;
  for (int i = 0; i < 2500; ++i) {
    GuardRun run = testing::mixed_run(GetParam(), i / 100 + i);
    run.seconds = 10.0;
    tally.add(testing::drive(run, 1 + i % 100, 10'000 + i));
  }
  tally.print(name(GetParam()));
  EXPECT_EQ(tally.fast, 0);
}

TEST_P(GuardRunsLong, WithNoisyRanges) {
  GuardTally tally;
  for (int i = 0; i < 10 * testing::kMixtures; ++i) {
    GuardRun run = testing::mixed_run(GetParam(), i);
    run.noise_m = 0.01;
    tally.add(testing::drive(run, 1 + i % 100, 20'000 + i));
  }
  tally.print((name(GetParam()) + std::string(", ranges to 1 cm")).c_str());
  EXPECT_EQ(tally.fast, 0);
}

TEST_P(GuardRunsLong, TheBaseStandsNoMoreThanByTheSlowRule) {
  GuardTally guard, slow;
  for (int i = 0; i < 100; ++i) {
    GuardRun run = testing::mixed_run(GetParam(), 3 * i);
    guard.add(testing::drive(run, 1 + i % 100, 30'000 + i));
    run.rule = testing::Rule::swept_arc;
    slow.add(testing::drive(run, 1 + i % 100, 30'000 + i));
  }
  guard.print((name(GetParam()) + std::string(", guard")).c_str());
  slow.print((name(GetParam()) + std::string(", slow rule")).c_str());
  EXPECT_LE(guard.stopped_steps, slow.stopped_steps);
  EXPECT_EQ(guard.fast, 0);
}

}  // namespace
}  // namespace marco::drivers
