// What is printed and reported of a map: its verdict, its summary, and what the drive says of the
// set-up.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "lcm_tools/files/whole_file.hpp"
#include "live/calibration_file.hpp"
#include "short_drive.hpp"
#include "tools/map/calibration.hpp"
#include "tools/map/joined_surface.hpp"
#include "tools/map/report.hpp"
#include "tools/map/verdict.hpp"

namespace marco {
namespace {

using ::marco::testing::kScans;
using ::marco::testing::ShortDrive;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;

class VerdictOfADrive : public ShortDrive {
 protected:
  // Keyframes 0 and 1 against 2; a pass that was never seen again; and the whole map.
  MapVerdict wrong() const {
    MapVerdict verdict{*job_->evidence(), {}};
    verdict.diagnosis.verdict = slam::Verdict::wrong;
    slam::Reason reason;
    reason.verdict = slam::Verdict::wrong;
    reason.from = Utime::from_seconds(1002.0);
    reason.to = Utime::from_seconds(1004.5);
    reason.place_m = {3.0, -2.0};
    reason.why = "a wall stands where it was free";
    reason.older_keys = {0, 1};
    reason.newer_keys = {2};
    reason.remedies = {{slam::MapEdit::Kind::forbid_loop, reason.from, reason.to, {}},
                       {slam::MapEdit::Kind::drop_scans, reason.from, reason.to, {}}};
    slam::Reason of_all;
    of_all.cause = slam::Reason::Cause::unmatched_scans;
    of_all.why = "too few scans lie on the map";
    verdict.diagnosis.reasons = {of_all, reason};
    return verdict;
  }
  std::string printed(const MapVerdict& verdict, bool with_pictures) const {
    ::testing::internal::CaptureStdout();
    print_verdict(verdict, *job_, with_pictures);
    std::fflush(stdout);
    return ::testing::internal::GetCapturedStdout();
  }
};

TEST_F(VerdictOfADrive, OfARightMapIsOneWord) {
  const auto verdict = judge_map(*job_);
  ASSERT_TRUE(verdict);
  EXPECT_EQ(printed(*verdict, true), "verdict: good\n");
  EXPECT_TRUE(doctor_pictures("", *verdict).empty());
  PictureOrder order;
  mark_picture(order, *verdict);
  EXPECT_TRUE(order.scene.paths.empty());
}

TEST_F(VerdictOfADrive, SaysWhereWhenAndWhyAndTheFixOnce) {
  MapVerdict verdict = wrong();
  verdict.diagnosis.reasons.push_back(verdict.diagnosis.reasons[1]);
  verdict.diagnosis.open_questions = {"is it a mirror image?"};
  const std::string text = printed(verdict, true);
  EXPECT_THAT(text, HasSubstr("wrong at (3.0, -2.0) m, 2.0 to 4.5 s: a wall stands where it was"));
  EXPECT_THAT(text, HasSubstr(": too few scans lie on the map\n"));
  EXPECT_THAT(text, HasSubstr("  picture: doctor_2.png\n"));
  EXPECT_THAT(text, HasSubstr("  picture: doctor_3.png\n"));
  EXPECT_THAT(text, Not(HasSubstr("doctor_1.png"))) << "of the whole map there is none";
  EXPECT_THAT(text, HasSubstr("  forbid_loop 1002.000000 1004.500000   (suggested fix"));
  EXPECT_THAT(text, HasSubstr("\n  or: drop_scans 1002.000000 1004.500000\n"));
  EXPECT_EQ(text.find("suggested fix"), text.rfind("suggested fix"));
  EXPECT_THAT(text, HasSubstr("doubtful: is it a mirror image?\n"));
  EXPECT_THAT(text, EndsWith("\nverdict: wrong\n"));
  EXPECT_THAT(printed(verdict, false), Not(HasSubstr("picture")));
}

TEST_F(VerdictOfADrive, IsInTheReportWithEachReasonAndItsPicture) {
  nlohmann::json report;
  add_verdict(report, wrong(), *job_);
  EXPECT_EQ(report.at("verdict"), "wrong");
  const auto& reasons = report.at("doctor").at("reasons");
  ASSERT_EQ(reasons.size(), 2U);
  EXPECT_FALSE(reasons[0].contains("picture"));
  EXPECT_EQ(reasons[1].at("picture"), "doctor_2.png");
  EXPECT_EQ(reasons[1].at("y_m"), -2.0);
  EXPECT_EQ(reasons[1].at("from_s"), 2.0);
  EXPECT_EQ(reasons[1].at("to_s"), 4.5);
  EXPECT_EQ(reasons[1].at("to_utime"), 1004'500'000);
  EXPECT_EQ(reasons[1].at("edits").size(), 2U);
  EXPECT_TRUE(report["doctor"]["mended"].empty());
}

// Grey-green what was seen before, blue what was seen here, red what contradicts.
TEST_F(VerdictOfADrive, IsDrawnAtItsPlaceAndByTheScansThatShowIt) {
  const std::vector<PictureOrder> orders = doctor_pictures("out", wrong());
  ASSERT_EQ(orders.size(), 1U);
  EXPECT_EQ(orders[0].path, "out/doctor_2.png");
  const auto& points = orders[0].scene.points;
  ASSERT_GE(points.size(), 2U);
  const auto count = [](int at) {
    return static_cast<std::size_t>(key(at).points_in_robot.points.cols());
  };
  EXPECT_EQ(points[0].points_m.size(), count(0) + count(1));
  EXPECT_EQ(points[1].points_m.size(), count(2));
  const Eigen::Vector2d last =
      key(1).world_from_robot * Eigen::Vector2d(key(1).points_in_robot.points.rightCols<1>());
  EXPECT_LT((points[0].points_m.back().head<2>().cast<double>() - last).norm(), 1e-5);
  ASSERT_EQ(orders[0].scene.robots.size(), 1U);
  EXPECT_EQ(orders[0].scene.robots[0].world_from_robot, key(2).world_from_robot);
  PictureOrder order;
  mark_picture(order, wrong());
  ASSERT_EQ(order.scene.ellipses.size(), 1U) << "the other is about the whole map";
  EXPECT_EQ(order.scene.ellipses[0].center_m, Eigen::Vector2d(3.0, -2.0));
  EXPECT_EQ(order.scene.paths.at(0).label, "verdict: wrong");
}

TEST_F(VerdictOfADrive, MarksTheFileThatNavigationReadsOfWrongMapsOnly) {
  const auto yaml = folder_->write("map.yaml", "image: map.pgm\n");
  MapVerdict doubtful = wrong();
  doubtful.diagnosis.verdict = slam::Verdict::doubtful;
  mark_map(folder_->path(), doubtful);
  EXPECT_EQ(files::read_whole_file(yaml), "image: map.pgm\n");
  mark_map(folder_->path(), wrong());
  EXPECT_THAT(files::read_whole_file(yaml), HasSubstr("# verdict: wrong"));
  EXPECT_THAT(files::read_whole_file(yaml), EndsWith("\nimage: map.pgm\n"));
  mark_map(folder_->path() / "elsewhere", wrong());
  EXPECT_FALSE(std::filesystem::exists(folder_->path() / "elsewhere"));
}

TEST_F(ShortDrive, ItsSummaryCountsScansWayLoopsAndPictures) {
  ReportExtras extras;
  extras.photographs.recorded = 7;
  extras.photographs.chosen = 3;
  extras.photographs.dropped = {{"taken during a fast turn", 2}};
  extras.surface = {{"planes", 12.0}, {"farthest_m", 0.0125}};
  extras.errors = {{"path error rms_m", 0.01234}};
  ::testing::internal::CaptureStdout();
  print_summary(*job_, extras, "there");
  std::fflush(stdout);
  const std::string text = ::testing::internal::GetCapturedStdout();
  EXPECT_THAT(text, HasSubstr("520 scans with a pose, 519 of 520 level ones matched, "));
  EXPECT_THAT(text, HasSubstr(" m driven in 52 s; "));
  std::size_t closed = 0;
  const auto evidence = job_->evidence();
  for (const slam::Loop& loop : evidence->loops) closed += loop.is_inlier ? 1 : 0;
  EXPECT_THAT(text, HasSubstr("; " + std::to_string(closed) + " loops closed\n"));
  EXPECT_THAT(text, HasSubstr("7 pictures recorded, 3 chosen\n"));
  EXPECT_THAT(text, HasSubstr("pictures dropped: taken during a fast turn 2\n"));
  EXPECT_THAT(text, HasSubstr("planes: 12\n"));
  EXPECT_THAT(text, HasSubstr("farthest_m: 0.0125\n"));
  EXPECT_THAT(text, HasSubstr("path error rms_m: 0.0123\n"));
  EXPECT_THAT(text, HasSubstr("the results are in there; view them with `marco page there`"));
}

// Its odometry is 2 % long. The file is for the next run, with what is known of each number.
TEST_F(ShortDrive, ItsCalibrationIsFoundTabledAndWritten) {
  const auto found = self_calibration_of(*job_);
  ASSERT_TRUE(found);
  ASSERT_TRUE(mount_of_laser(*job_));
  EXPECT_EQ(mount_of_laser(*job_)->channel, "LIDAR");
  const slam::CalibratedParameter* left = found->find("odometry.left_scale");
  ASSERT_TRUE(left);
  EXPECT_NEAR(left->found, 1.0 / 1.02, 0.005);
  const auto path = folder_->path() / "calibration.toml";
  ::testing::internal::CaptureStdout();
  EXPECT_TRUE(write_calibration(path, *job_));
  std::fflush(stdout);
  EXPECT_THAT(::testing::internal::GetCapturedStdout(), HasSubstr("odometry.left_scale"));
  const CalibrationFile file = load_calibration(path.string());
  EXPECT_NEAR(file.odometry.left_scale, 1.0 / 1.02, 0.005);
  const std::string text = files::read_whole_file(path);
  const std::string line = text.substr(text.find("left_scale"), 60);
  EXPECT_THAT(line, HasSubstr("  # sd 0.0")) << text;
}

TEST(JoinedSurface, HasFiguresUnlessItIsEmpty) {
  mapping3d::JoinedSurface joined;
  joined.simplified.there_m = 0.02F;
  joined.simplified.back_m = 0.01F;
  joined.planes.resize(3);
  EXPECT_TRUE(figures_of({}, joined, 2).empty());
  TriangleMesh model;
  model.triangles.resize(10);
  const auto figures = figures_of(model, joined, 2);
  EXPECT_EQ(figures.at("scenes"), 2.0);
  EXPECT_EQ(figures.at("triangles"), 10.0);
  EXPECT_EQ(figures.at("planes"), 3.0);
  EXPECT_NEAR(figures.at("simplified, farthest sample_m"), 0.02, 1e-6);
}

}  // namespace
}  // namespace marco
