#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <numbers>
#include <sstream>
#include <string>

#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "mapping3d/point_tree.hpp"
#include "mapping3d/process/mapping3d_adapter.hpp"
#include "mapping3d/registration.hpp"
#include "mapping3d/straightening.hpp"
#include "tests/support/real_data.hpp"
#include "tools/map/map_job.hpp"

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

struct Point {
  Eigen::Vector3f at_m;
  Eigen::Vector3f normal;  ///< towards the laser, of the plane through the nearest of its scan
  Eigen::Vector3f mean_m;  ///< of those
};

/// All points of a scan, each with the plane through its 16 nearest: looked for among the beams
/// about it, not in the mesh and not in the patches that the registration goes by.
std::vector<Point> points_with_normals(const ScenePoints& scene) {
  constexpr std::size_t kWindow = 4, kNearest = 16;
  std::vector<Point> points;
  std::vector<std::pair<float, Eigen::Vector3f>> about;
  for (std::size_t row = 0; row < scene.rows; ++row) {
    for (std::size_t column = 0; column < scene.columns; ++column) {
      if (scene.valid[scene.index(row, column)] == 0) continue;
      const Eigen::Vector3f p = scene.points_m[scene.index(row, column)];
      about.clear();
      for (std::size_t r = row - std::min(row, kWindow);
           r <= std::min(row + kWindow, scene.rows - 1); ++r) {
        for (std::size_t c = column - std::min(column, kWindow);
             c <= std::min(column + kWindow, scene.columns - 1); ++c) {
          const Eigen::Vector3f& q = scene.points_m[scene.index(r, c)];
          if (scene.valid[scene.index(r, c)] != 0) about.emplace_back((q - p).squaredNorm(), q);
        }
      }
      if (about.size() < kNearest) continue;
      std::nth_element(about.begin(), about.begin() + kNearest - 1, about.end(),
                       [](const auto& a, const auto& b) { return a.first < b.first; });
      Eigen::Vector3f mean = Eigen::Vector3f::Zero();
      for (std::size_t i = 0; i < kNearest; ++i) mean += about[i].second;
      mean /= static_cast<float>(kNearest);
      Eigen::Matrix3f spread = Eigen::Matrix3f::Zero();
      for (std::size_t i = 0; i < kNearest; ++i) {
        spread += (about[i].second - mean) * (about[i].second - mean).transpose();
      }
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> solver(spread);
      Eigen::Vector3f normal = solver.eigenvectors().col(0);
      if (normal.dot(p - scene.origins_m[row]) > 0.0F) normal = -normal;
      points.push_back({p, normal, mean});
    }
  }
  return points;
}

struct Residuals {
  double median_m = 0.0;
  double p90_m = 0.0;
  double thickness_p95_m = 0.0;  ///< of walls: between the two scans' local planes
  std::size_t count = 0;
};

double at_part(std::vector<double>& values, double part) {
  if (values.empty()) return 1e9;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(part * static_cast<double>(values.size() - 1))];
}

/// Point to plane over all points whose nearest neighbour lies within 0.25 m, normals within 45
/// deg. Two sheets of one wall: nearest within 0.1 m, normals within 20 deg; the distance of the
/// planes through 16 points each, so the laser's noise is out of it.
Residuals compare(const std::vector<Point>& target, const std::vector<Point>& moved) {
  std::vector<Eigen::Vector3f> at_m;
  for (const Point& point : target) at_m.push_back(point.at_m);
  const PointTree tree(at_m);
  std::vector<double> residuals_m, thickness_m;
  for (const Point& point : moved) {
    const auto nearest = tree.nearest(point.at_m, 0.25F);
    if (!nearest) continue;
    const Point& other = target[*nearest];
    const float cosine = other.normal.dot(point.normal);
    if (cosine < std::sqrt(0.5F)) continue;
    const Eigen::Vector3f apart = point.at_m - other.at_m;
    residuals_m.push_back(static_cast<double>(std::abs(other.normal.dot(apart))));
    if (cosine < 0.94F || apart.squaredNorm() > 0.01F) continue;
    thickness_m.push_back(
        static_cast<double>(std::abs(other.normal.dot(point.mean_m - other.mean_m))));
  }
  const std::size_t count = residuals_m.size();
  return {at_part(residuals_m, 0.5), at_part(residuals_m, 0.9), at_part(thickness_m, 0.95), count};
}

TEST(NoddingScans, JoinWithSingleWalls) {
  const char* data = marco::testing::real_data();
  if (data == nullptr) return;
  std::vector<Scene> scenes;
  std::vector<ScenePoints> placed;
  for (const char* name : {"scan000", "scan001", "scan002"}) {
    const std::string stem = std::string(data) + "/nodding_lms/" + name;
    Scene scene = read_tilt_ranges(stem + "_tilt_ranges_mm.csv");
    ASSERT_EQ(scene.rows.size(), 226U);
    const Pose2 guess = read_pose(stem + ".pose");
    for (SceneRow& row : scene.rows) row.world_from_robot = guess;
    placed.push_back(place(scene));
    scenes.push_back(scene);
  }
  const RegistrationResult result = register_scenes(placed);
  std::printf("registration: %s after %d iterations\n", to_string(result.status).c_str(),
              result.iterations);
  const Straightening straight = straighten(scenes, {}, result.world_from_placed, {});
  std::printf("rows explain %.2f of it: turned by %.2f deg rms, ranges %.4f m longer\n",
              straight.explained, rad_to_deg(straight.turn_rms_rad), straight.range_m);
  ASSERT_TRUE(straight.bent);
  std::vector<std::vector<Point>> before, after;
  for (std::size_t i = 0; i < placed.size(); ++i) {
    before.push_back(points_with_normals(placed[i]));
    placed[i] = place(straightened(scenes[i], straight.turns_rad[i], straight.range_m));
    move(placed[i], straight.world_from_placed[i]);
    after.push_back(points_with_normals(placed[i]));
  }
  for (std::size_t i = 0; i + 1 < placed.size(); ++i) {
    const Residuals guessed = compare(before[i], before[i + 1]);
    const Residuals joined = compare(after[i], after[i + 1]);
    std::printf(
        "scans %zu-%zu: median %.4f -> %.4f m, p90 %.4f -> %.4f m, walls thick p95 %.4f -> %.4f m "
        "over %zu points\n",
        i, i + 1, guessed.median_m, joined.median_m, guessed.p90_m, joined.p90_m,
        guessed.thickness_p95_m, joined.thickness_p95_m, joined.count);
    EXPECT_LE(joined.median_m, 0.010);
    EXPECT_LE(joined.p90_m, 0.060);
    EXPECT_LE(joined.thickness_p95_m, 0.040);
  }
}

/// Scans of a robot that stands, by `marco map` itself.
TEST(NoddingScans, AreAsSharpThroughTheFrontDoorAndTheRobotStands) {
  const char* data = marco::testing::real_data();
  if (data == nullptr) return;
  for (const auto& [set, stops] : {std::pair{"nodding_lms", 3U}, {"nodding_lms_interlaced", 1U}}) {
    const testing::TemporaryFolder folder;
    MapJob job(folder.path());
    job.read({std::string(data) + "/" + set}, {});
    job.finish();
    std::size_t moves = 0;
    const Trajectory path = job.trajectory();
    for (std::size_t i = 1; i < path.size(); ++i) {
      moves += path[i].world_from_robot.vector() != path[i - 1].world_from_robot.vector() ? 1 : 0;
    }
    EXPECT_EQ(moves, stops - 1) << set;
    // A frame 1.46 m to the left, at the axis of the tilt.
    const bool has_frame = stops > 1;
    ASSERT_EQ(job.calibration().body.size(), has_frame ? 1U : 0U) << set;
    if (has_frame) {
      EXPECT_NEAR(job.calibration().body[0].last_deg, 90.0, 1.5);
      EXPECT_NEAR(job.calibration().body[0].within_m, 1.52, 0.03);
    }
    std::vector<std::vector<Point>> scans;
    for (const ScenePoints& scene : job.mapping3d().mapper().placed()) {
      scans.push_back(points_with_normals(scene));
    }
    ASSERT_EQ(scans.size(), stops) << set;
    for (std::size_t i = 0; i + 1 < scans.size(); ++i) {
      const Residuals joined = compare(scans[i], scans[i + 1]);
      std::printf("%s %zu-%zu: median %.4f m, p90 %.4f m, walls thick p95 %.4f m\n", set, i, i + 1,
                  joined.median_m, joined.p90_m, joined.thickness_p95_m);
      EXPECT_LE(joined.median_m, 0.007);
      EXPECT_LE(joined.thickness_p95_m, 0.026);
    }
  }
}

/// Of a robot that stands in a ship and shows nothing of itself.
TEST(TiltingLaser, NothingOfTheRoomIsTakenForTheRobot) {
  const char* data = marco::testing::real_data();
  if (data == nullptr) return;
  const testing::TemporaryFolder folder;
  MapJob job(folder.path());
  job.read({std::string(data) + "/rosbags/ship_interior_with_tilting_laser.bag"}, {});
  job.finish();
  EXPECT_EQ(job.mapping3d().mapper().scenes().size(), 3U);
  EXPECT_TRUE(job.calibration().body.empty()) << describe(job.calibration().body);
}

/// Lines of: line, tilt [deg], bearing [deg], range [m].
Scene read_polar(const std::string& path) {
  std::ifstream file(path);
  std::string line;
  Scene scene;
  double number = -1.0;
  while (std::getline(file, line)) {
    if (line.empty() || line[0] == '#') continue;
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream values(line);
    double index = 0.0, tilt_deg = 0.0, bearing_deg = 0.0, range_m = 0.0;
    values >> index >> tilt_deg >> bearing_deg >> range_m;
    if (index != number) {
      number = index;
      SceneRow row;
      row.first_bearing_rad = deg_to_rad(-90.0 + bearing_deg - std::floor(bearing_deg));
      row.bearing_step_rad = deg_to_rad(1.0);
      row.ranges_m.assign(181, 0.0F);
      row.robot_from_sensor_first =
          make_pose3({0.0, 0.0, 0.340}, 0.0, -deg_to_rad(tilt_deg)) * make_pose3({0.0, 0.0, 0.160});
      row.robot_from_sensor_last = row.robot_from_sensor_first;
      scene.rows.push_back(row);
    }
    SceneRow& row = scene.rows.back();
    const double column = (deg_to_rad(bearing_deg) - row.first_bearing_rad) / row.bearing_step_rad;
    row.ranges_m[static_cast<std::size_t>(std::lround(column))] = static_cast<float>(range_m);
  }
  return scene;
}

TEST(InterlacedScan, HasAFlatFloor) {
  const char* data = marco::testing::real_data();
  if (data == nullptr) return;
  const ScenePoints scene =
      place(read_polar(std::string(data) + "/nodding_lms_interlaced/scan_polar.csv"));
  ASSERT_EQ(scene.rows, 491U);
  // The floor: points near z = 0 whose own plane lies level; then the plane z = a x + b y + c
  // through them, twice, the second time without what stands on it.
  std::vector<Eigen::Vector3f> floor;
  for (const Point& point : points_with_normals(scene)) {
    if (std::abs(point.at_m.z()) < 0.1F && point.normal.z() > 0.94F) floor.push_back(point.at_m);
  }
  Eigen::Vector3d plane = Eigen::Vector3d::Zero();
  double rms_m = 0.0;
  std::size_t count = 0;
  for (const double within_m : {0.1, 0.04}) {
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3f& p : floor) {
      const Eigen::Vector3d row(static_cast<double>(p.x()), static_cast<double>(p.y()), 1.0);
      if (std::abs(row.dot(plane) - static_cast<double>(p.z())) > within_m) continue;
      information += row * row.transpose();
      sum += static_cast<double>(p.z()) * row;
    }
    plane = information.ldlt().solve(sum);
  }
  for (const Eigen::Vector3f& p : floor) {
    const double above_m =
        static_cast<double>(p.z()) - plane.z() - plane.head<2>().dot(p.head<2>().cast<double>());
    if (std::abs(above_m) > 0.04) continue;
    rms_m += above_m * above_m;
    ++count;
  }
  rms_m = std::sqrt(rms_m / static_cast<double>(count));
  std::printf("floor: %.4f m rms over %zu of %zu points, at %.4f m, %.3f deg from level\n", rms_m,
              count, floor.size(), plane.z(), rad_to_deg(std::atan(plane.head<2>().norm())));
  EXPECT_GT(count, 5000U);
  EXPECT_LE(rms_m, 0.009);
}

}  // namespace
}  // namespace marco::mapping3d
