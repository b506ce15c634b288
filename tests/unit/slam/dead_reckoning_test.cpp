#include "slam/front_end/dead_reckoning.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "common/covariance.hpp"
#include "tests/support/matchers.hpp"

namespace marco::slam {
namespace {

using ::marco::testing::IsNear;

constexpr double kPeriodS = 0.2;

Utime stamp(double seconds) { return Utime::from_seconds(seconds); }

// The robot turns on the spot by fits and starts.
Pose2 move(double period_s, double time_s) {
  return {0.0, 0.0, period_s * 0.5 * (1.0 + std::sin(0.5 * time_s))};
}

// Root mean square of the last guesses' error of the heading, and what repeating the last move
// would err by.
struct HeadingErrors {
  double guessed_rad, repeated_rad;
};
HeadingErrors heading_errors(DeadReckoning& reckoning,
                             const std::vector<double>& stamps_s,
                             const std::vector<Pose2>& moves) {
  double guessed = 0.0, repeated = 0.0;
  int count = 0;
  for (std::size_t i = 0; i < stamps_s.size(); ++i) {
    const MotionGuess guess = reckoning.guess(stamp(stamps_s[i]));
    if (i > stamps_s.size() / 2 && guess.source == MotionGuess::Source::velocity) {
      guessed += std::pow(guess.before_from_now.theta_rad - moves[i].theta_rad, 2.0);
      repeated += std::pow(moves[i - 1].theta_rad - moves[i].theta_rad, 2.0);
      ++count;
    }
    reckoning.update(stamp(stamps_s[i]), kPeriodS, moves[i], true);
  }
  return {std::sqrt(guessed / count), std::sqrt(repeated / count)};
}

TEST(DeadReckoning, ByTheTimeWhereScansAreMissing) {
  std::mt19937 random(5);
  std::bernoulli_distribution missing(0.5);
  DeadReckoning reckoning({});
  std::vector<double> stamps_s;
  std::vector<Pose2> moves;
  for (int i = 0; i < 400; ++i) {
    const Pose2 step = move(kPeriodS, kPeriodS * i);
    if (!stamps_s.empty() && missing(random)) continue;
    const double passed_s = stamps_s.empty() ? kPeriodS : kPeriodS * i - stamps_s.back();
    stamps_s.push_back(kPeriodS * i);
    moves.push_back({0.0, 0.0, step.theta_rad * passed_s / kPeriodS});
  }
  const HeadingErrors errors = heading_errors(reckoning, stamps_s, moves);
  EXPECT_LT(errors.guessed_rad, 0.5 * errors.repeated_rad);
  EXPECT_LT(reckoning.state().clock_contest, 0.0);
}

TEST(DeadReckoning, ByTheScansWhereStampsAreIrregular) {
  std::mt19937 random(6);
  std::bernoulli_distribution stalls(0.4);
  DeadReckoning reckoning({});
  std::vector<double> stamps_s;
  std::vector<Pose2> moves;
  double written_s = 0.0;
  for (int i = 0; i < 400; ++i) {
    moves.push_back(move(kPeriodS, kPeriodS * i));
    written_s = stalls(random) ? written_s + 0.001 : std::max(written_s + 0.001, kPeriodS * i);
    stamps_s.push_back(written_s);
  }
  EXPECT_LT(heading_errors(reckoning, stamps_s, moves).guessed_rad, 0.02);
  EXPECT_GT(reckoning.state().clock_contest, 0.0);
}

TEST(DeadReckoning, AfterAGapItKnowsNothing) {
  DeadReckoning reckoning({});
  for (int i = 0; i < 20; ++i) reckoning.update(stamp(0.2 * i), 0.2, {0.1, 0, 0}, true);
  EXPECT_THAT(reckoning.guess(stamp(4.0)).before_from_now, IsNear(Pose2{0.1, 0, 0}, 1e-3, 1e-9));
  const MotionGuess late = reckoning.guess(stamp(9.0));
  EXPECT_EQ(late.source, MotionGuess::Source::nothing);
  EXPECT_GT(late.covariance()(0, 0), 1.0);
}

// A scan every two seconds; after each second one, the next scan is missing.
TEST(DeadReckoning, GapsAreNoIrregularStamps) {
  DeadReckoning reckoning({});
  double time_s = 0.0;
  for (int i = 0; i < 40; ++i) {
    const double passed_s = i % 3 == 2 ? 4.0 : 2.0;
    time_s += passed_s;
    reckoning.update(stamp(time_s), 2.0, {0.5 * passed_s, 0, 0}, true);
  }
  EXPECT_EQ(reckoning.state().clock_contest, 0.0);
  EXPECT_EQ(reckoning.guess(stamp(time_s + 2.0)).source, MotionGuess::Source::nothing);
}

// Three seconds of six scan periods: scans are missing, and none was stamped late.
TEST(DeadReckoning, NoLoggerStallsForSeconds) {
  DeadReckoning reckoning({});
  for (int i = 0; i < 40; ++i) reckoning.update(stamp(0.5 * (i - i % 2)), 0.5, {0.25, 0, 0}, true);
  EXPECT_GT(reckoning.state().clock_contest, 0.0);
  EXPECT_EQ(reckoning.guess(stamp(19.4)).source, MotionGuess::Source::velocity);
  EXPECT_EQ(reckoning.guess(stamp(22.0)).source, MotionGuess::Source::nothing);
}

TEST(DeadReckoning, AMoveThatNoScanFoundJudgesNothing) {
  DeadReckoning reckoning({});
  for (int i = 0; i < 20; ++i)
    reckoning.update(stamp(i % 2 == 0 ? 0.2 * i : 0.2 * i + 0.15), 0.2, {0.1, 0, 0.1}, false);
  EXPECT_EQ(reckoning.state().clock_contest, 0.0);
}

// A match finds the pose at the scan's middle; that at its first beam it finds off by what the scan
// was deskewed wrongly. The velocity must not follow.
TEST(DeadReckoning, VelocityDoesNotFeedBackThroughTheScansThatItDeskews) {
  DeadReckoning reckoning({});
  const Velocity2 truth{0.5, 0.0, 2.0};
  Pose2 world_from_before;
  for (int i = 0; i < 20; ++i) {
    const Pose2 world_from_middle = truth.after(kPeriodS * i + 0.5 * kPeriodS);
    const Velocity2 wrong{0.5, 0.0, i % 2 == 0 ? 3.0 : 1.0};
    const Pose2 now_from_middle = wrong.after(0.5 * kPeriodS);
    const Pose2 world_from_now = world_from_middle * now_from_middle.inverse();
    const Pose2 before_from_now = between(world_from_before, world_from_now);
    if (i > 2) {
      EXPECT_THAT(reckoning.guess(stamp(kPeriodS * i), now_from_middle).before_from_now,
                  IsNear(before_from_now, 2e-3, 1e-9));
      const auto shown =
          reckoning.velocity_to(stamp(kPeriodS * i), between(world_from_before, world_from_middle));
      EXPECT_NEAR(shown->yaw_rad_per_s, 2.0, 1e-9);
      EXPECT_NEAR(reckoning.smoothed_velocity().yaw_rad_per_s, 2.0, 1e-9);
    }
    reckoning.update(stamp(kPeriodS * i), kPeriodS, before_from_now, true, now_from_middle);
    world_from_before = world_from_now;
  }
}

}  // namespace
}  // namespace marco::slam
