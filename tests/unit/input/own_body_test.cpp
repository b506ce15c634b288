#include "common/input/own_body.hpp"

#include <gmock/gmock.h>

#include <functional>
#include <limits>
#include <random>

#include "tests/support/flat_world.hpp"

namespace marco {
namespace {

using ::testing::HasSubstr;

/// What a robot's laser has to do with its body.
using OnBoard = std::function<void(LaserScan&, std::mt19937&)>;

void nothing(LaserScan&, std::mt19937&) {}

// A post 0.3 m away from bearing 30 to 36 deg, in half a degree's beams.
void post(LaserScan& scan, std::mt19937& random) {
  std::normal_distribution<float> noise(0.30F, 0.006F);
  for (std::size_t beam = 240; beam <= 252; ++beam) scan.ranges_m[beam] = noise(random);
}

// Round a ring of corridors, so far from the outer wall; turning by steps of 9 deg in corners.
OwnBody after_the_ring(const OnBoard& on_board, double from_wall_m) {
  testing::FlatWorld ring;
  ring.add_box(-7, -5, 7, 5);
  ring.add_box(-4, -2, 4, 2);
  ring.add_box(5.6, -0.5, 6.0, 0.1);
  std::mt19937 random(3);
  std::normal_distribution<double> wanders(0.0, 0.003);
  OwnBody body;
  Pose2 robot{-7.0 + from_wall_m, -5.0 + from_wall_m, 0.0};
  for (int side = 0; side < 8; ++side) {
    const double length_m = (side % 2 == 0 ? 14.0 : 10.0) - 2.0 * from_wall_m;
    for (double driven_m = 0.0; driven_m < length_m + 1.0; driven_m += 0.1) {
      const bool turns = driven_m >= length_m;
      robot = robot * (turns ? Pose2{0, 0, deg_to_rad(9)} : Pose2{0.1, wanders(random), 0});
      LaserScan scan = ring.scan(robot, 0.01, &random);
      on_board(scan, random);
      body.look(scan);
    }
  }
  return body;
}

TEST(OwnBody, APostOnTheRobotIsFound) {
  const OwnBody body = after_the_ring(post, 1.5);
  ASSERT_EQ(body.parts().size(), 1U);
  const BodyPart& part = body.parts().front();
  EXPECT_EQ(part.channel, "LIDAR");
  EXPECT_NEAR(part.first_deg, 30.0, 1.0);
  EXPECT_NEAR(part.last_deg, 36.0, 1.0);
  EXPECT_NEAR(part.within_m, 0.36, 0.02);
  EXPECT_THAT(describe(body.parts()), HasSubstr("the robot itself is in view of LIDAR: "));
}

TEST(OwnBody, WallsThatAreFollowedAreNoBody) {
  for (const double from_wall_m : {0.3, 0.5, 0.8}) {
    const OwnBody body = after_the_ring(nothing, from_wall_m);
    EXPECT_GT(body.samples(), 40) << from_wall_m;
    EXPECT_TRUE(body.parts().empty()) << from_wall_m << ": " << describe(body.parts());
  }
}

TEST(OwnBody, AStandingRobotShowsNothing) {
  const testing::FlatWorld room = testing::small_room();
  std::mt19937 random(5);
  OwnBody body;
  for (int i = 0; i < 300; ++i) {
    LaserScan scan = room.scan({1.2, -0.6, 0.3}, 0.01, &random);
    // Somebody walks by.
    for (std::size_t beam = 0; beam < 40; ++beam) {
      scan.ranges_m[(beam + 7 * static_cast<std::size_t>(i)) % scan.size()] = 0.9F;
    }
    body.look(scan);
  }
  EXPECT_EQ(body.samples(), 0);
  EXPECT_TRUE(body.parts().empty()) << describe(body.parts());
}

TEST(OwnBody, PartsThatAreTakenOffAreForgotten) {
  OwnBody body = after_the_ring(post, 1.5);
  const testing::FlatWorld room = testing::small_room();
  std::mt19937 random(5);
  for (int i = 0; i < 200; ++i) body.look(room.scan({0.0, 0.0, 0.3 * i}, 0.01, &random));
  EXPECT_TRUE(body.parts().empty()) << describe(body.parts());
}

// A room that changes from scan to scan, by a beam in the middle of each degree.
LaserScan changing_scan(std::mt19937& random) {
  std::uniform_real_distribution<float> changing(1.5F, 9.0F);
  LaserScan scan;
  scan.first_bearing_rad = deg_to_rad(0.5);
  scan.bearing_step_rad = deg_to_rad(1.0);
  for (int beam = 0; beam < 360; ++beam) scan.ranges_m.push_back(changing(random));
  return scan;
}

// What is found in 61 such scans, of which 60 count; `on_board` also knows which one it is.
std::vector<BodyPart> found_by(
    const std::function<void(LaserScan&, int, std::mt19937&)>& on_board) {
  std::mt19937 random(11);
  OwnBody body;
  for (int i = 0; i < 61; ++i) {
    LaserScan scan = changing_scan(random);
    on_board(scan, i, random);
    body.look(scan);
  }
  return body.parts();
}

void fill(LaserScan& scan, std::size_t first, std::size_t last, float range_m) {
  for (std::size_t beam = first; beam <= last; ++beam) scan.ranges_m[beam % 360] = range_m;
}

TEST(OwnBody, MoreThanHalfOfTheViewIsNoBody) {
  const auto parts_with = [](std::size_t constant_beams) {
    return found_by([&](LaserScan& scan, int, auto&) { fill(scan, 20, 19 + constant_beams, 0.3F); })
        .size();
  };
  EXPECT_EQ(parts_with(180), 1U);
  EXPECT_EQ(parts_with(181), 0U);
}

TEST(OwnBody, APartReachesFromItsFirstDegreeToItsLastAndToItsFarthestReturn) {
  const auto parts = found_by([](LaserScan& scan, int, auto&) {
    for (std::size_t beam = 20; beam <= 30; ++beam) {
      scan.ranges_m[beam] = 0.3F + 0.01F * static_cast<float>(beam - 20);
    }
  });
  ASSERT_EQ(parts.size(), 1U);
  EXPECT_EQ(parts[0].first_deg, 20.0);
  EXPECT_EQ(parts[0].last_deg, 31.0);
  EXPECT_GT(parts[0].within_m, 0.43);
  EXPECT_LT(parts[0].within_m, 0.48);
}

// Of beams somewhat more than a degree apart none falls into some degrees.
TEST(OwnBody, APartAheadOfTheLaserIsOneEvenWhereADegreeHasNoBeam) {
  const auto parts = found_by([](LaserScan& scan, int, auto&) {
    fill(scan, 350, 365, 0.3F);
    fill(scan, 353, 353, 0.0F);
    fill(scan, 359, 359, 0.0F);
  });
  ASSERT_EQ(parts.size(), 1U);
  EXPECT_EQ(parts[0].first_deg, 350.0);
  EXPECT_EQ(parts[0].last_deg, 366.0);
}

TEST(OwnBody, PartsOnEitherSideOfAheadAreTwo) {
  const auto parts = found_by([](LaserScan& scan, int, auto&) {
    fill(scan, 340, 350, 0.3F);
    fill(scan, 10, 20, 0.5F);
  });
  ASSERT_EQ(parts.size(), 2U);
  EXPECT_EQ(parts[0].first_deg, 10.0);
  EXPECT_EQ(parts[1].last_deg, 351.0);
}

// Beside it on one side the range changes by little, as along a wall that leads away.
TEST(OwnBody, WhatContinuesOnOneSideIsAWall) {
  std::uniform_real_distribution<float> along(0.25F, 0.39F);
  for (const std::size_t beside : {15, 31}) {
    EXPECT_TRUE(found_by([&](LaserScan& scan, int, std::mt19937& random) {
                  fill(scan, 20, 30, 0.3F);
                  for (std::size_t i = 0; i < 5; ++i) scan.ranges_m[beside + i] = along(random);
                }).empty())
        << beside;
  }
}

TEST(OwnBody, BesideAPartTheViewMayHaveNoReturn) {
  EXPECT_EQ(found_by([](LaserScan& scan, int, auto&) {
              fill(scan, 10, 40, 0.0F);
              fill(scan, 20, 30, 0.3F);
            }).size(),
            1U);
}

TEST(OwnBody, APartThatIsCoveredInOneScanOfTenIsFoundAndOneOfSevenInTenIsNot) {
  const auto parts_hidden_in = [](int scans_of_ten) {
    return found_by([=](LaserScan& scan, int i, auto&) {
      fill(scan, 20, 30, i % 10 < scans_of_ten ? 0.15F : 0.3F);
    });
  };
  EXPECT_EQ(parts_hidden_in(1).size(), 1U);
  EXPECT_EQ(parts_hidden_in(3).size(), 0U);
}

// A first return that is off by the noise of a cheap laser does not decide.
TEST(OwnBody, ThePartIsWhereMostOfItsReturnsAre) {
  std::uniform_real_distribution<float> noisy(0.281F, 0.319F);
  EXPECT_EQ(found_by([&](LaserScan& scan, int i, std::mt19937& random) {
              for (std::size_t beam = 20; beam <= 30; ++beam) {
                scan.ranges_m[beam] = i < 2 ? 0.28F : noisy(random);
              }
            }).size(),
            1U);
}

TEST(OwnBody, CodesForNoReturnAreNoBody) {
  EXPECT_TRUE(found_by([](LaserScan& scan, int, auto&) {
                fill(scan, 20, 30, -1.0F);
                fill(scan, 60, 70, std::numeric_limits<float>::infinity());
              }).empty());
}

// Of two beams in each degree one passes by.
TEST(OwnBody, OfTheBeamsInADegreeTheNearestCounts) {
  for (const std::size_t on_part : {0, 1}) {
    std::mt19937 random(11);
    OwnBody body;
    for (int i = 0; i < 40; ++i) {
      LaserScan scan = changing_scan(random), other = changing_scan(random);
      scan.first_bearing_rad = deg_to_rad(0.25);
      scan.bearing_step_rad = deg_to_rad(0.5);
      scan.ranges_m.insert(scan.ranges_m.end(), other.ranges_m.begin(), other.ranges_m.end());
      for (std::size_t deg = 20; deg <= 30; ++deg) scan.ranges_m[2 * deg + on_part] = 0.3F;
      body.look(scan);
    }
    EXPECT_EQ(body.parts().size(), 1U) << on_part;
  }
}

TEST(OwnBody, TwentyScansAreEnoughAndAreToldOnce) {
  std::mt19937 random(11);
  OwnBody body;
  for (int i = 0; i < 30; ++i) {
    LaserScan scan = changing_scan(random);
    fill(scan, 20, 30, 0.3F);
    EXPECT_EQ(body.look(scan), i == 20) << i;  // the first is only compared with
    EXPECT_EQ(body.samples(), i);
    EXPECT_EQ(body.parts().size(), i < 20 ? 0U : 1U);
  }
}

// Through a window or from a shiny floor some returns come and go, and far ones are rough.
TEST(OwnBody, ReturnsThatComeAndGoOrAreRoughAreNoChange) {
  std::mt19937 random(11);
  std::uniform_real_distribution<float> rough(7.8F, 8.2F);
  OwnBody body;
  for (int i = 0; i < 50; ++i) {
    LaserScan scan = changing_scan(random);
    for (float& range_m : scan.ranges_m) range_m = rough(random);
    if (i % 2 == 0) fill(scan, 100, 280, 0.0F);
    EXPECT_FALSE(body.look(scan)) << i;
  }
  EXPECT_EQ(body.samples(), 0);
}

// In a narrow box, or with something before the laser.
TEST(OwnBody, AFewFarReturnsThatChangeShowNothing) {
  std::mt19937 random(11);
  OwnBody body;
  for (int i = 0; i < 50; ++i) {
    LaserScan scan = changing_scan(random);
    fill(scan, 15, 359, 0.3F);
    EXPECT_FALSE(body.look(scan)) << i;
  }
  EXPECT_EQ(body.samples(), 0);
}

TEST(OwnBody, BlankTakesNearReturnsOfItsSectorAlone) {
  LaserScan scan;
  scan.bearing_step_rad = deg_to_rad(1.0);
  scan.ranges_m.assign(360, 0.3F);
  scan.ranges_m[355] = 2.0F;
  EXPECT_EQ(blank(scan, {"LIDAR", 350.0, 365.0, 0.35}), 17U);
  for (std::size_t beam = 0; beam < 360; ++beam) {
    const bool in_sector = beam >= 349 || beam <= 6;
    EXPECT_EQ(scan.ranges_m[beam], beam == 355 ? 2.0F : in_sector ? 0.0F : 0.3F) << beam;
  }
  LaserScan again = scan;
  again.ranges_m.assign(360, 0.3F);
  again.ranges_m[355] = 2.0F;
  blank(again, {"LIDAR", 350.0, 5.0, 0.35});
  EXPECT_EQ(again.ranges_m, scan.ranges_m) << "the last degree may be counted anew from ahead";
}

TEST(OwnBody, DegreesAreCountedFromAheadOnceRound) {
  for (const double turns_deg : {-720.0, 0.0, 360.0}) {
    EXPECT_EQ(degree_of(deg_to_rad(turns_deg + 0.5)), 0U);
    EXPECT_EQ(degree_of(deg_to_rad(turns_deg + 123.4)), 123U);
    EXPECT_EQ(degree_of(deg_to_rad(turns_deg - 0.5)), 359U);
  }
}

TEST(OwnBody, PartsAreDescribedLaserByLaser) {
  EXPECT_EQ(describe({{"LIDAR", 20.0, 25.0, 0.3},
                      {"LIDAR", 40.0, 41.0, 0.5},
                      {"LIDAR_REAR", 350.0, 365.0, 0.25}}),
            "the robot itself is in view of LIDAR: 20 to 25 deg within 0.30 m, 40 to 41 deg within "
            "0.50 m; the robot itself is in view of LIDAR_REAR: 350 to 365 deg within 0.25 m");
  EXPECT_EQ(describe(std::vector<BodyPart>{}), "");
}

}  // namespace
}  // namespace marco
