#include "mapping3d/registration.hpp"

#include <gmock/gmock.h>

#include "mapping3d/point_tree.hpp"
#include "tests/support/analytic_room.hpp"

namespace marco::mapping3d {
namespace {

using ::marco::testing::AnalyticRoom;

const Pose3 kFirstSensor = make_pose3({-1.0, 0.2, 0.8});
const Pose3 kSecondSensor = make_pose3({-0.6, -0.5, 0.8}, 0.0, 0.0, 0.3);

ScenePoints moved(ScenePoints scene, const Pose3& to_from) {
  for (Eigen::Vector3f& p : scene.points_m) p = (to_from * p.cast<double>()).cast<float>();
  for (Eigen::Vector3f& p : scene.origins_m) p = (to_from * p.cast<double>()).cast<float>();
  return scene;
}

/// The second scene as the first one sees it: the path holds both, each goes half the way.
Pose3 second_by_first(const RegistrationResult& result, std::size_t second) {
  return result.world_from_placed[0].inverse() * result.world_from_placed[second];
}

TEST(PointTree, FindsWhatBruteForceFinds) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> somewhere(-2.0F, 2.0F);
  for (const std::size_t count : {0U, 1U, 7U, 8U, 9U, 500U}) {
    std::vector<Eigen::Vector3f> points;
    for (std::size_t i = 0; i < count; ++i) {
      points.emplace_back(somewhere(random), somewhere(random), somewhere(random));
    }
    const PointTree tree(points);
    for (int round = 0; round < 100; ++round) {
      const Eigen::Vector3f query(somewhere(random), somewhere(random), somewhere(random));
      constexpr float kRadius = 0.7F;
      std::optional<uint32_t> expected;
      float best = kRadius * kRadius;
      for (uint32_t i = 0; i < count; ++i) {
        const float distance2 = (points[i] - query).squaredNorm();
        if (distance2 < best) {
          best = distance2;
          expected = i;
        }
      }
      EXPECT_EQ(tree.nearest(query, kRadius), expected);
    }
  }
}

TEST(FindSurfels, LieOnTheRoomAndLookAtTheSensor) {
  std::mt19937 random(3);
  const ScenePoints scene = place(AnalyticRoom::sweep(kFirstSensor, 60, 0.0, random));
  const std::vector<Surfel> surfels = find_surfels(scene);
  EXPECT_GT(surfels.size(), 800U);
  for (const Surfel& surfel : surfels) {
    const Eigen::Vector3d towards = kFirstSensor.translation() - surfel.center_m;
    EXPECT_GT(surfel.normal.dot(towards), 0.0);
  }
}

// Where beams run along the axis of the tilt, those of all rows meet one place: what spreads there
// is the noise of the ranges, along the beams. So it is for all beams while the tilt waits for the
// next sweep.
TEST(FindSurfels, NoiseAlongTheBeamsIsNoSurface) {
  std::mt19937 random(11);
  Scene sweep = AnalyticRoom::sweep(kFirstSensor, 200, 0.01, random);
  const std::vector<SceneRow> waiting(12, sweep.rows.front());
  sweep.rows.insert(sweep.rows.begin(), waiting.begin(), waiting.end());
  std::size_t on_walls = 0, wrong = 0;
  for (const Surfel& surfel : find_surfels(place(sweep))) {
    const Eigen::Vector3d& at = surfel.center_m;
    const Eigen::Vector3d off(4.0 - std::abs(at.x()), 3.0 - std::abs(at.y()),
                              1.4 - std::abs(at.z() - 1.4));
    Eigen::Index wall = 0;
    if (off.minCoeff(&wall) > 0.04 || (off.array() < 0.3).count() > 1) continue;  // a box, a corner
    ++on_walls;
    wrong += std::abs(surfel.normal[wall]) < std::cos(deg_to_rad(45.0)) ? 1 : 0;
  }
  EXPECT_GT(on_walls, 1500U);
  EXPECT_LT(12 * wrong, on_walls);  // without a look at the beams: one in four
}

// A robot that leans: its sweeps of one stop are wrong alike, and narrow ones by themselves tell
// too little. Each narrow sweep sees a tenth of the room's columns.
TEST(RegisterScenes, SweepsOfOneBodyMoveAsOne) {
  std::mt19937 random(12);
  const Pose3 error = make_pose3({0.01, -0.01, 0.02}, deg_to_rad(0.3), deg_to_rad(-0.2), 0.0);
  std::vector<ScenePoints> scenes{place(AnalyticRoom::sweep(kFirstSensor, 100, 0.005, random))};
  const ScenePoints second =
      moved(place(AnalyticRoom::sweep(kSecondSensor, 100, 0.005, random)), error);
  std::vector<std::size_t> body_of{0};
  for (std::size_t part = 0; part < 10; ++part) {
    ScenePoints narrow = second;
    for (std::size_t i = 0; i < narrow.valid.size(); ++i) {
      if ((i % narrow.columns) * 10 / narrow.columns != part) narrow.valid[i] = 0;
    }
    scenes.push_back(std::move(narrow));
    body_of.push_back(1);
  }
  const RegistrationResult result = register_scenes(scenes, {}, body_of);
  EXPECT_EQ(result.status, RegistrationResult::Status::converged);
  for (std::size_t i = 1; i < scenes.size(); ++i) {
    // Under a millimetre at the room's corners, as two whole scenes reach.
    EXPECT_LT(AnalyticRoom::worst_shift_m(second_by_first(result, i) * error), 0.001);
    EXPECT_TRUE(result.joined[i]);
    EXPECT_TRUE(result.world_from_placed[i].isApprox(result.world_from_placed[1]));
  }
  body_of.back() = 7;
  EXPECT_THROW(register_scenes(scenes, {}, body_of), std::invalid_argument);
}

TEST(RegisterScenes, BringsTwoScenesTogether) {
  std::mt19937 random(11);
  const ScenePoints first = place(AnalyticRoom::sweep(kFirstSensor, 100, 0.005, random));
  const ScenePoints second = place(AnalyticRoom::sweep(kSecondSensor, 100, 0.005, random));
  const Pose3 error =
      make_pose3({0.18, -0.12, 0.03}, deg_to_rad(0.5), deg_to_rad(-0.5), deg_to_rad(2.6));
  const RegistrationResult result = register_scenes({first, moved(second, error)});
  EXPECT_EQ(result.status, RegistrationResult::Status::converged);
  // 5 mm over some 2000 patches of 16 beams leave well under a millimetre at the room's corners.
  EXPECT_LT(AnalyticRoom::worst_shift_m(second_by_first(result, 1) * error), 0.0015);
}

TEST(RegisterScenes, WithoutNoiseIsRightToATenthOfAMillimetre) {
  std::mt19937 random(11);
  const ScenePoints first = place(AnalyticRoom::sweep(kFirstSensor, 100, 0.0, random));
  const ScenePoints second = place(AnalyticRoom::sweep(kSecondSensor, 100, 0.0, random));
  const Pose3 error =
      make_pose3({0.18, -0.12, 0.08}, deg_to_rad(1.0), deg_to_rad(-1.0), deg_to_rad(2.6));
  const RegistrationResult result = register_scenes({first, moved(second, error)});
  // Patches that bend about an edge are thick and count little; flat ones fit to a float's grain.
  EXPECT_LT(AnalyticRoom::worst_shift_m(second_by_first(result, 1) * error), 0.0001);
  EXPECT_LT(result.after.median_m, 0.1 * result.before.median_m);
}

// Two walls and a floor, nothing across: a scene cut out of the room's middle.
ScenePoints corridor(double along_m, double sigma_m, uint32_t seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0.0, sigma_m);
  ScenePoints scene;
  scene.rows = 120;
  scene.columns = 240;
  for (std::size_t row = 0; row < scene.rows; ++row) {
    scene.origins_m.emplace_back(static_cast<float>(along_m), 0.0F, 1.0F);
    const double x = along_m + 6.0 * (static_cast<double>(row) / 120.0 - 0.5);
    for (std::size_t column = 0; column < scene.columns; ++column) {
      const double across = static_cast<double>(column % 80) / 40.0 - 1.0, n = noise(random);
      Eigen::Vector3d point(x, across, n);
      if (column < 80) point = {x, 1.0 + n, 1.0 + across};
      if (column >= 160) point = {x, -1.0 + n, 1.0 + across};
      scene.points_m.push_back(point.cast<float>());
      scene.valid.push_back(1);
    }
  }
  return scene;
}

TEST(RegisterScenes, AlongABareCorridorTheGuessStays) {
  const Pose3 error = make_pose3({0.1, 0.05, 0.03}, 0.0, 0.0, 0.01);
  const RegistrationResult result =
      register_scenes({corridor(0.0, 0.01, 1), moved(corridor(0.7, 0.01, 2), error)});
  const Eigen::Vector3d middle(0.7, 0.0, 1.0);
  const Eigen::Vector3d left = second_by_first(result, 1) * error * middle - middle;
  EXPECT_NEAR(left.x(), 0.1, 0.001);  // unobservable, so that the initial guess stays
  EXPECT_NEAR(left.y(), 0.0, 0.002);
  EXPECT_NEAR(left.z(), 0.0, 0.002);
}

TEST(RegisterScenes, JoinsThreeAtOnceAndLeavesAStrangerAlone) {
  std::mt19937 random(12);
  const Pose3 error_b = make_pose3({0.05, -0.04, 0.02}, 0.01, 0.0, 0.02);
  const Pose3 error_c = make_pose3({-0.06, 0.03, 0.0}, 0.0, -0.01, -0.02);
  const Pose3 far_away = make_pose3({100.0, 0.0, 0.0});
  std::vector<ScenePoints> scenes;
  scenes.push_back(place(AnalyticRoom::sweep(kFirstSensor, 60, 0.005, random)));
  scenes.push_back(moved(place(AnalyticRoom::sweep(kSecondSensor, 60, 0.005, random)), error_b));
  scenes.push_back(moved(scenes[0], far_away));
  scenes.push_back(moved(scenes[0], error_c));
  const RegistrationResult result = register_scenes(scenes);
  EXPECT_THAT(result.joined, ::testing::ElementsAre(true, true, false, true));
  EXPECT_LT(AnalyticRoom::worst_shift_m(second_by_first(result, 1) * error_b), 0.003);
  EXPECT_LT(AnalyticRoom::worst_shift_m(second_by_first(result, 3) * error_c), 0.003);
  EXPECT_TRUE(result.world_from_placed[2].isApprox(Pose3::Identity()));
}

TEST(RegisterScenes, RoomsApartAreJoinedEachByItself) {
  std::mt19937 random(13);
  const Pose3 far_away = make_pose3({100.0, 0.0, 0.0});
  const Pose3 error = make_pose3({0.05, -0.04, 0.02}, 0.005, 0.0, 0.02);
  const ScenePoints first = place(AnalyticRoom::sweep(kFirstSensor, 60, 0.005, random));
  const ScenePoints second = place(AnalyticRoom::sweep(kSecondSensor, 60, 0.005, random));
  const RegistrationResult result =
      register_scenes({first, moved(first, far_away), moved(moved(second, error), far_away)});
  EXPECT_THAT(result.joined, ::testing::ElementsAre(false, true, true));
  EXPECT_EQ(result.overlaps, 1U);
  EXPECT_TRUE(result.world_from_placed[0].isApprox(Pose3::Identity()));
  const Pose3 left = far_away.inverse() * result.world_from_placed[1].inverse() *
                     result.world_from_placed[2] * far_away * error;
  EXPECT_LT(AnalyticRoom::worst_shift_m(left), 0.003);
}

// A room seen through a door: upright walls tell nothing of its height.
TEST(RegisterScenes, ARobotStaysOnItsFloor) {
  std::mt19937 random(17);
  ScenePoints first = place(AnalyticRoom::sweep(kFirstSensor, 100, 0.005, random));
  ScenePoints second = place(AnalyticRoom::sweep(kSecondSensor, 100, 0.005, random));
  for (ScenePoints* scene : {&first, &second}) {
    for (std::size_t i = 0; i < scene->valid.size(); ++i) {
      const float z_m = scene->points_m[i].z();
      if (z_m < 0.3F || z_m > 2.2F) scene->valid[i] = 0;
    }
  }
  const Pose3 error = make_pose3({0.06, -0.04, 0.0}, 0.0, 0.0, deg_to_rad(0.5));
  const RegistrationResult result = register_scenes({first, moved(second, error)});
  EXPECT_EQ(result.status, RegistrationResult::Status::converged);
  const Eigen::Vector3d left = (second_by_first(result, 1) * error).translation();
  EXPECT_LT(left.head<2>().norm(), 0.003);
  EXPECT_NEAR(left.z(), 0.0, 0.002);
}

// Five stops agree; what fits them only with a floor 14 cm lower has another floor.
TEST(RegisterScenes, WhatContradictsThePathStaysOnIt) {
  std::mt19937 random(18);
  std::vector<ScenePoints> scenes;
  for (int i = 0; i < 5; ++i) {
    scenes.push_back(place(AnalyticRoom::sweep(kFirstSensor, 60, 0.005, random)));
  }
  scenes.push_back(moved(place(AnalyticRoom::sweep(kSecondSensor, 60, 0.005, random)),
                         make_pose3({0.0, 0.0, 0.14})));
  const RegistrationResult result = register_scenes(scenes);
  EXPECT_EQ(result.status, RegistrationResult::Status::converged);
  EXPECT_EQ(result.refused, 1U);
  EXPECT_FALSE(result.joined[5]);
  EXPECT_TRUE(result.world_from_placed[5].isApprox(Pose3::Identity()));
}

TEST(RegisterScenes, WhatDoesNotConvergeIsNotApplied) {
  std::mt19937 random(19);
  const ScenePoints first = place(AnalyticRoom::sweep(kFirstSensor, 60, 0.005, random));
  const ScenePoints second = place(AnalyticRoom::sweep(kSecondSensor, 60, 0.005, random));
  RegistrationOptions options;
  options.max_iterations = 2;
  const RegistrationResult result =
      register_scenes({first, moved(second, make_pose3({0.05, 0.0, 0.0}))}, options);
  EXPECT_EQ(result.status, RegistrationResult::Status::not_converged);
  EXPECT_THAT(result.joined, ::testing::ElementsAre(false, false));
  for (const Pose3& pose : result.world_from_placed) EXPECT_TRUE(pose.isApprox(Pose3::Identity()));
}

TEST(RegisterScenes, TakesNoScenesAndEmptyScenes) {
  EXPECT_TRUE(register_scenes(std::vector<ScenePoints>{}).world_from_placed.empty());
  const RegistrationResult result = register_scenes({ScenePoints{}, ScenePoints{}});
  EXPECT_THAT(result.joined, ::testing::ElementsAre(false, false));
  EXPECT_EQ(result.overlaps, 0U);
}

TEST(RegisterScenes, RefusesOptionsOutsideTheirLimits) {
  RegistrationOptions options;
  options.matching.shrink = 1.5;
  EXPECT_THROW(register_scenes(std::vector<ScenePoints>{}, options), std::invalid_argument);
}

}  // namespace
}  // namespace marco::mapping3d
