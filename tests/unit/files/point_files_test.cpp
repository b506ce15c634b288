// What we write comes back the same in each format.
#include <gmock/gmock.h>

#include <random>

#include "common/files/points/point_files.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/tests/support/temporary_folder.hpp"

namespace marco::files {
namespace {

using ::marco::testing::complaint;
using ::marco::testing::TemporaryFolder;
using ::testing::HasSubstr;

struct Ending {
  PointFormat format;
  const char* name;
};
constexpr Ending kFormats[] = {{PointFormat::pcd, "scan.pcd"}, {PointFormat::ply, "scan.ply"},
                               {PointFormat::xyz, "scan.xyz"}, {PointFormat::pts, "scan.pts"},
                               {PointFormat::ptx, "scan.ptx"}, {PointFormat::uos, "scan.3d"}};

struct Holds {
  bool intensity = false, color = false, pose = false;
};

PointCloud random_cloud(Holds holds) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> metres(-90.0F, 90.0F);
  std::uniform_int_distribution<int> byte(0, 255);
  PointCloud cloud;
  cloud.rows = 5;
  for (int i = 0; i < 5 * 40; ++i) {
    cloud.points_m.emplace_back(metres(random), metres(random), metres(random));
    if (holds.intensity) cloud.intensities.push_back(metres(random) * 1e-3F);
    const auto part = [&] { return static_cast<uint8_t>(byte(random)); };
    if (holds.color) cloud.colors_rgb.push_back({part(), part(), part()});
  }
  if (holds.pose) cloud.world_from_scanner = make_pose3({512345.25, -7.125, 31}, 0.3, -0.7, 2.5);
  return cloud;
}

void expect_same(const PointCloud& read, const PointCloud& written, double tolerance_m) {
  ASSERT_EQ(read.points_m.size(), written.points_m.size());
  for (std::size_t i = 0; i < read.points_m.size(); ++i) {
    const Eigen::Vector3d is = read.points_m[i].cast<double>() + read.origin_m;
    const Eigen::Vector3d was = written.points_m[i].cast<double>() + written.origin_m;
    if (!was.allFinite()) {
      EXPECT_FALSE(is.allFinite()) << i;
      continue;
    }
    ASSERT_LT((is - was).cwiseAbs().maxCoeff(), tolerance_m) << i;
  }
  EXPECT_EQ(read.intensities, written.intensities);
  EXPECT_EQ(read.colors_rgb, written.colors_rgb);
  ASSERT_EQ(read.world_from_scanner.has_value(), written.world_from_scanner.has_value());
  if (!read.world_from_scanner) return;
  // 1e-8: degrees and centimetres in as many digits as a double has.
  EXPECT_TRUE(
      read.world_from_scanner->matrix().isApprox(written.world_from_scanner->matrix(), 1e-8));
}

TEST(PointFiles, EveryFormatComesBackWithAllItHolds) {
  const TemporaryFolder folder;
  for (const auto& [format, name] : kFormats) {
    for (int holds = 0; holds < 8; ++holds) {
      SCOPED_TRACE(std::string(name) + " " + std::to_string(holds));
      const auto path = folder.path() / std::to_string(holds) / name;
      std::filesystem::create_directories(path.parent_path());
      std::filesystem::remove(path.parent_path() / "scan.pose");
      const PointCloud cloud = random_cloud({(holds & 1) != 0, (holds & 2) != 0, (holds & 4) != 0});
      write_points(path, format, cloud);
      EXPECT_EQ(point_format_of(path), format);
      const PointCloud read = read_points(path);
      expect_same(read, cloud, 5e-5);
      const bool keeps_rows = format == PointFormat::pcd || format == PointFormat::ptx;
      EXPECT_EQ(read.rows, keeps_rows ? 5U : 0U);
    }
  }
}

// A survey's coordinates: centimetres of 5 000 km need a double.
TEST(PointFiles, FarPointsKeepTheirTenthsOfAMillimetre) {
  const TemporaryFolder folder;
  PointCloud cloud = random_cloud({true, true, false});
  cloud.origin_m = {558312, 5240857, 76};
  for (const auto& [format, name] : kFormats) {
    SCOPED_TRACE(name);
    write_points(folder.path() / name, format, cloud);
    const PointCloud read = read_points(folder.path() / name);
    expect_same(read, cloud, 5e-5);
    EXPECT_NEAR((read.origin_m - cloud.origin_m).norm(), cloud.points_m[0].norm(), 2.0);
    EXPECT_EQ(read.origin_m, read.origin_m.array().round().matrix());
  }
}

// The first point is near: only a later one shows that these are a survey's.
TEST(PointFiles, AFarPointBehindANearOneIsKeptWhole) {
  const TemporaryFolder folder;
  const PointCloud read =
      read_points(folder.write("a.xyz", "9000.12345 3.4 0\n19000.98765 -3.25 1\n9000.5 0 0\n"));
  EXPECT_EQ(read.origin_m, Eigen::Vector3d(9000, 3, 0));
  ASSERT_EQ(read.points_m.size(), 3U);
  EXPECT_NEAR(static_cast<double>(read.points_m[0].x()), 0.12345, 1e-6);
  EXPECT_NEAR(static_cast<double>(read.points_m[1].x()), 10000.98765, 5e-4);
}

TEST(PointFiles, NearPointsAreAsTheFileHasThem) {
  const TemporaryFolder folder;
  PointCloud cloud;
  cloud.points_m = {{9999.5F, -1e-7F, 0.1F}};
  write_points(folder.path() / "a.pcd", PointFormat::pcd, cloud);
  const PointCloud read = read_points(folder.path() / "a.pcd");
  EXPECT_EQ(read.points_m, cloud.points_m);
  EXPECT_TRUE(read.origin_m.isZero());
}

TEST(PointFiles, BeamsWithoutAReturnStayWhereThereAreRows) {
  const TemporaryFolder folder;
  PointCloud cloud = random_cloud({true, true, false});
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const std::size_t i : {0U, 7U, 199U}) cloud.points_m[i] = {nan, nan, nan};
  PointCloud returns = cloud;
  for (const int i : {199, 7, 0}) {
    returns.points_m.erase(returns.points_m.begin() + i);
    returns.intensities.erase(returns.intensities.begin() + i);
    returns.colors_rgb.erase(returns.colors_rgb.begin() + i);
  }
  for (const auto& [format, name] : kFormats) {
    SCOPED_TRACE(name);
    write_points(folder.path() / name, format, cloud);
    const bool keeps_rows = format == PointFormat::pcd || format == PointFormat::ptx;
    expect_same(read_points(folder.path() / name), keeps_rows ? cloud : returns, 5e-5);
  }
}

TEST(PointFiles, WhatIsNoCloudIsRefused) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "a";
  PointCloud cloud = random_cloud({true, true, false});
  cloud.rows = 7;
  EXPECT_THAT(complaint([&] { write_points(path, PointFormat::pcd, cloud); }),
              HasSubstr("200 points are not 7 rows"));
  cloud.rows = 0;
  EXPECT_THAT(complaint([&] { write_points(path, PointFormat::ptx, cloud); }),
              HasSubstr("unorganized"));
  cloud.intensities.pop_back();
  EXPECT_THAT(complaint([&] { write_points(path, PointFormat::ply, cloud); }),
              HasSubstr("one intensity"));
  cloud.intensities.clear();
  EXPECT_THAT(complaint([&] { write_points("/nonexistent/a", PointFormat::ply, cloud); }),
              HasSubstr("/nonexistent/a"));
  EXPECT_FALSE(std::filesystem::exists(path));
}

// By hand from 3DTK's EulerToMatrix4 (Rx · Ry · Rz, left-handed, y up): a point on its z axis,
// ahead.
TEST(ScanPose, SixNumbersAreThoseOf3dtk) {
  const TemporaryFolder folder;
  const Eigen::Vector3d ahead(1, 0, 0), left(0, 1, 0);
  // y alone turns clockwise seen from above, as recordings' planar poses have it.
  const Pose3 turned = *read_scan_pose(folder.write("y", "100 200 300\n0 90 0\n"));
  EXPECT_TRUE(turned.translation().isApprox(Eigen::Vector3d(3, -1, 2), 1e-12));
  EXPECT_TRUE((turned.linear() * ahead).isApprox(-left, 1e-12));
  EXPECT_NEAR(flatten(turned).theta_rad, -M_PI / 2, 1e-12);
  // x and z: first z tilts x (right) to y (up), then x turns y (up) to z (ahead).
  const Pose3 both = *read_scan_pose(folder.write("xz", "0 0 0 90 0 90"));
  EXPECT_TRUE((both.linear() * -left).isApprox(ahead, 1e-12));
  EXPECT_TRUE((both.linear() * ahead).isApprox(-Eigen::Vector3d::UnitZ(), 1e-12));
}

TEST(ScanPose, EveryDirectionComesBack) {
  const TemporaryFolder folder;
  for (const double roll : {-3.0, 0.0, 1.2}) {
    for (const double pitch : {-1.5, 0.0, M_PI / 2}) {
      for (const double yaw : {-M_PI / 2, 0.0, 0.4, M_PI / 2, M_PI}) {
        PointCloud cloud;
        cloud.points_m = {{1, 2, 3}};
        cloud.world_from_scanner = make_pose3({1, -2, 3}, roll, pitch, yaw);
        write_points(folder.path() / "a.3d", PointFormat::uos, cloud);
        SCOPED_TRACE(read_whole_file(folder.path() / "a.pose"));
        expect_same(read_points(folder.path() / "a.3d"), cloud, 5e-5);
      }
    }
  }
}

TEST(ScanPose, IsReadByTheNumberOfItsNumbers) {
  const TemporaryFolder folder;
  const Pose3 pose = make_pose3({1, 2, 3}, 0, 0, M_PI / 2);
  const std::string half = "0.70710678";
  for (const std::string& text :
       {"1 2 3 0 0 " + half + " " + half, "17.5 1 2 3 0 0 " + half + " " + half,
        std::string("0 -1 0 1\n1 0 0 2\n0 0 1 3\n"),
        std::string("0 -1 0 1\n1 0 0 2\n0 0 1 3\n0 0 0 1\n")}) {
    EXPECT_TRUE(read_scan_pose(folder.write("p", text))->isApprox(pose, 1e-6)) << text;
  }
  EXPECT_FALSE(read_scan_pose(folder.path() / "none").has_value());
  const auto said = [&](const char* text) {
    return complaint([&] { read_scan_pose(folder.write("bad.pose", text)); });
  };
  EXPECT_THAT(said("1 2 3 4 5"), HasSubstr("bad.pose: expected a pose of 6, 7, 8, 12 or 16"));
  EXPECT_THAT(said("1 2 3 4 5 x"), HasSubstr("'x' is not a finite number"));
  EXPECT_THAT(said("1 2 3 0 0 0 0"), HasSubstr("not a position and rotation"));
  EXPECT_THAT(said("2 0 0 0 0 2 0 0 0 0 2 0"), HasSubstr("not a rotation"));
  EXPECT_THAT(said("-1 0 0 0 0 1 0 0 0 0 1 0"), HasSubstr("not a rotation"));
}

// A pose that 3DTK's scan matching gave: the robot of the nodding scanner drove on a floor, so that
// it is that of recordings' planar reader, but for a thousandth.
TEST(ScanPose, ARealOneIsThePlanarOne) {
  const TemporaryFolder folder;
  const auto path =
      folder.write("a.pose", "-7.99848 -15.3529 337.973\n1.11333 -0.470508 -0.479231\n\n");
  const Pose2 pose = flatten(*read_scan_pose(path));
  EXPECT_NEAR(pose.x_m, 3.37973, 1e-9);
  EXPECT_NEAR(pose.y_m, 0.0799848, 1e-9);
  EXPECT_NEAR(pose.theta_rad, 0.470508 * M_PI / 180.0, 2e-4);
}

}  // namespace
}  // namespace marco::files
