// A robot switched on anywhere in the simulated office, whose map was made on a tour before.
#include <gtest/gtest.h>

#include "tests/support/localization_office.hpp"

namespace marco::slam {
namespace {

using testing::Office;
using testing::TrialTally;

void run_office(int trials, uint64_t first_seed, double scans_per_s) {
  Office office;
  Localizer localizer(office.map(scans_per_s));
  TrialTally tally;
  for (int i = 0; i < trials; ++i) {
    run_trial(localizer, office.drive(first_seed + static_cast<uint64_t>(i), 5.0), tally);
  }
  tally.print("office");
  EXPECT_GE(tally.found, 0.95 * trials);
  EXPECT_EQ(tally.wrong, 0);
}

// Its margins were chosen on the seeds 1 to 60. Of six trials, as there were here once, a robot
// that finds itself in 97 of 100 fails one in a sixth of all runs.
TEST(LocalizationInOffice, RobotsSwitchedOnAnywhereFindThemselves) { run_office(20, 101, 2.0); }

TEST(LocalizationInOffice, DISABLED_AThousandOfThemDo) { run_office(1000, 1001, 4.0); }

}  // namespace
}  // namespace marco::slam
