// What is kept, drawn and reported of a short drive.
#include "tools/map/map_job.hpp"

#include <gmock/gmock.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "common/files/tum.hpp"
#include "common/triangle_mesh.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "short_drive.hpp"
#include "slam/doctor/doctor.hpp"
#include "slam/process/mapper2d_adapter.hpp"
#include "tests/support/matchers.hpp"
#include "tools/map/pictures.hpp"
#include "tools/map/report.hpp"
#include "tools/map/results.hpp"

namespace marco {
namespace {

using ::marco::testing::IsNear;
using ::marco::testing::kScans;
using ::marco::testing::ShortDrive;

TEST_F(ShortDrive, EachScanHasAPoseAndTheTimeIsThatFromTheFirstToTheLast) {
  EXPECT_EQ(job_->trajectory().size(), kScans);
  EXPECT_NEAR(job_->recorded_s(), 51.9, 1e-6);
  EXPECT_EQ(job_->trajectory().front().utime.us, 1000'000'000);
  const auto evidence = job_->evidence();
  ASSERT_TRUE(evidence);
  ASSERT_EQ(evidence->paths.size(), 1U);
  EXPECT_EQ(evidence->paths[0].path.size(), kScans);
  EXPECT_EQ(evidence->paths[0].odometry.size(), kScans);
  EXPECT_EQ(evidence->scans, static_cast<int>(kScans));
  EXPECT_EQ(evidence->matched_scans, static_cast<int>(kScans) - 1);
  EXPECT_EQ(evidence->loops.size(), job_->mapper().loops().size());
}

// In a loop's picture both scans are seen by the older one's robot; a point is a cross of 4 cm.
TEST_F(ShortDrive, ALoopsPictureShowsTheNewerScanBeforeAndAfterItOverTheOlderOne) {
  const std::vector<slam::Loop>& loops = job_->mapper().loops();
  const std::vector<PictureOrder> orders = loop_pictures("loops", *job_);
  ASSERT_FALSE(loops.empty());
  ASSERT_EQ(orders.size(), loops.size());
  EXPECT_EQ(orders[0].path, "loops/000.png");
  EXPECT_TRUE(orders[0].flat);
  for (std::size_t i = 0; i < loops.size(); ++i) {
    const viewer::Scene& scene = orders[i].scene;
    ASSERT_EQ(scene.points.size(), 3U);
    ASSERT_EQ(scene.robots.size(), 3U);
    const Pose2 places[] = {{}, loops[i].believed, loops[i].from_from_to};
    const int shown[] = {loops[i].from, loops[i].to, loops[i].to};
    for (std::size_t part = 0; part < 3; ++part) {
      const Points2 hits = places[part] * key(shown[part]).points_in_robot.points;
      const auto& drawn = scene.points[part].points_m;
      ASSERT_EQ(drawn.size(), 5 * static_cast<std::size_t>(hits.cols()));
      for (std::size_t dot = 0; dot < drawn.size(); ++dot) {
        const Eigen::Vector2d at = drawn[dot].head<2>().cast<double>();
        const double off_m = (at - hits.col(static_cast<Eigen::Index>(dot / 5))).norm();
        EXPECT_NEAR(off_m, dot % 5 == 0 ? 0.0 : 0.02, 1e-5);
      }
      EXPECT_THAT(scene.robots[part].world_from_robot, IsNear(places[part], 1e-9, 1e-9));
    }
    EXPECT_EQ(scene.points[2].label.find("REJECTED") == std::string::npos, loops[i].is_inlier);
  }
}

TEST_F(ShortDrive, TheMapsPictureShowsAllScansAndThePathByOdometryAndAsFound) {
  const PictureOrder order = map_picture("map.png", job_->grid(), *job_);
  EXPECT_TRUE(order.scene.grid);
  std::size_t points = 0;
  for (const slam::Keyframe& one : job_->keyframes()) {
    points += static_cast<std::size_t>(one.points_in_robot.points.cols());
  }
  ASSERT_EQ(order.scene.points.size(), 1U);
  EXPECT_EQ(order.scene.points[0].points_m.size(), points);
  ASSERT_EQ(order.scene.paths.size(), 2U);
  EXPECT_EQ(order.scene.paths[0].label, "odometry");
  EXPECT_EQ(order.scene.paths[0].poses.size(), kScans);
  EXPECT_EQ(order.scene.paths[1].label, "estimate");
  EXPECT_EQ(order.scene.paths[1].poses.size(), kScans);
  // Odometry that leaves the map only shrinks the picture: it ends 5 m beyond it.
  GridMap corner = job_->grid();
  corner.width_cells = corner.height_cells = 40;
  corner.origin_m = {-1.0, -1.0};
  const PictureOrder cut = map_picture("map.png", corner, *job_);
  const Trajectory& kept = cut.scene.paths[0].poses;
  ASSERT_GT(kept.size(), 30U);
  EXPECT_LT(kept.size(), 80U);
  EXPECT_NEAR(kept.back().world_from_robot.x_m, 6.0, 0.11);
}

TEST_F(ShortDrive, AllOrdersOfPicturesReachTheProgramThatDraws) {
  std::vector<PictureOrder> orders = loop_pictures("loops", *job_);
  orders.push_back(map_picture("map.png", job_->grid(), *job_));
  orders.back().camera = "above";
  orders.back().flat = false;
  orders.back().scene.walls.push_back({{1, 2}, {3, 4}, 2.2, {9, 8, 7}});
  orders.back().scene.ellipses.push_back(
      {{5, 6}, 0.5 * Eigen::Matrix2d::Identity(), 1.0, {4, 5, 6}});
  orders.back().scene.robots.push_back({{1, 2, 3}, 0.15, 0.25, {7, 8, 9}});
  TriangleMesh mesh;
  mesh.vertices_m = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}};
  orders.back().scene.meshes.push_back({std::make_shared<const TriangleMesh>(mesh), {1, 2, 3}});
  const std::string bytes = encode_picture_orders(orders);
  const std::vector<PictureOrder> read = decode_picture_orders(bytes);
  ASSERT_EQ(read.size(), orders.size());
  for (std::size_t i = 0; i < read.size(); ++i) {
    EXPECT_EQ(read[i].path, orders[i].path);
    EXPECT_EQ(read[i].flat, orders[i].flat);
    EXPECT_EQ(read[i].camera, orders[i].camera);
    ASSERT_EQ(read[i].scene.points.size(), orders[i].scene.points.size());
    for (std::size_t item = 0; item < read[i].scene.points.size(); ++item) {
      const viewer::PointsItem &one = read[i].scene.points[item],
                               &was = orders[i].scene.points[item];
      EXPECT_EQ(one.points_m, was.points_m);
      EXPECT_EQ(one.label, was.label);
      EXPECT_EQ(one.color.red, was.color.red);
      EXPECT_EQ(one.color.green, was.color.green);
      EXPECT_EQ(one.color.blue, was.color.blue);
    }
    ASSERT_EQ(read[i].scene.robots.size(), orders[i].scene.robots.size());
    EXPECT_EQ(read[i].scene.paths.size(), orders[i].scene.paths.size());
  }
  const viewer::Scene& last = read.back().scene;
  EXPECT_EQ(last.grid->occupancy, job_->grid().occupancy);
  EXPECT_EQ(last.grid->width_cells, job_->grid().width_cells);
  EXPECT_EQ(last.paths[1].poses.size(), kScans);
  EXPECT_EQ(last.walls.at(0).to_m, Eigen::Vector2d(3, 4));
  EXPECT_EQ(last.walls[0].color.blue, 7);
  EXPECT_EQ(last.ellipses.at(0).covariance_m2(1, 1), 0.5);
  EXPECT_EQ(last.ellipses[0].sigmas, 1.0);
  EXPECT_EQ(last.ellipses[0].color.green, 5);
  EXPECT_EQ(last.robots.back().radius_m, 0.15);
  EXPECT_EQ(last.robots.back().height_m, 0.25);
  EXPECT_EQ(last.robots.back().color.blue, 9);
  ASSERT_EQ(last.meshes.size(), 1U);
  EXPECT_EQ(last.meshes[0].mesh->vertices_m, mesh.vertices_m);
  EXPECT_EQ(last.meshes[0].mesh->triangles.size(), 1U);
  EXPECT_EQ(last.meshes[0].color.red, 1);
  EXPECT_THROW(decode_picture_orders(bytes.substr(0, bytes.size() - 1)), std::invalid_argument);
}

TEST_F(ShortDrive, TheReportSaysWhatWasDrivenReadAndClosed) {
  const auto name = folder_->path() / "report.json";
  write_report(name, *job_, {});
  const auto report = nlohmann::json::parse(files::read_whole_file(name));
  EXPECT_EQ(report.at("path_of"), "robot");
  EXPECT_NEAR(report.at("distance_m").get<double>(), 48.0, 1.0);  // 40 of 520 steps are turns
  EXPECT_NEAR(report.at("recorded_s").get<double>(), 51.9, 1e-6);
  EXPECT_EQ(report.at("scans").at("posed"), kScans);
  EXPECT_EQ(report.at("scans").at("level"), kScans);
  EXPECT_EQ(report.at("scans").at("held_out"), 0);
  EXPECT_EQ(report.at("scans").at("keyframes"), job_->keyframes().size());
  double wall_s = 0.0, cpu_s = 0.0;
  for (const auto& stage : report.at("stages")) {
    wall_s += stage.at("wall_s").get<double>();
    cpu_s += stage.at("cpu_s").get<double>();
  }
  EXPECT_NEAR(report.at("wall_s").get<double>(), wall_s, 1e-9);
  EXPECT_NEAR(report.at("cpu_s").get<double>(), cpu_s, 1e-9);
  EXPECT_NEAR(report.at("real_time_factor").get<double>() * wall_s, 51.9, 1e-6);
  for (const auto& loop : report.at("loops")) {
    const slam::Keyframe &from = key(loop.at("from_key")), &to = key(loop.at("to_key"));
    EXPECT_EQ(loop.at("from_utime"), from.utime.us);
    EXPECT_EQ(loop.at("to_utime"), to.utime.us);
    EXPECT_NEAR(loop.at("path_between_m").get<double>(), 36.0, 3.0);
    for (const char* sigma : {"sigma_x_m", "sigma_y_m", "sigma_theta_rad"}) {
      EXPECT_GT(loop.at(sigma).get<double>(), 1e-5);
      EXPECT_LT(loop.at(sigma).get<double>(), 0.2);
    }
  }
  for (const char* absent : {"errors", "surface", "photographs", "verdict", "calibration",
                             "kept_apart", "place_in_saved_map", "scenes", "own_body", "floor"}) {
    EXPECT_FALSE(report.contains(absent)) << absent;
  }
}

TEST_F(ShortDrive, ItsPathsAreWrittenAndTheRobotsAsFoundWhereThatIsAnother) {
  const auto at = [](const char* name) { return folder_->path() / name; };
  write_paths(folder_->path(), *job_, std::nullopt);
  EXPECT_EQ(files::read_tum(at("trajectory.tum").string()).size(), kScans);
  EXPECT_EQ(files::read_tum(at("trajectory_live.tum").string()).size(), kScans);
  EXPECT_EQ(files::read_tum(at("odometry.tum").string()).size(), kScans);
  EXPECT_FALSE(std::filesystem::exists(at("truth.tum")));
  EXPECT_FALSE(std::filesystem::exists(at(kPathAsFound)));
  SelfCorrection correction;
  correction.assumed_from_found_robot = Pose2{0.0, 1.0, 0.5};
  write_paths(folder_->path(), *job_, correction);
  const Trajectory found = files::read_tum(at(kPathAsFound).string());
  ASSERT_EQ(found.size(), kScans);
  EXPECT_THAT(between(job_->trajectory()[200].world_from_robot, found[200].world_from_robot),
              IsNear(Pose2{0.0, 1.0, 0.5}, 1e-4, 1e-4));
}

TEST(PathLength, IsTheSumOfItsSteps) {
  EXPECT_EQ(path_length_m({}), 0.0);
  EXPECT_NEAR(path_length_m({{{}, {0, 0, 0}}, {{}, {3, 4, 1}}, {{}, {3, 3, 0}}, {{}, {0, 3, 0}}}),
              9.0, 1e-12);
}

}  // namespace
}  // namespace marco
