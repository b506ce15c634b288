// Odometry that lies for a while: the scans win. Truth is exact, and the bound on the whole path is
// 5 cm at noise of 1 cm a beam.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <optional>

#include "common/covariance.hpp"
#include "slam/slam.hpp"
#include "tests/support/flat_world.hpp"

namespace marco::slam {
namespace {

constexpr double kStepM = 0.1;

testing::FlatWorld hall() {
  testing::FlatWorld world;
  world.add_box(-7, -5, 7, 5);
  world.add_box(-4, -2, 4, 2);
  world.add_box(5.8, -0.5, 6.2, 0.1);
  world.add_box(-6.5, 3.0, -6.0, 3.6);
  world.add_box(1.0, -4.7, 2.1, -4.3);
  world.add_box(-2.0, -2.6, -1.6, -2.0);
  return world;
}

/// What the robot does between two scans and what odometry makes of it; nothing: it is silent.
struct Step {
  Pose2 moved;
  std::optional<Pose2> claimed;
};

Step honest(const Pose2& moved) { return {moved, moved}; }

void add(std::vector<Step>& steps, int count, const Step& step) {
  for (int i = 0; i < count; ++i) steps.push_back(step);
}

// Along the lower side of the hall, with `lie` in the middle of the way.
std::vector<Step> drive_with(const std::vector<Step>& lie) {
  std::vector<Step> steps;
  add(steps, 35, honest({kStepM, 0, 0}));
  steps.insert(steps.end(), lie.begin(), lie.end());
  add(steps, 20, honest({kStepM, 0, 0}));
  return steps;
}

// Largest error of the path [m].
double worst_error_m(const std::vector<Step>& steps) {
  const testing::FlatWorld world = hall();
  std::mt19937 random(31);
  Slam slam;
  const Pose2 start{-5.5, -3.5, 0.0};
  Pose2 truth = start, odom;
  std::vector<Pose2> path;
  for (std::size_t i = 0; i <= steps.size(); ++i) {
    bool speaks = true;
    if (i > 0) {
      truth = truth * steps[i - 1].moved;
      speaks = steps[i - 1].claimed.has_value();
      odom = odom * steps[i - 1].claimed.value_or(steps[i - 1].moved);
    }
    SlamInput input;
    input.scan.utime = Utime::from_us(static_cast<int64_t>(i) * 200000);
    input.scan.hits_in_robot = world.hits(truth, 0.01, &random);
    input.motion.utime = input.scan.utime;
    if (speaks) input.motion.odom_from_robot = odom;
    slam.process(input);
    path.push_back(between(start, truth));
  }
  slam.finish();
  const Trajectory found = slam.trajectory();
  double worst = 0.0;
  for (std::size_t i = 0; i < path.size(); ++i) {
    worst = std::max(worst,
                     (found[i].world_from_robot.translation_m() - path[i].translation_m()).norm());
  }
  return worst;
}

constexpr double kBoundM = 0.05;

TEST(LyingOdometry, WheelsThatSlipFor2MetresDoNotMoveTheRobot) {
  std::vector<Step> lie;
  add(lie, 20, {Pose2{}, Pose2{kStepM, 0, 0}});
  EXPECT_LT(worst_error_m(drive_with(lie)), kBoundM);
}

TEST(LyingOdometry, ARobotLiftedAndTurned90DegreesKnowsIt) {
  std::vector<Step> lie{{Pose2{0, 0, deg_to_rad(90)}, Pose2{}}};
  add(lie, 5, honest({}));
  add(lie, 1, {Pose2{0, 0, deg_to_rad(-90)}, Pose2{}});
  EXPECT_LT(worst_error_m(drive_with(lie)), kBoundM);
}

TEST(LyingOdometry, AJumpBeyondEverySearchDoesNotMoveTheRobot) {
  const std::vector<Step> jump{{Pose2{kStepM, 0, 0}, Pose2{1.2, -1.0, deg_to_rad(-80)}}};
  EXPECT_LT(worst_error_m(drive_with(jump)), kBoundM);
}

// The first scans are believed to be those of a robot that stands, until the odometry is found out.
TEST(LyingOdometry, OneThatNeverMovesLeavesEachScanInItsPlace) {
  std::vector<Step> steps;
  add(steps, 30, {Pose2{kStepM, 0, 0}, Pose2{}});
  EXPECT_LT(worst_error_m(steps), kBoundM);
}

// So slowly that no scan contradicts it: 3 cm at each.
TEST(LyingOdometry, OneThatStopsWorkingLeavesEachScanInItsPlace) {
  std::vector<Step> steps;
  add(steps, 60, honest({0.03, 0, 0}));
  add(steps, 60, {Pose2{0.03, 0, 0}, Pose2{}});
  EXPECT_LT(worst_error_m(steps), kBoundM);
}

// A base that told of a turn late and made up for it within one scan: it looks where nothing was
// seen before, and what is drawn where odometry says would be believed ever after.
TEST(LyingOdometry, AHeadingThatLeapsIsNotDrawn) {
  std::vector<Step> lie;
  add(lie, 6, {Pose2{0, 0, deg_to_rad(-7.0)}, Pose2{0, 0, deg_to_rad(-5.8)}});
  add(lie, 1, {Pose2{0, 0, deg_to_rad(-2.0)}, Pose2{0, 0, deg_to_rad(-50.0)}});
  add(lie, 10, honest({}));
  EXPECT_LT(worst_error_m(drive_with(lie)), kBoundM);
}

// Its scans fit as well as ours, where it is: up to a second of nothing else is ignored.
TEST(LyingOdometry, AnotherRobotsScansAmongOursMoveNothing) {
  const testing::FlatWorld world = hall();
  std::mt19937 random(32);
  Slam slam;
  const Pose2 start{-5.5, -3.5, 0.0};
  Pose2 truth = start;
  Utime now;
  const auto look = [&](const Pose2& from) {
    now = now + Duration::from_seconds(0.05);
    SlamInput input;
    input.scan.utime = now;
    input.scan.hits_in_robot = world.hits(from, 0.01, &random);
    input.motion = {now, between(start, truth), {}};
    return slam.process(input);
  };
  const auto off_m = [&](const SlamUpdate& update) {
    return (update.world_from_robot.translation_m() - between(start, truth).translation_m()).norm();
  };
  int believed = 0;
  for (int i = 0; i < 160; ++i) {
    truth = truth * Pose2{0.03, 0, 0};
    EXPECT_LT(off_m(look(truth)), 0.05) << i;
    if (i < 60) continue;
    // Now one, now a burst of half a second.
    for (int scan = i % 40 == 20 ? 10 : 1; scan > 0; --scan) {
      const SlamUpdate update = look(truth * Pose2{-0.6, -1.1, deg_to_rad(25)});
      believed += update.status == SlamUpdate::Status::matched ? 1 : 0;
      EXPECT_LT(off_m(update), 0.05) << i;
      EXPECT_FALSE(update.became_key);
    }
  }
  EXPECT_EQ(believed, 0);
  // Put there for good it finds itself.
  for (int i = 0; i < 30; ++i) look(truth * Pose2{-0.6, -1.1, deg_to_rad(25)});
  const Pose2 put = between(start, truth * Pose2{-0.6, -1.1, deg_to_rad(25)});
  EXPECT_LT((look(truth * Pose2{-0.6, -1.1, deg_to_rad(25)}).world_from_robot.translation_m() -
             put.translation_m())
                .norm(),
            0.05);
}

// Before a long wall that tells nothing of the way along it a person steps ahead, and a quarter of
// the scan with him. The odometry is right.
TEST(HonestOdometry, APersonWhoStepsAheadDoesNotHoldTheRobotBack) {
  constexpr double kSeenM = 8.0, kScanM = 0.26, kAheadM = 0.35;
  std::mt19937 random(33);
  Slam slam;
  Pose2 truth;
  double worst_m = 0.0;
  for (int i = 0; i < 8; ++i) {
    if (i > 0) truth = truth * Pose2{kScanM, 0, 0};
    const double person_m = 3.5 + (i == 7 ? kAheadM : 0.0);
    testing::FlatWorld world;
    world.add_chain({{-50.0, -1.5}, {50.0, -1.5}});
    world.add_box(person_m, 0.5, person_m + 0.5, 1.0);
    const Points2 hits = world.hits(truth, 0.01, &random);
    SlamInput input;
    input.scan.utime = Utime::from_us(static_cast<int64_t>(i) * 400000);
    input.scan.hits_in_robot.resize(2, hits.cols());
    Eigen::Index count = 0;
    for (Eigen::Index hit = 0; hit < hits.cols(); hit += 2) {
      if (hits.col(hit).norm() < kSeenM) input.scan.hits_in_robot.col(count++) = hits.col(hit);
    }
    input.scan.hits_in_robot.conservativeResize(2, count);
    input.motion = {input.scan.utime, truth, {}};
    const SlamUpdate update = slam.process(input);
    worst_m =
        std::max(worst_m, (update.world_from_robot.translation_m() - truth.translation_m()).norm());
    EXPECT_EQ(update.became_key, i % 2 == 0) << i;
  }
  EXPECT_LT(worst_m, 0.5 * kAheadM);
}

TEST(LyingOdometry, ReverseCountedForwardGoesBack) {
  std::vector<Step> lie;
  add(lie, 20, {Pose2{-kStepM, 0, 0}, Pose2{kStepM, 0, 0}});
  EXPECT_LT(worst_error_m(drive_with(lie)), kBoundM);
}

TEST(LyingOdometry, FiveSecondsOfSilenceAreBridgedByTheScans) {
  std::vector<Step> lie;
  add(lie, 12, {Pose2{kStepM, 0, 0}, std::nullopt});
  add(lie, 13, {Pose2{kStepM, 0, deg_to_rad(2)}, std::nullopt});
  EXPECT_LT(worst_error_m(drive_with(lie)), kBoundM);
}

// Wheels that spin before furniture. A scan drawn at each step would be all that the next one is
// matched with.
TEST(LyingOdometry, AScanThatComesBackToItsPlaceIsDrawnNoSooner) {
  const testing::FlatWorld world = hall();
  std::mt19937 random(31);
  Slam slam;
  const Pose2 start{-5.5, -3.5, 0.0};
  Pose2 truth = start, odom;
  std::size_t keys_before = 0;
  for (int i = 0; i < 60; ++i) {
    const bool spins = i >= 50;
    odom = odom * Pose2{0.03, 0, 0};
    if (!spins) truth = truth * Pose2{0.03, 0, 0};
    if (i == 50) keys_before = slam.key_count();
    SlamInput input;
    input.scan.utime = Utime::from_us(static_cast<int64_t>(i) * 100000);
    input.scan.hits_in_robot = world.hits(truth, 0.01, &random);
    input.motion = {input.scan.utime, odom, {}};
    slam.process(input);
  }
  EXPECT_LE(slam.key_count(), keys_before + 1);
}

// A robot that stands, its stamps off by a millisecond. One scan of 361 beams at 1 cm tells the
// place to 1.5 mm an axis: matched one by one, the worst of 600 would be off by 5 mm.
void stand(int scans, double period_s, unsigned seed) {
  const testing::FlatWorld world = hall();
  std::mt19937 random(seed);
  std::uniform_int_distribution<int64_t> jitter_us(-1000, 1000);
  Slam slam;
  double worst_m = 0.0, worst_deg = 0.0;
  for (int i = 0; i < scans; ++i) {
    SlamInput input;
    input.scan.utime = Utime::from_us(std::llround(1e6 * period_s * i) + jitter_us(random));
    input.scan.hits_in_robot = world.hits({-5.5, -3.5, 0.3}, 0.01, &random);
    input.motion = {input.scan.utime, Pose2{}, {}};
    const SlamUpdate update = slam.process(input);
    worst_m = std::max(worst_m, update.world_from_robot.translation_m().norm());
    worst_deg = std::max(worst_deg, std::abs(rad_to_deg(update.world_from_robot.theta_rad)));
  }
  std::printf("%d scans: %.2f mm, %.3f deg off at most\n", scans, 1e3 * worst_m, worst_deg);
  EXPECT_LT(worst_m, 0.002);
  EXPECT_LT(worst_deg, 0.05);
  EXPECT_EQ(slam.key_count(), 1U);
}

TEST(ZeroVelocityUpdate, ThePoseStaysForAnHourOfScansEverySixSeconds) {
  for (const unsigned seed : {5U, 15U, 25U}) stand(600, 6.0, seed);
}

TEST(ZeroVelocityUpdate, ThePoseStaysForAMinuteOfTenScansASecond) {
  for (const unsigned seed : {6U, 16U, 26U}) stand(600, 0.1, seed);
}

// A robot that stood for a while, pushed aside by 1 cm a scan with its wheels still.
TEST(ZeroVelocityUpdate, ARobotThatIsPushedSlowlyIsFollowed) {
  const testing::FlatWorld world = hall();
  std::mt19937 random(6);
  Slam slam;
  const Pose2 start{-5.5, -3.5, 0.3};
  for (int i = 0; i < 150; ++i) {
    const Pose2 truth = start * Pose2{0, 0.01 * std::max(0, i - 50), 0};
    SlamInput input;
    input.scan.utime = Utime::from_us(static_cast<int64_t>(i) * 200000);
    input.scan.hits_in_robot = world.hits(truth, 0.01, &random);
    input.motion = {input.scan.utime, Pose2{}, {}};
    const SlamUpdate update = slam.process(input);
    // What is not yet taken for a push, and one scan's noise.
    EXPECT_LT(
        (update.world_from_robot.translation_m() - between(start, truth).translation_m()).norm(),
        0.02)
        << i;
  }
}

// Two bare walls: the way along them is odometry's alone, 2 % too long here; it must come out
// neither shortened nor doubled, and be known no better than that.
TEST(Corridor, ABareCorridorIsAsLongAsOdometrySaysAndKnownNoBetter) {
  testing::FlatWorld corridor;
  corridor.add_chain({{-100, -1}, {100, -1}});
  corridor.add_chain({{-100, 1}, {100, 1}});
  std::mt19937 random(8);
  Slam slam;
  SlamUpdate update;
  constexpr int kScans = 300;
  Pose2 odom;
  for (int i = 0; i <= kScans; ++i) {
    if (i > 0) odom = odom * Pose2{1.02 * kStepM, 0, 0};
    SlamInput input;
    input.scan.utime = Utime::from_us(static_cast<int64_t>(i) * 200000);
    input.scan.hits_in_robot = corridor.hits({kStepM * i, 0, 0}, 0.01, &random);
    input.motion = {input.scan.utime, odom, {}};
    update = slam.process(input);
  }
  const double error_m = update.world_from_robot.x_m - kStepM * kScans;
  EXPECT_LT(std::abs(error_m), 0.03 * kStepM * kScans);
  EXPECT_LT(std::abs(update.world_from_robot.y_m), 0.02);
  // Inside the covariance: two standard deviations along the corridor, and far less across it.
  EXPECT_LT(std::abs(error_m), 2.0 * std::sqrt(update.covariance(0, 0)));
  EXPECT_LT(std::sqrt(update.covariance(1, 1)), 0.02);
  // An edge of the graph holds what is unknown since the keyframe before, not since the start.
  const PoseGraphEdge edge = slam.state().back_end.edges.back();
  EXPECT_LT(std::sqrt(covariance_of(edge.information)(0, 0)),
            0.5 * edge.from_from_to.translation_m().norm());
}

}  // namespace
}  // namespace marco::slam
