#include "simulator/people.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <random>

#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "simulator/world.hpp"

namespace marco::sim {
namespace {

using ::marco::testing::complaint;
using ::testing::HasSubstr;

bool is_inside(const Leg& leg, const Eigen::Vector3d& point) {
  return point.z() >= 0.0 && point.z() <= Leg::kHeightM &&
         (point.head<2>() - leg.centre_m).norm() <= Leg::kRadiusM;
}

// The first of points 1 mm apart along the ray that lies inside.
std::optional<double> range_by_steps(const Leg& leg,
                                     const Eigen::Vector3d& origin_m,
                                     const Eigen::Vector3d& direction) {
  for (double range_m = 0.0; range_m < 4.0; range_m += 1e-3) {
    if (is_inside(leg, origin_m + range_m * direction)) return range_m;
  }
  return std::nullopt;
}

TEST(RangeToLeg, IsWhereTheRayEntersByBruteForce) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  int by_side = 0, by_top = 0, missed = 0;
  for (int i = 0; i < 4000; ++i) {
    const Leg leg{{uniform(random), uniform(random)}};
    const Eigen::Vector3d origin(uniform(random), uniform(random), 0.9 + 0.9 * uniform(random));
    // Half of the rays aim at the leg or close by.
    Eigen::Vector3d aim(uniform(random), uniform(random), uniform(random));
    if (i % 2 == 0) {
      aim = Eigen::Vector3d(leg.centre_m.x(), leg.centre_m.y(), 0.7) + 0.12 * aim - origin;
    }
    if (is_inside(leg, origin)) continue;
    const Eigen::Vector3d direction = aim.normalized();
    const auto range_m = range_to_leg(leg, origin, direction);
    const auto stepped_m = range_by_steps(leg, origin, direction);
    if (!range_m) {
      EXPECT_FALSE(stepped_m.has_value());
      ++missed;
      continue;
    }
    ASSERT_GT(*range_m, 0.0);
    if (stepped_m) {
      EXPECT_GT(*stepped_m, *range_m - 1e-9);
      EXPECT_LT(*stepped_m, *range_m + 1e-3 + 1e-9);
    }
    // It is on the surface, also where the steps skip a corner.
    const Eigen::Vector3d hit = origin + *range_m * direction;
    const bool top = std::abs(hit.z() - Leg::kHeightM) < 1e-9;
    const double from_axis_m = (hit.head<2>() - leg.centre_m).norm();
    EXPECT_TRUE(top || std::abs(from_axis_m - Leg::kRadiusM) < 1e-9) << from_axis_m;
    ++(top ? by_top : by_side);
  }
  EXPECT_GT(by_side, 500);
  EXPECT_GT(by_top, 50);
  EXPECT_GT(missed, 500);
}

TEST(RangeToLeg, IsNothingFromInsideOrBehindOrAlong) {
  const Leg leg{{1.0, 0.0}};
  EXPECT_FALSE(range_to_leg(leg, {1.0, 0.02, 0.3}, {1, 0, 0}));
  EXPECT_FALSE(range_to_leg(leg, {0.0, 0.0, 0.3}, {-1, 0, 0}));
  EXPECT_FALSE(range_to_leg(leg, {0.5, 0.0, 0.3}, {0, 0, 1}));
  EXPECT_FALSE(range_to_leg(leg, {1.0, 0.0, 1.5}, {0, 0, 1}));
  EXPECT_DOUBLE_EQ(range_to_leg(leg, {0.0, 0.0, 0.3}, {1, 0, 0}).value(), 1.0 - Leg::kRadiusM);
  EXPECT_DOUBLE_EQ(range_to_leg(leg, {1.0, 0.0, 1.5}, {0, 0, -1}).value(), 1.5 - Leg::kHeightM);
}

Eigen::Vector2d middle_of(const std::array<Leg, 2>& legs) {
  return 0.5 * (legs[0].centre_m + legs[1].centre_m);
}

TEST(Person, WalksToAndFroAtTheirSpeed) {
  constexpr double kSpeed = 1.2;
  const Person person({{0, 0}, {5.2, 0}}, kSpeed, 0.0);
  for (double t = 0.0; t < 30.0; t += 0.01) {
    const double walked_m = std::fmod(kSpeed * t, 10.4);
    const double x_m = walked_m < 5.2 ? walked_m : 10.4 - walked_m;
    const auto legs = person.legs_at(t);
    // The feet are a quarter of a stride before and behind, and take turns; where they turn round
    // they are off by no more.
    EXPECT_NEAR(middle_of(legs).x(), x_m, 0.5 * 0.65) << t;
    for (const Leg& leg : legs) EXPECT_LE(std::abs(leg.centre_m.y()), 0.1 + 1e-12);
  }
  // Left is on the left on the way, and again on the way back.
  EXPECT_NEAR(person.legs_at(2.0)[0].centre_m.y(), 0.1, 1e-12);
  EXPECT_NEAR(person.legs_at(2.0)[1].centre_m.y(), -0.1, 1e-12);
  EXPECT_NEAR(person.legs_at(6.5)[0].centre_m.y(), -0.1, 1e-12);
}

TEST(Person, WalksAroundWhereTheLastWaypointIsTheFirst) {
  // Round a square of 10.4 m: eight strides.
  const Person person({{0, 0}, {2.6, 0}, {2.6, 2.6}, {0, 2.6}, {0, 0}}, 1.3, 0.0);
  for (double t = 0.0; t < 8.0; t += 0.1) {
    for (int leg = 0; leg < 2; ++leg) {
      const Eigen::Vector2d now = person.legs_at(t).at(leg).centre_m;
      EXPECT_LT((person.legs_at(t + 8.0).at(leg).centre_m - now).norm(), 1e-9);
      EXPECT_LT((person.legs_at(t - 8.0).at(leg).centre_m - now).norm(), 1e-9);
    }
  }
  EXPECT_LT((middle_of(person.legs_at(3.0)) - Eigen::Vector2d(2.6, 1.3)).norm(), 0.2);
  EXPECT_LT((middle_of(person.legs_at(7.0)) - Eigen::Vector2d(0, 1.3)).norm(), 0.2);
}

TEST(Person, StepsAsAWalkerDoes) {
  constexpr double kStepS = 1e-3, kSpeed = 1.0;
  const Person person({{0, 0}, {4, 0}, {4, 3}}, kSpeed, 0.0);
  int samples = 0, both_move = 0;
  std::array<int, 2> stands{};
  for (double t = 0.0; t < 26.0; t += kStepS, ++samples) {
    std::array<double, 2> moved_m{};
    for (int leg = 0; leg < 2; ++leg) {
      moved_m.at(leg) =
          (person.legs_at(t + kStepS).at(leg).centre_m - person.legs_at(t).at(leg).centre_m).norm();
      // No jumps: a swing is twice as fast as the walker, half as much again in its middle.
      ASSERT_LT(moved_m.at(leg), 3.1 * kSpeed * kStepS) << t;
      if (moved_m.at(leg) < 1e-12) ++stands.at(leg);
    }
    if (moved_m[0] > 1e-12 && moved_m[1] > 1e-12) ++both_move;
  }
  for (const int count : stands) EXPECT_NEAR(count, 0.5 * samples, 0.02 * samples);
  EXPECT_LT(both_move, 0.01 * samples);
}

TEST(Person, MayHaveSetOffBefore) {
  const Person one({{0, 0}, {4, 1}}, 0.9, 0.0), other({{0, 0}, {4, 1}}, 0.9, 3.25);
  for (double t = 0.0; t < 10.0; t += 0.5) {
    EXPECT_LT((other.legs_at(t)[0].centre_m - one.legs_at(t + 3.25)[0].centre_m).norm(), 1e-12);
  }
}

TEST(Person, NeedsAWay) {
  EXPECT_THAT(complaint([] { Person({{1, 1}}, 1.0, 0.0); }), HasSubstr("at least two"));
  EXPECT_THAT(complaint([] {
                Person({{1, 1}, {1, 1}}, 1.0, 0.0);
              }),
              HasSubstr("all are identical"));
  WorldSpec spec;
  spec.people.resize(1);
  spec.people[0].waypoints_m = {1, 2, 3};
  EXPECT_THAT(complaint([&] { build_world(spec); }), HasSubstr("people.waypoints_m"));
}

}  // namespace
}  // namespace marco::sim
