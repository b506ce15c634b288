#include "slam/matching/surfel_matcher.hpp"

#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <optional>

#include "tests/support/flat_world.hpp"
#include "tests/support/matchers.hpp"

namespace marco::slam {
namespace {

using ::marco::testing::IsNear;

OrientedPoints oriented(const Points2& hits) { return orient(hits, {0, 0}, {}); }

SurfelPyramid map_of(const testing::FlatWorld& world,
                     const std::vector<Pose2>& poses,
                     const Pose2& map_from_world = {}) {
  SurfelPyramid map({}, (map_from_world * poses.front()).translation_m());
  for (const Pose2& pose : poses) map.add(oriented(world.hits(pose)), map_from_world * pose);
  return map;
}

TEST(SurfelMatcher, FindsThePoseFromNoisyStarts) {
  const testing::FlatWorld room = testing::small_room();
  const SurfelPyramid map = map_of(room, {{0, 0, 0}, {0.3, 0, 0.2}});
  const SurfelMatcher matcher;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> offset(-0.25, 0.25);
  for (int i = 0; i < 50; ++i) {
    const Pose2 truth{0.2 + 0.3 * offset(random), 0.1, 0.1};
    const Pose2 start{truth.x_m + offset(random), truth.y_m + offset(random),
                      truth.theta_rad + 0.5 * offset(random)};
    const SurfelMatch match = matcher.match(map, oriented(room.hits(truth)), start, nullptr);
    EXPECT_EQ(match.status, SurfelMatch::Status::converged);
    // No noise: what is left is the cells' averaging at corners.
    EXPECT_THAT(match.map_from_robot, IsNear(truth, 0.003, 0.001)) << i;
    EXPECT_GT(match.overlap, 0.9);
  }
}

TEST(SurfelMatcher, FarFromTheOriginItIsAsExact) {
  const testing::FlatWorld room = testing::small_room();
  const Pose2 map_from_world{5000.0, -3000.0, 0.7};
  const SurfelPyramid map = map_of(room, {{0, 0, 0}}, map_from_world);
  const Pose2 truth = map_from_world * Pose2{0.1, 0.05, 0.05};
  const SurfelMatch match =
      SurfelMatcher().match(map, oriented(room.hits({0.1, 0.05, 0.05})), map_from_world, nullptr);
  EXPECT_THAT(match.map_from_robot, IsNear(truth, 0.003, 0.001));
}

TEST(SurfelMatcher, KnowsThatACorridorSaysNothingAlongItself) {
  testing::FlatWorld corridor;
  corridor.add_chain({{-50, -1}, {50, -1}});
  corridor.add_chain({{-50, 1}, {50, 1}});
  const SurfelPyramid map = map_of(corridor, {{0, 0, 0}});
  const SurfelMatch match =
      SurfelMatcher().match(map, oriented(corridor.hits({0.1, 0.1, 0.02})), {0.1, 0, 0}, nullptr);
  EXPECT_NEAR(match.map_from_robot.y_m, 0.1, 0.003);
  EXPECT_GT(match.information(1, 1), 1000.0 * std::max(1e-9, match.information(0, 0)));
}

// Each point on a wall across x is a measurement of x; the options say how many of them are
// independent, and how exact one is at least.
TEST(SurfelMatcher, InformationIsThatOfTheIndependentPointsAcrossEachWall) {
  testing::FlatWorld box;
  box.add_box(-4, -3, 4, 3);
  const Points2 hits = box.hits({0, 0, 0});
  const SurfelMatch match =
      SurfelMatcher().match(map_of(box, {{0, 0, 0}}), oriented(hits), {}, nullptr);
  double across_x = 0.0, across_y = 0.0;
  for (const auto& hit : hits.colwise()) {
    across_x += std::abs(std::abs(hit.x()) - 4.0) < 1e-3 ? 1.0 : 0.0;
    across_y += std::abs(std::abs(hit.y()) - 3.0) < 1e-3 ? 1.0 : 0.0;
  }
  const SurfelMatcherOptions options;
  const double each = 1.0 / (std::pow(options.noise_floor_m, 2) * options.correlated_points);
  ASSERT_GT(std::min(across_x, across_y), 50.0);
  // Points at corners have no clear normal.
  EXPECT_NEAR(match.information(0, 0), across_x * each, 0.1 * across_x * each);
  EXPECT_NEAR(match.information(1, 1), across_y * each, 0.1 * across_y * each);
}

TEST(SurfelMatcher, APriorDecidesWhereTheScanIsSilent) {
  testing::FlatWorld corridor;
  corridor.add_chain({{-50, -1}, {50, -1}});
  corridor.add_chain({{-50, 1}, {50, 1}});
  const SurfelPyramid map = map_of(corridor, {{0, 0, 0}});
  PosePrior prior;
  prior.map_from_robot = {0.4, 0.0, 0.0};
  prior.information = 100.0 * Eigen::Matrix3d::Identity();
  const SurfelMatch match =
      SurfelMatcher().match(map, oriented(corridor.hits({0.4, 0.1, 0.02})), {0.2, 0, 0}, &prior);
  EXPECT_NEAR(match.map_from_robot.x_m, 0.4, 0.01);
  EXPECT_NEAR(match.map_from_robot.y_m, 0.1, 0.005);
}

// Odometry that is sure of a place 0.2 m off, against a box that is seen whole. The coarse levels,
// which have few points and wide kernels, would go back to where odometry says.
TEST(SurfelMatcher, RefinedFromWhereTheScanLiesItStaysThereAgainstAPriorThatIsOff) {
  const testing::FlatWorld room = testing::small_room();
  const SurfelPyramid map = map_of(room, {{0, 0, 0}});
  const Pose2 truth{0.1, 0.05, 0.05};
  const OrientedPoints points = oriented(room.hits(truth));
  PosePrior prior;
  prior.map_from_robot = truth * Pose2{0.2, 0, 0};
  prior.information = Eigen::Vector3d(4e4, 4e4, 1e4).asDiagonal();
  prior.freedom = 5.0;
  const SurfelMatcher matcher;
  const SurfelMatch refined = matcher.refined(map, points, truth, prior);
  EXPECT_THAT(refined.map_from_robot, IsNear(truth, 0.01, 0.003));
  EXPECT_GT(refined.overlap, 0.9);
}

TEST(PosePrior, LetsGoOfWhatContradictsIt) {
  PosePrior normal, student;
  normal.information = student.information = 100.0 * Eigen::Matrix3d::Identity();
  student.freedom = 5.0;
  const Eigen::Vector3d near(0.01, 0, 0), far(10.0, 0, 0);
  EXPECT_EQ(normal.weight(far), 1.0);
  EXPECT_NEAR(normal.cost(far), 5000.0, 1e-9);
  EXPECT_NEAR(student.weight(near), 8.0 / 5.01, 1e-3);
  EXPECT_NEAR(student.weight(far), 8.0 / 10005.0, 1e-9);
  // The weight is the slope of the cost over that of a normal distribution's.
  constexpr double kSmall = 1e-5;
  const Eigen::Vector3d off(0.3, 0, 0), step(kSmall, 0, 0);
  const double slope = (student.cost(off + step) - student.cost(off - step)) / (2.0 * kSmall);
  EXPECT_NEAR(slope, student.weight(off) * 100.0 * off.x(), 1e-4);
}

TEST(SurfelMatcher, OutliersDoNotMoveTheMatch) {
  const testing::FlatWorld room = testing::small_room();
  const SurfelPyramid map = map_of(room, {{0, 0, 0}});
  std::mt19937 random(9);
  std::uniform_real_distribution<double> shorten(0.2, 0.95);
  Points2 hits = room.hits({0.1, 0.05, 0.05});
  for (Eigen::Index i = 0; i < hits.cols(); i += 5) hits.col(i) *= shorten(random);
  const SurfelMatch match = SurfelMatcher().match(map, oriented(hits), {0, 0, 0}, nullptr);
  EXPECT_THAT(match.map_from_robot, IsNear(Pose2{0.1, 0.05, 0.05}, 0.01, 0.003));
}

TEST(SurfelMatcher, NothingToMatchIsSaidAndLeavesTheGuess) {
  const testing::FlatWorld room = testing::small_room();
  const SurfelPyramid map = map_of(room, {{0, 0, 0}});
  const SurfelMatcher matcher;
  const Pose2 guess{1, 2, 0.3};
  const SurfelMatch empty = matcher.match(map, oriented(Points2(2, 0)), guess, nullptr);
  EXPECT_EQ(empty.status, SurfelMatch::Status::no_overlap);
  EXPECT_THAT(empty.map_from_robot, IsNear(guess, 0, 0));
  const SurfelMatch far = matcher.match(map, oriented(room.hits({0, 0, 0})), {300, 0, 0}, nullptr);
  EXPECT_EQ(far.status, SurfelMatch::Status::no_overlap);
}

TEST(SurfelMatcher, RefusesAScheduleWithoutOneSigmaALevel) {
  SurfelMatcherOptions options;
  options.sigmas_m.pop_back();
  EXPECT_THROW(SurfelMatcher{options}, std::invalid_argument);
}

TEST(SurfelMap, SaysHowFarAScanFoundItsSurfelsDrawn) {
  const testing::FlatWorld room = testing::small_room();
  const OrientedPoints whole = oriented(room.hits({0, 0, 0}));
  SurfelMap map({0, 0}, 40.0, 0.1);
  EXPECT_EQ(map.add(whole, {}), 0.0) << "new ground";
  // As many points again in each surfel: half of it is of before, its square a quarter, and more
  // while a scan's points are still coming in.
  const double second = map.add(whole, {});
  EXPECT_GT(second, 0.25);
  EXPECT_LT(second, 0.55);
  double newest = second;
  for (int scan = 2; scan < 20; ++scan) newest = map.add(whole, {});
  EXPECT_GT(newest, 0.88) << "one of twenty moves the map little";
  EXPECT_LT(newest, 0.99);
  EXPECT_EQ(map.add(whole, Pose2{20, 0, 0}), 0.0) << "elsewhere it is new again";
}

TEST(SurfelMap, TheTwoFacesOfAThinWallStayApart) {
  SurfelMap map({0, 0}, 5.0, 0.2);
  OrientedPoints faces{Points2(2, 2), Points2(2, 2)};
  faces.points << 1.05, 1.06, 0.5, 0.5;
  faces.normals << -1, 1, 0, 0;
  map.add(faces, Pose2{});
  EXPECT_EQ(map.size(), 2U);
  const std::optional<Surfel> surfel = map.find({1.1F, 0.5F}, {1.0F, 0.0F});
  ASSERT_TRUE(surfel);
  EXPECT_FLOAT_EQ(surfel->mean_m.x(), 1.06F);
  EXPECT_FALSE(map.find({1.1F, 0.5F}, {0.0F, 1.0F}));
}

// The slow obvious way: every surfel of the four cells around, one after another.
TEST(SurfelMap, FindsWhatASearchOfAllSurfelsFinds) {
  constexpr double kCellM = 0.1;
  std::mt19937 random(11);
  // Lattice points, one a cell, so that each is a surfel of its own; some cells stay empty.
  std::uniform_real_distribution<double> inside(0.1, 0.9), turn(-3.14, 3.14);
  std::vector<Eigen::Vector2d> means, normals;
  for (int y = -30; y < 30; ++y) {
    for (int x = -30; x < 30; ++x) {
      if (random() % 3 == 0) continue;
      means.push_back(kCellM * Eigen::Vector2d(x + inside(random), y + inside(random)));
      const double angle = turn(random);
      normals.emplace_back(std::cos(angle), std::sin(angle));
    }
  }
  OrientedPoints points{Points2(2, means.size()), Points2(2, means.size())};
  for (std::size_t i = 0; i < means.size(); ++i) {
    points.points.col(static_cast<Eigen::Index>(i)) = means[i];
    points.normals.col(static_cast<Eigen::Index>(i)) = normals[i];
  }
  SurfelMap map({0, 0}, 4.0, kCellM);
  map.add(points, Pose2{});
  EXPECT_EQ(map.size(), means.size());
  const auto cell = [](double m) { return static_cast<int>(std::floor(m / kCellM)); };
  std::uniform_real_distribution<double> place(-3.2, 3.2);
  int found = 0;
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector2d at(place(random), place(random));
    const double angle = turn(random);
    const Eigen::Vector2d normal =
        i % 4 == 0 ? Eigen::Vector2d::Zero() : Eigen::Vector2d(std::cos(angle), std::sin(angle));
    double nearest = kCellM;
    for (std::size_t k = 0; k < means.size(); ++k) {
      const bool around = (cell(means[k].x()) - cell(at.x() - 0.5 * kCellM)) / 2 == 0 &&
                          cell(means[k].x()) >= cell(at.x() - 0.5 * kCellM) &&
                          (cell(means[k].y()) - cell(at.y() - 0.5 * kCellM)) / 2 == 0 &&
                          cell(means[k].y()) >= cell(at.y() - 0.5 * kCellM);
      if (!around || (i % 4 != 0 && normals[k].dot(normal) < 0.8)) continue;
      nearest = std::min(nearest, (means[k] - at).norm());
    }
    const auto surfel = map.find(at.cast<float>(), normal.cast<float>());
    EXPECT_EQ(surfel.has_value(), nearest < kCellM);
    if (!surfel) continue;
    ++found;
    EXPECT_NEAR((surfel->mean_m.cast<double>() - at).norm(), nearest, 1e-5);
  }
  EXPECT_GT(found, 500);
}

TEST(SurfelMap, AfterARestartItIsAsNew) {
  const OrientedPoints hits = oriented(testing::small_room().hits({0, 0, 0}));
  SurfelMap map({0, 0}, 5.0, 0.1), fresh({1, 1}, 5.0, 0.1);
  map.add(hits, {0.3, 0.2, 0.1});
  map.restart({1, 1});
  EXPECT_EQ(map.size(), 0U);
  map.add(hits, Pose2{});
  fresh.add(hits, Pose2{});
  EXPECT_EQ(map.size(), fresh.size());
  for (Eigen::Index i = 0; i < hits.points.cols(); ++i) {
    const Eigen::Vector2f at = (hits.points.col(i) - map.centre_m()).cast<float>();
    const auto a = map.find(at, {0, 0}), b = fresh.find(at, {0, 0});
    ASSERT_EQ(a.has_value(), b.has_value());
    EXPECT_TRUE(!a || a->mean_m == b->mean_m);
  }
}

TEST(SurfelMatcher, NamesTheOutliers) {
  const testing::FlatWorld room = testing::small_room();
  const SurfelPyramid map = map_of(room, {{0, 0, 0}});
  Points2 hits = room.hits({0.05, 0, 0});
  // A person 0.12 m before the wall, another in the middle of the room.
  for (Eigen::Index i = 100; i < 105; ++i) hits.col(i) *= 1.0 - 0.12 / hits.col(i).norm();
  for (Eigen::Index i = 200; i < 205; ++i) hits.col(i) *= 0.5;
  std::vector<PointFate> fates;
  const SurfelMatch match = SurfelMatcher().match(map, oriented(hits), {0, 0, 0}, nullptr, &fates);
  ASSERT_EQ(fates.size(), static_cast<std::size_t>(hits.cols()));
  for (std::size_t i = 100; i < 105; ++i) EXPECT_NE(fates[i], PointFate::on_wall) << i;
  for (std::size_t i = 200; i < 205; ++i) EXPECT_EQ(fates[i], PointFate::no_wall) << i;
  const auto on_wall = std::count(fates.begin(), fates.end(), PointFate::on_wall);
  EXPECT_DOUBLE_EQ(match.overlap, static_cast<double>(on_wall) / static_cast<double>(hits.cols()));
  EXPECT_GT(match.overlap, 0.9);
}

}  // namespace
}  // namespace marco::slam
