// marco model, and marco map on the same files: scans of other scanners become one surface.
#include <gmock/gmock.h>

#include <fstream>
#include <numbers>
#include <random>
#include <sstream>

#include "common/files/ply.hpp"
#include "common/files/points/point_files.hpp"
#include "tests/support/analytic_room.hpp"
#include "tests/support/command_test.hpp"

namespace marco {
namespace {

using ::marco::testing::AnalyticRoom;
using ::testing::HasSubstr;

// Three places in the room, and the scanners' headings.
const std::vector<Pose3> kPlaces{make_pose3({0.0, 0.3, 1.4}, 0.0, 0.0, 0.3),
                                 make_pose3({-2.2, -1.0, 1.2}, 0.0, 0.0, 2.5),
                                 make_pose3({2.0, -0.8, 1.5}, 0.0, 0.0, -1.9)};

// All around in steps of a degree, coloured by where a point lies.
PointCloud scan(const Pose3& world_from_scanner, std::mt19937& random) {
  std::normal_distribution<double> noise(0.0, 0.004);
  PointCloud cloud;
  for (int i = 0; i < 360 * 140; ++i) {
    const double azimuth_rad = deg_to_rad(i % 360), elevation_rad = deg_to_rad(i / 360 - 60);
    const Eigen::Vector3d way(std::cos(azimuth_rad) * std::cos(elevation_rad) + 1e-7,
                              std::sin(azimuth_rad) * std::cos(elevation_rad) + 2e-7,
                              std::sin(elevation_rad) + 3e-7);
    const double range_m =
        AnalyticRoom::range_m(world_from_scanner.translation(), world_from_scanner.linear() * way) +
        noise(random);
    const Eigen::Vector3d point_m = range_m * way;
    cloud.points_m.push_back(point_m.cast<float>());
    const bool is_low = (world_from_scanner * point_m).z() < 1.4;
    cloud.colors_rgb.push_back(is_low ? std::array<uint8_t, 3>{200, 40, 40}
                                      : std::array<uint8_t, 3>{40, 40, 200});
  }
  return cloud;
}

class ModelProcess : public testing::CommandTest {
 protected:
  // Each in a format of its own; the rows of the last are none of a tilted laser.
  void write_scans(bool with_poses) {
    const std::vector<std::pair<std::string, files::PointFormat>> formats{
        {"a.pcd", files::PointFormat::pcd},
        {"b.ply", files::PointFormat::ply},
        {"c.3d", files::PointFormat::uos}};
    std::filesystem::create_directory(at("scans"));
    std::mt19937 random(4);
    for (std::size_t i = 0; i < kPlaces.size(); ++i) {
      PointCloud cloud = scan(kPlaces[i], random);
      const double side = i % 2 == 0 ? 1.0 : -1.0;
      const Pose3 off = make_pose3({0.08 * side, -0.06 * side, 0.02}, 0.0, 0.0, 0.015 * side);
      if (with_poses) cloud.world_from_scanner = kPlaces[i] * off;
      files::write_points(at("scans/" + formats[i].first), formats[i].second, cloud);
    }
  }
  std::vector<Pose3> poses() const {
    std::vector<Pose3> all;
    std::ifstream file(at("out/poses.txt"));
    std::string line;
    while (std::getline(file, line)) {
      if (line.starts_with("#")) continue;
      std::istringstream words(line);
      std::string name;
      double x = 0, y = 0, z = 0, qx = 0, qy = 0, qz = 0, qw = 0;
      words >> name >> x >> y >> z >> qx >> qy >> qz >> qw;
      Pose3 pose = Pose3::Identity();
      pose.translation() = Eigen::Vector3d(x, y, z);
      pose.linear() = Eigen::Quaterniond(qw, qx, qy, qz).toRotationMatrix();
      all.push_back(pose);
    }
    return all;
  }
  // How the scans lie to each other; where all lie together is the poses' affair.
  void expect_right_poses() const {
    const std::vector<Pose3> found = poses();
    ASSERT_EQ(found.size(), kPlaces.size());
    for (std::size_t i = 1; i < found.size(); ++i) {
      const Pose3 wrong =
          (kPlaces[0].inverse() * kPlaces[i]).inverse() * found[0].inverse() * found[i];
      EXPECT_LT(wrong.translation().norm(), 0.005) << i;
      EXPECT_LT(Eigen::AngleAxisd(wrong.linear()).angle(), deg_to_rad(0.1)) << i;
    }
  }
};

TEST_F(ModelProcess, ScansWithRoughPosesBecomeOneColouredSurface) {
  write_scans(true);
  const Result result = run("marco-model", {at("scans"), "--out", at("out"), "--points", "pcd"});
  ASSERT_EQ(result.code, 0) << result.output;
  EXPECT_THAT(result.output, HasSubstr("verdict: good"));
  expect_right_poses();
  const TriangleMesh mesh = files::read_ply(at("out/model.ply"));
  ASSERT_EQ(mesh.colors_rgb.size(), mesh.vertices_m.size());
  const Pose3 room_from_model = kPlaces[0] * poses()[0].inverse();
  std::size_t right = 0, low = 0, red = 0;
  for (std::size_t i = 0; i < mesh.vertices_m.size(); ++i) {
    const Eigen::Vector3d at_m = room_from_model * mesh.vertices_m[i].cast<double>();
    const double off_m =
        std::min({std::abs(std::abs(at_m.x()) - 4.0), std::abs(std::abs(at_m.y()) - 3.0),
                  std::abs(at_m.z()), std::abs(at_m.z() - 2.8)});
    right += off_m < 0.015 ? 1 : 0;
    if (at_m.z() > 1.3) continue;
    ++low;
    red += mesh.colors_rgb[i][0] > 150 ? 1 : 0;
  }
  EXPECT_GT(right, mesh.vertices_m.size() * 8 / 10);  // others lie on the boxes
  EXPECT_GT(red, low * 98 / 100);
  const PointCloud all = files::read_points(at("out/points.pcd"));
  EXPECT_EQ(all.points_m.size(), 3U * 360U * 140U);
  EXPECT_EQ(all.colors_rgb.size(), all.points_m.size());
}

TEST_F(ModelProcess, ScansWithoutPosesAreFoundInEachOther) {
  write_scans(false);
  // By marco map, as somebody would who does not know of marco model.
  const Result result = run("marco-map", {at("scans"), "--out", at("out")});
  ASSERT_EQ(result.code, 0) << result.output;
  EXPECT_THAT(result.output, HasSubstr("verdict: good"));
  expect_right_poses();
}

TEST_F(ModelProcess, AScanOfAnotherBuildingIsLeftOutAndNamed) {
  write_scans(true);
  std::mt19937 random(5);
  PointCloud other;  // a low cellar, 20 m long
  for (int i = 0; i < 20000; ++i) {
    const double along = 20.0 * (i % 200) / 200.0 - 10.0,
                 turn = 2.0 * std::numbers::pi * (i / 200) / 100;
    other.points_m.emplace_back(along, 0.9 * std::cos(turn), 0.9 * std::sin(turn));
  }
  files::write_points(at("scans/d.xyz"), files::PointFormat::xyz, other);
  const Result result = run("marco-model", {at("scans"), "--out", at("out")});
  EXPECT_EQ(result.code, 1) << result.output;
  EXPECT_THAT(result.output, HasSubstr("d.xyz: left out"));
  EXPECT_THAT(result.output, HasSubstr("verdict: doubtful: 1 of 4 scans are left out"));
  EXPECT_EQ(poses().size(), 3U);
}

TEST_F(ModelProcess, FilesThatAreNoScanAreRefusedWithTheReason) {
  std::mt19937 random(6);
  PointCloud merged = scan(kPlaces[0], random);
  for (const Eigen::Vector3f& to : {Eigen::Vector3f(9, 0, 0), Eigen::Vector3f(-9, 0, 0),
                                    Eigen::Vector3f(0, 7, 0), Eigen::Vector3f(0, -7, 0)}) {
    for (std::size_t i = 0; i < 360 * 140; ++i) {
      merged.points_m.push_back(merged.points_m[i] + to);
      merged.colors_rgb.push_back(merged.colors_rgb[i]);
    }
  }
  files::write_points(at("merged.ply"), files::PointFormat::ply, merged);
  const Result result = run("marco-model", {at("merged.ply"), "--out", at("out")});
  EXPECT_EQ(result.code, 1);
  EXPECT_THAT(result.output, HasSubstr("merged.ply: these points were not seen from the origin"));
  EXPECT_FALSE(std::filesystem::exists(at("out")));
  files::write_whole_file(at("note.txt"), "no points here\n");
  const Result none = run("marco-model", {at("note.txt"), "--out", at("out")});
  EXPECT_EQ(none.code, 1);
  EXPECT_THAT(none.output, HasSubstr("note.txt: contains no points"));
}

}  // namespace
}  // namespace marco
