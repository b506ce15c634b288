#include "common/footprint.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

namespace marco {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The slow, obvious way: the outline as a chain of points, and the turns of the corners about the
/// point summed up.
double slow_distance_m(const std::vector<Eigen::Vector2d>& corners, const Eigen::Vector2d& point) {
  double least = kInfinity, turned_rad = 0.0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector2d a = corners[i], b = corners[(i + 1) % corners.size()];
    constexpr int kSteps = 4000;
    for (int step = 0; step <= kSteps; ++step) {
      least = std::min(least, (a + (b - a) * step / kSteps - point).norm());
    }
    const Eigen::Vector2d to_a = a - point, to_b = b - point;
    turned_rad += normalize_angle(std::atan2(to_b.y(), to_b.x()) - std::atan2(to_a.y(), to_a.x()));
  }
  return std::abs(turned_rad) > 1.0 ? -least : least;
}

/// Star-shaped about somewhere near the origin: simple, often not convex.
std::vector<double> random_outline(std::mt19937& random) {
  const auto draw = [&](double a, double b) {
    return std::uniform_real_distribution<double>(a, b)(random);
  };
  const int corners = 3 + static_cast<int>(random() % 8);
  const double x = draw(-0.2, 0.2), y = draw(-0.2, 0.2), sense = random() % 2 == 0 ? 1.0 : -1.0;
  std::vector<double> outline;
  for (int i = 0; i < corners; ++i) {
    const double angle = sense * 2.0 * std::numbers::pi * (i + draw(0.0, 0.7)) / corners;
    const double radius = draw(0.1, 0.6);
    outline.push_back(x + radius * std::cos(angle));
    outline.push_back(y + radius * std::sin(angle));
  }
  return outline;
}

TEST(Footprint, DistancesAreThoseOfTheSlowWay) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> draw(-1.0, 1.0);
  for (int round = 0; round < 40; ++round) {
    const Footprint body(random_outline(random));
    for (int i = 0; i < 20; ++i) {
      const Eigen::Vector2d point(draw(random), draw(random));
      // A chain of 4000 points for an edge of 1.2 m at most.
      EXPECT_NEAR(body.distance_m(point), slow_distance_m(body.corners_m(), point), 2e-4);
    }
  }
}

TEST(Footprint, KnowsItsExtent) {
  const Footprint body(Footprint::box(0.4, 0.1, 0.3));
  EXPECT_DOUBLE_EQ(body.radius_m(), 0.5);
  EXPECT_DOUBLE_EQ(body.front_m(), 0.4);
  EXPECT_DOUBLE_EQ(body.back_m(), 0.1);
  EXPECT_DOUBLE_EQ(body.half_width_m(), 0.3);
  EXPECT_DOUBLE_EQ(body.distance_m({0.0, 0.0}), -0.1);
  EXPECT_DOUBLE_EQ(body.distance_m({0.7, 0.7}), 0.5);
}

TEST(Footprint, RefusesWhatIsNoOutline) {
  const std::vector<std::vector<double>> bad = {
      {},
      {0.0, 0.0, 1.0, 0.0},                                // a line
      {0.0, 0.0, 1.0, 0.0, 1.0},                           // half a corner
      {0.0, 0.0, 1.0, 0.0, 2.0, 0.0},                      // no area
      {0.0, 0.0, 1.0, 1.0, 1.0, 0.0, 0.0, 1.0},            // edges cross
      {0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.5, 0.0, 0.0, 1.0},  // a corner on an edge
      {0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 1.0},            // a corner twice
      {0.0, 0.0, 1.0, 0.0, 0.5, 0.0, 0.5, 1.0},            // back along its edge
      {0.0, 0.0, 21.0, 0.0, 0.0, 1.0},                     // as for a building
      {0.0, 0.0, kInfinity, 0.0, 0.0, 1.0},
      {0.0, 0.0, std::nan(""), 0.0, 0.0, 1.0},
      std::vector<double>(2 * 65, 0.5),
  };
  for (const auto& corners : bad) {
    EXPECT_THROW(Footprint{corners}, std::invalid_argument) << corners.size();
  }
}

Sweep arc(double ahead_m, double turn_rad, int steps, double radius_m) {
  Sweep sweep(1);
  for (int i = 0; i < steps; ++i)
    advance(sweep, {ahead_m / steps, 0.0, turn_rad / steps}, radius_m);
  return sweep;
}

/// Every point at every pose.
std::size_t slow_contact(const Footprint& body,
                         const Sweep& sweep,
                         const std::vector<Eigen::Vector2d>& points,
                         double margin_m) {
  for (std::size_t i = 0; i < sweep.size(); ++i) {
    for (const Eigen::Vector2d& point : points) {
      const double start = body.distance_m(point);
      const double now = body.distance_m(sweep[i].start_from_robot.inverse() * point);
      if (start >= margin_m ? now < margin_m : now < start - 0.0002) return i;
    }
  }
  return sweep.size();
}

TEST(Footprint, ASweepMeetsWhatEveryPoseWould) {
  std::mt19937 random(12);
  const auto draw = [&](double a, double b) {
    return std::uniform_real_distribution<double>(a, b)(random);
  };
  int met = 0;
  for (int round = 0; round < 400; ++round) {
    const Footprint body(random_outline(random));
    const Sweep sweep = arc(draw(-1.0, 1.0), draw(-2.0, 2.0), 100, body.radius_m());
    std::vector<Eigen::Vector2d> points;
    const double margin_m = draw(0.0, 0.1);
    while (points.size() < 8) {
      const Eigen::Vector2d point(draw(-1.5, 1.5), draw(-1.5, 1.5));
      // A point within the margin may come nearer by a little: the two ways differ there.
      if (body.distance_m(point) > margin_m) points.push_back(point);
    }
    const std::size_t first = first_contact(body, sweep, points, margin_m);
    EXPECT_EQ(first, slow_contact(body, sweep, points, margin_m)) << round;
    met += first < sweep.size() ? 1 : 0;
  }
  EXPECT_GT(met, 50);
  EXPECT_LT(met, 350);
}

TEST(Footprint, APointWithinTheMarginMayNotComeNearer) {
  const Footprint body(Footprint::box(0.3, 0.3, 0.2));
  const std::vector<Eigen::Vector2d> beside{{0.1, 0.22}}, ahead{{0.32, 0.0}}, inside{{0.29, 0.0}};
  const auto is_free = [&](const Sweep& sweep, const std::vector<Eigen::Vector2d>& points) {
    return first_contact(body, sweep, points, 0.03) == sweep.size();
  };
  const double r = body.radius_m();
  EXPECT_TRUE(is_free(arc(0.5, 0.0, 50, r), beside));   // along it
  EXPECT_FALSE(is_free(arc(0.0, 0.5, 50, r), beside));  // the corner ahead swings at it
  EXPECT_TRUE(is_free(arc(-0.5, 0.0, 50, r), ahead));   // away
  EXPECT_FALSE(is_free(arc(0.1, 0.0, 50, r), ahead));
  EXPECT_FALSE(is_free(arc(0.002, 0.0, 2, r), ahead));
  EXPECT_TRUE(is_free(arc(-0.5, 0.0, 50, r), inside));
  EXPECT_FALSE(is_free(arc(0.002, 0.0, 2, r), inside));
  EXPECT_TRUE(is_free(arc(0.5, 0.0, 50, r), {}));
  EXPECT_TRUE(is_free({}, ahead));
}

TEST(Footprint, NoNearerInManySteps) {
  // Again and again as near as it may: a centimetre stays.
  const Footprint body(Footprint::box(0.3, 0.3, 0.2));
  double at_m = 0.33;
  for (int i = 0; i < 2000; ++i) {
    const std::vector<Eigen::Vector2d> wall{{at_m, 0.0}};
    const Sweep sweep = arc(0.05, 0.0, 500, body.radius_m());
    const std::size_t first = first_contact(body, sweep, wall, 0.03);
    at_m -= sweep[std::min(first, sweep.size()) - 1].swept_m;
  }
  EXPECT_GT(at_m, 0.3099);
}

}  // namespace
}  // namespace marco
