#include <gmock/gmock.h>

#include <array>
#include <cmath>

#include "common/trajectory.hpp"
#include "lcm_tools/process/batch_bus.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "mapping3d/process/mapping3d_adapter.hpp"
#include "mapping3d/process/model_messages.hpp"
#include "marco/map_request_t.hpp"
#include "marco/slam_pose_t.hpp"
#include "marco/trajectory_t.hpp"

namespace marco::mapping3d {
namespace {

constexpr int64_t kStepUs = 100'000;

class Mapping3dOverABus : public ::testing::Test {
 protected:
  Mapping3dOverABus() : adapter_(bus_, Mapping3dAdapterOptions{}) {
    bus_.subscribe<mesh_t>(channels::kMesh, drops_,
                           [this](const mesh_t& tile, const auto&) { tiles_.push_back(tile); });
    bus_.subscribe<scene_t>(channels::kScene, drops_, [this](const scene_t& scene, const auto&) {
      scenes_.push_back(scene);
    });
    SensorInfo base;
    base.channel = channels::kPanTiltState;
    give(base);
    SensorInfo laser;
    laser.channel = channels::kLidar;
    laser.mount = SensorInfo::Mount::pantilt;
    laser.range_max_m = 30.0;
    give(laser);
  }
  void give(const Sample& sample) {
    const EncodedMessage message = encode_sample(sample);
    bus_.deliver(message.channel, message.bytes, message.utime);
  }
  // A scan of a wall 2 m ahead, its pose and its tilt.
  void row(int number, double tilt_deg, bool with_pose = true) {
    const Utime utime = Utime::from_us(kStepUs * number);
    PanTiltState state;
    state.utime = utime;
    state.tilt_rad = deg_to_rad(tilt_deg);
    give(state);
    LaserScan scan;
    scan.utime = utime;
    scan.channel = channels::kLidar;
    scan.first_bearing_rad = deg_to_rad(-20);
    scan.bearing_step_rad = deg_to_rad(1);
    for (int i = 0; i <= 40; ++i) {
      scan.ranges_m.push_back(
          static_cast<float>(2.0 / std::cos(deg_to_rad(i - 20)) / std::cos(deg_to_rad(tilt_deg))));
    }
    give(scan);
    if (with_pose) pose(number);
  }
  void pose(int number, double x_m = 0.0) {
    slam_pose_t pose{};
    pose.utime = kStepUs * number;
    pose.x_m = x_m;
    for (int i = 0; i < 3; ++i) pose.covariance[i][i] = sigma_ * sigma_;
    pose.status = status_;
    bus_.publish(channels::kSlamPose, pose);
    bus_.deliver_published();
  }
  // Every twentieth scan is a keyframe; all lie `aside_m` to the left of where they were published.
  void path_until(int number, double aside_m) {
    Trajectory keys;
    for (int i = 0; i <= number; i += 20)
      keys.push_back({Utime::from_us(kStepUs * i), {0, aside_m, 0}});
    bus_.publish(channels::kTrajectory, to_message(keys, Utime::from_us(kStepUs * number), 1));
    bus_.deliver_published();
  }

  int8_t status_ = slam_pose_t::STATUS_MATCHED;
  double sigma_ = 0.0;  ///< of poses [m], [rad]
  process::BatchBus bus_;
  process::DropCounter drops_;
  std::vector<mesh_t> tiles_;
  std::vector<scene_t> scenes_;
  Mapping3dAdapter adapter_;
};

TEST_F(Mapping3dOverABus, ASweepBecomesASceneAndTheModelIsTheWall) {
  for (int i = 0; i < 31; ++i) row(i, -15.0 + i);
  adapter_.finish();
  bus_.deliver_published();
  ASSERT_EQ(scenes_.size(), 1U);
  EXPECT_EQ(scenes_[0].rows, 31);
  EXPECT_EQ(scenes_[0].columns, 41);
  const TriangleMesh scenes = adapter_.mapper().scene_meshes();
  EXPECT_EQ(scenes.triangles.size(), 2U * 30U * 40U);
  for (const Eigen::Vector3f& vertex : scenes.vertices_m) EXPECT_NEAR(vertex.x(), 2.0F, 1e-4);
  const TriangleMesh& model = adapter_.mapper().model();
  ASSERT_GT(model.triangles.size(), 1000U);
  for (const Eigen::Vector3f& vertex : model.vertices_m) EXPECT_NEAR(vertex.x(), 2.0F, 1e-3);
}

/// The corners of each triangle, in order.
using Corners = std::vector<std::array<Eigen::Vector3f, 3>>;

Corners corners_of(const std::vector<mesh_t>& tiles) {
  Corners corners;
  for (const mesh_t& tile : tiles) {
    for (const auto& triangle : tile.triangles) {
      auto& three = corners.emplace_back();
      for (std::size_t i = 0; i < 3; ++i) {
        const auto& at = tile.vertices_m[static_cast<std::size_t>(triangle[i])];
        three[i] = {at[0], at[1], at[2]};
      }
    }
  }
  return corners;
}

Corners corners_of(const TriangleMesh& mesh) {
  Corners corners;
  for (const auto& [a, b, c] : mesh.triangles) {
    corners.push_back({mesh.vertices_m[a], mesh.vertices_m[b], mesh.vertices_m[c]});
  }
  return corners;
}

// What `./marco map` writes as model.ply comes from the same call.
TEST_F(Mapping3dOverABus, TheLiveModelIsTheSurfaceOfThePipeline) {
  for (int i = 0; i < 31; ++i) row(i, -15.0 + i);
  for (int i = 31; i < 62; ++i) row(i, 46.0 - i);
  map_request_t request{};
  request.channel = channels::kMesh;
  const auto ask = [&] {
    tiles_.clear();
    bus_.publish(channels::kMapRequest, request);
    bus_.deliver_published();
    bus_.deliver_published();
    return corners_of(tiles_);
  };
  const Corners first = ask();
  EXPECT_EQ(first, corners_of(fuse(adapter_.mapper().placed())));
  EXPECT_GT(first.size(), 1000U);
  EXPECT_EQ(ask(), first);
  tiles_.clear();
  adapter_.finish();
  bus_.deliver_published();
  ASSERT_EQ(adapter_.mapper().scenes().size(), 2U);
  const Corners last = corners_of(tiles_);
  EXPECT_EQ(last, corners_of(fuse(adapter_.mapper().placed())));
  EXPECT_NE(last, first);
  // After the path has moved, so has the model.
  path_until(60, 0.5);
  const Corners moved = ask();
  EXPECT_EQ(moved, corners_of(fuse(adapter_.mapper().placed())));
  EXPECT_NE(moved, last);
}

// A match corrects by 1 cm what was predicted to 2 cm, and later someone pushes the robot by 20 cm.
TEST_F(Mapping3dOverABus, ARobotThatStandsByOdometryDoesNotMoveUnlessSlamContradicts) {
  sigma_ = 0.02;
  const auto at_m = [](int i) { return i < 12 ? 0.0 : i < 24 ? 0.01 : 0.21; };
  for (int i = 0; i < 40; ++i) {
    give(OdometrySample{Utime::from_us(kStepUs * i), {i < 4 ? 0.1 * i : 0.4, 0, 0}});
    row(i, -15.0 + i, false);
    pose(i, i < 4 ? 0.1 * i - 0.4 : at_m(i));
  }
  adapter_.finish();
  ASSERT_EQ(adapter_.mapper().scenes().size(), 1U);
  const std::vector<SceneRow>& rows = adapter_.mapper().scenes()[0].rows;
  ASSERT_EQ(rows.size(), 40U);
  EXPECT_NEAR(rows[1].world_from_robot.x_m, -0.3, 1e-12) << "it drove";
  for (std::size_t i = 4; i < 24; ++i) EXPECT_EQ(rows[i].world_from_robot.x_m, 0.01) << i;
  for (std::size_t i = 24; i < 40; ++i) EXPECT_EQ(rows[i].world_from_robot.x_m, 0.21) << i;
}

// Of another session, not found in the map: it would be laid over what is there.
TEST_F(Mapping3dOverABus, WhatIsSeenFromAnUnknownPlaceIsNoScene) {
  status_ = slam_pose_t::STATUS_LOST;
  for (int i = 0; i < 31; ++i) row(i, -15.0 + i);
  adapter_.finish();
  EXPECT_TRUE(adapter_.mapper().scenes().empty());
  EXPECT_EQ(adapter_.drops().by_cause().at("slam_pose_t: SLAM is lost"), 31);
}

TEST_F(Mapping3dOverABus, RowsWithoutAPoseAreCountedAndTheRestIsUsed) {
  for (int i = 0; i < 31; ++i) row(i, -15.0 + i, i % 10 != 5);
  adapter_.finish();
  EXPECT_EQ(adapter_.drops().by_cause().at("scan without SLAM_POSE"), 3);
  ASSERT_EQ(adapter_.mapper().scenes().size(), 1U);
  EXPECT_EQ(adapter_.mapper().scenes()[0].rows.size(), 28U);
}

TEST_F(Mapping3dOverABus, AfterALongDriveASceneStillFollowsItsKeyScanAndFewPosesAreKept) {
  for (int i = 0; i < 31; ++i) row(i, -15.0 + i);
  for (int i = 31; i < 4000; ++i) {
    pose(i);
    if (i == 2000) path_until(i, 0.5);
  }
  path_until(3999, 0.75);
  adapter_.finish();
  ASSERT_EQ(adapter_.mapper().scenes().size(), 1U);
  for (const SceneRow& row : adapter_.mapper().scenes()[0].rows) {
    EXPECT_NEAR(row.world_from_robot.y_m, 0.75, 1e-9);
  }
  // Of 4000: 200 keyframes', and the last ten seconds'.
  EXPECT_LT(adapter_.known_poses(), 320U);
}

// As lidar_raw_t, each beam with its time; the robot drives 1 m/s towards the wall.
TEST_F(Mapping3dOverABus, RowsOfRawScansArePlacedByTheirBeamTimes) {
  for (int i = 0; i < 31; ++i) {
    PanTiltState state;
    state.utime = Utime::from_us(kStepUs * i);
    state.tilt_rad = deg_to_rad(-15.0 + i);
    give(state);
    LaserScan scan;
    scan.utime = state.utime;
    scan.channel = channels::kLidarRaw;
    for (int beam = 0; beam <= 40; ++beam) {
      scan.ranges_m.push_back(2.0F);
      scan.bearings_rad.push_back(static_cast<float>(deg_to_rad(beam - 20)));
      // The second half of the beams first; later one after another.
      const int order = i < 15 ? (beam + 20) % 41 : beam;
      scan.time_offsets_s.push_back(0.001F * static_cast<float>(order));
    }
    if (i == 7) scan.bearings_rad[9] += 0.01F;
    give(scan);
    slam_pose_t pose{};
    pose.utime = state.utime.us;
    pose.x_m = 0.1 * i;
    bus_.publish(channels::kSlamPose, pose);
    bus_.deliver_published();
  }
  adapter_.finish();
  EXPECT_EQ(adapter_.drops().by_cause().at("scan with irregular bearings: not a row of a scene"),
            1);
  ASSERT_EQ(adapter_.mapper().scenes().size(), 1U);
  const Scene& scene = adapter_.mapper().scenes()[0];
  ASSERT_EQ(scene.rows.size(), 30U);
  const SceneRow& row = scene.rows[10];
  EXPECT_NEAR(row.first_robot_from_last_robot.x_m, 0.04, 1e-6);
  ASSERT_EQ(row.beam_parts.size(), 41U);
  EXPECT_NEAR(row.beam_parts[0], 0.5, 1e-3);
  EXPECT_NEAR(row.beam_parts[20], 1.0, 1e-3);
  EXPECT_NEAR(row.beam_parts[21], 0.0, 1e-3);
  // The same range: what was measured 40 ms later lies 4 cm farther along the way.
  const ScenePoints placed = place(scene);
  EXPECT_GT(placed.points_m[placed.index(10, 20)].x() - placed.points_m[placed.index(10, 21)].x(),
            0.035);
  // What takes equal steps needs no times.
  const SceneRow& even = scene.rows[20];
  EXPECT_TRUE(even.beam_parts.empty());
  EXPECT_NEAR(placed.points_m[placed.index(20, 40)].x() - placed.points_m[placed.index(20, 0)].x(),
              0.04, 0.002);
}

TEST(MeshTiles, EachIsBelowTheLimitAndCompleteInItself) {
  TriangleMesh mesh;
  for (int i = 0; i < 30000; ++i) {
    mesh.vertices_m.emplace_back(static_cast<float>(i), 0.0F, 0.0F);
    mesh.normals.emplace_back(0.0F, 0.0F, 1.0F);
  }
  for (uint32_t i = 0; i + 2 < 30000; ++i) mesh.triangles.push_back({i, i + 1, i + 2});
  std::size_t triangles = 0;
  int count = 0;
  for_each_tile(mesh, Utime::from_us(7), 3, [&](const mesh_t& tile) {
    EXPECT_LT(tile.getEncodedSize(), 300000);
    EXPECT_EQ(tile.tile, count++);
    for (const auto& triangle : tile.triangles) {
      for (const int32_t corner : triangle) EXPECT_LT(corner, tile.num_vertices);
    }
    triangles += tile.triangles.size();
  });
  EXPECT_EQ(triangles, mesh.triangles.size());
  EXPECT_GT(count, 5);
}

}  // namespace
}  // namespace marco::mapping3d
