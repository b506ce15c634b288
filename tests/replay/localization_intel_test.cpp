// The last third of a real log, localized in the map of the first two thirds.
#include <gtest/gtest.h>

#include "tests/support/localization_recorded.hpp"
#include "tests/support/real_data.hpp"

namespace marco::slam {
namespace {

using testing::SplitLog;
using testing::TrialTally;

class LocalizationInIntel : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* folder = marco::testing::real_data();
    if (folder == nullptr) GTEST_SKIP();
    const std::string intel = std::string(folder) + "/intel/intel";
    split_.emplace(intel + ".log", intel + ".relations");
  }
  std::optional<SplitLog> split_;
};

TEST_F(LocalizationInIntel, SwitchedOnAnywhereItFindsItselfWithinFiveMetres) {
  Localizer localizer(split_->map());
  TrialTally tally;
  for (const SplitLog::Trial& trial : split_->trials(5.0)) {
    run_trial(localizer, trial.steps, tally);
  }
  tally.print("intel");
  EXPECT_GE(tally.trials, 90);
  EXPECT_GE(tally.found, 0.95 * tally.trials);
  EXPECT_EQ(tally.wrong, 0);
}

// A third of its scans see what the map does not hold: rooms whose doors were closed before.
TEST_F(LocalizationInIntel, OnceFoundItIsNotLostWhereTheMapKnowsLittle) {
  Localizer localizer(split_->map());
  for (const SlamInput& input : split_->rest()) localizer.process(input);
  const SplitLog::Errors errors = split_->errors(localizer.trajectory());
  std::printf("intel tracked: lost %d times; %d relations, error mean %.4f m, max %.3f m\n",
              localizer.times_lost(), errors.count, errors.mean_m, errors.max_m);
  EXPECT_EQ(localizer.times_lost(), 0);
  EXPECT_EQ(localizer.findings().size(), 1U);
  EXPECT_GE(errors.count, 100);
  EXPECT_LE(errors.mean_m, 0.0195);
  EXPECT_LE(errors.max_m, 0.11);
}

}  // namespace
}  // namespace marco::slam
