#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <numbers>
#include <sstream>
#include <string>

#include "mapping3d/point_tree.hpp"
#include "mapping3d/registration.hpp"
#include "mapping3d/scene_mesh.hpp"

namespace marco::mapping3d {
namespace {

/// Rows of tilt [deg] and 360 ranges [mm]; beam j at j * 0.5 deg, 0 = right, 90 = ahead.
Scene read_tilt_ranges(const std::string& path) {
  std::ifstream file(path);
  std::string line;
  Scene scene;
  while (std::getline(file, line)) {
    if (line.empty() || line[0] == '#') continue;
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream values(line);
    double tilt_deg = 0.0, range_mm = 0.0;
    values >> tilt_deg;
    SceneRow row;
    row.first_bearing_rad = -0.5 * std::numbers::pi;
    row.bearing_step_rad = deg_to_rad(0.5);
    while (values >> range_mm) {
      const bool returned = range_mm >= 480.0 && range_mm < 32700.0;
      row.ranges_m.push_back(returned ? static_cast<float>(range_mm * 1e-3) : 0.0F);
    }
    row.robot_from_sensor_first =
        make_pose3(Eigen::Vector3d::Zero(), 0.0, -deg_to_rad(tilt_deg), 0.0);
    row.robot_from_sensor_last = row.robot_from_sensor_first;
    scene.rows.push_back(row);
  }
  return scene;
}

/// The start guess: x right, y up, z ahead [cm], then the turn to the right about y [deg].
Pose2 read_pose(const std::string& path) {
  std::ifstream file(path);
  double x = 0.0, y = 0.0, z = 0.0, about_x = 0.0, about_y = 0.0;
  file >> x >> y >> z >> about_x >> about_y;
  return {0.01 * z, -0.01 * x, -deg_to_rad(about_y)};
}

struct Residuals {
  double median_m = 0.0;
  double p90_m = 0.0;
  std::size_t count = 0;
};

/// Point to plane over all vertices whose nearest neighbour lies within 0.25 m, normals within
/// 45 deg.
Residuals compare(const TriangleMesh& target, const TriangleMesh& moved) {
  const PointTree tree(target.vertices_m);
  std::vector<double> residuals;
  for (std::size_t i = 0; i < moved.vertices_m.size(); ++i) {
    const auto nearest = tree.nearest(moved.vertices_m[i], 0.25F);
    if (!nearest) continue;
    const Eigen::Vector3f& normal = target.normals[*nearest];
    if (normal.dot(moved.normals[i]) < std::sqrt(0.5F)) continue;
    residuals.push_back(static_cast<double>(
        std::abs(normal.dot(moved.vertices_m[i] - target.vertices_m[*nearest]))));
  }
  std::sort(residuals.begin(), residuals.end());
  if (residuals.empty()) return {};
  return {residuals[residuals.size() / 2], residuals[residuals.size() * 9 / 10], residuals.size()};
}

ScenePoints moved(ScenePoints scene, const Pose3& to_from) {
  for (Eigen::Vector3f& p : scene.points_m) p = (to_from * p.cast<double>()).cast<float>();
  for (Eigen::Vector3f& p : scene.origins_m) p = (to_from * p.cast<double>()).cast<float>();
  return scene;
}

TEST(NoddingScans, JoinBetterThanTheirStartGuess) {
  const char* data = std::getenv("MARCO_TEST_DATA");
  if (data == nullptr) {
    std::printf("SKIPPED: MARCO_TEST_DATA is not set\n");
    return;
  }
  std::vector<ScenePoints> placed;
  for (const char* name : {"scan000", "scan001", "scan002"}) {
    const std::string stem = std::string(data) + "/nodding_lms/" + name;
    Scene scene = read_tilt_ranges(stem + "_tilt_ranges_mm.csv");
    ASSERT_EQ(scene.rows.size(), 226U);
    const Pose2 guess = read_pose(stem + ".pose");
    for (SceneRow& row : scene.rows) row.world_from_robot = guess;
    placed.push_back(place(scene));
  }
  const RegistrationResult result = register_scenes(placed);
  EXPECT_TRUE(result.converged);
  std::vector<TriangleMesh> before, after;
  for (std::size_t i = 0; i < placed.size(); ++i) {
    before.push_back(mesh_scene(placed[i]));
    after.push_back(mesh_scene(moved(placed[i], result.world_from_placed[i])));
  }
  for (std::size_t i = 0; i + 1 < placed.size(); ++i) {
    const Residuals guessed = compare(before[i], before[i + 1]);
    const Residuals joined = compare(after[i], after[i + 1]);
    std::printf("scans %zu-%zu: median %.4f -> %.4f m, p90 %.4f -> %.4f m over %zu points\n", i,
                i + 1, guessed.median_m, joined.median_m, guessed.p90_m, joined.p90_m,
                joined.count);
    // The goals of the joined model: what remains is this robot's bent sweep, not the pose.
    EXPECT_LE(joined.median_m, 0.010);
    EXPECT_LE(joined.p90_m, 0.060);
  }
}

}  // namespace
}  // namespace marco::mapping3d
