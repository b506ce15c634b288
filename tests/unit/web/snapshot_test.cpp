#include "web/snapshot/snapshot.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "common/files/map_yaml.hpp"
#include "common/files/tum.hpp"
#include "web/snapshot/export_html.hpp"

namespace marco::web {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using testing::ThrowsMessage;
namespace fs = std::filesystem;

// A folder with a map of 3 x 2 cells, and what each test adds.
class SnapshotTest : public testing::Test {
 protected:
  SnapshotTest() {
    fs::create_directories(folder_);
    GridMap map;
    map.origin_m = {-1.0, 2.0};
    map.resolution_m = 0.1;
    map.width_cells = 3;
    map.height_cells = 2;
    map.occupancy = {0, 100, 0, 0, GridMap::kUnknown, 100};
    files::write_map(folder_, map);
  }
  ~SnapshotTest() override { fs::remove_all(folder_); }
  void put(const char* name, const std::string& text) { std::ofstream(folder_ / name) << text; }
  void put_path() {
    Trajectory path;
    for (int i = 0; i < 5; ++i)
      path.push_back({Utime::from_us(1'000'000 * (i + 1)), {0.5 * i, 0.0, 0.1}});
    path.insert(path.begin() + 1, {Utime::from_us(1'500'000), {0.01, 0.0, 0.1}});  // nobody sees it
    files::write_tum(folder_ / "trajectory.tum", path);
  }
  json snapshot() const { return json::parse(snapshot_json(folder_)); }

  const fs::path folder_ =
      fs::path(testing::TempDir()) /
      (std::string("snapshot_") + testing::UnitTest::GetInstance()->current_test_info()->name());
};

TEST_F(SnapshotTest, AMapAloneIsShown) {
  const json shown = snapshot();
  EXPECT_EQ(shown["name"], folder_.filename().string());
  EXPECT_EQ(shown["resolution_m"], 0.1);
  ASSERT_EQ(shown["tiles"].size(), 1U);
  EXPECT_NEAR(shown["tiles"][0]["x_m"].get<double>(), -25.6, 1e-9);  // 256 cells, cut at x = 0
  EXPECT_NEAR(shown["tiles"][0]["y_m"].get<double>(), 0.0, 1e-9);
  for (const char* field : {"model", "verdict"}) EXPECT_TRUE(shown[field].is_null());
  for (const char* field : {"path", "loops", "walls", "photographs"})
    EXPECT_TRUE(shown[field].empty());
}

TEST_F(SnapshotTest, PathIsThinnedAndCountsFromItsFirstPose) {
  put_path();
  const json path = snapshot()["path"];
  ASSERT_EQ(path.size(), 5U);
  EXPECT_THAT(path[0], ElementsAre(0.0, 0.0, 0.0, 0.1));
  EXPECT_THAT(path[4], ElementsAre(4.0, 2.0, 0.0, 0.1));
}

TEST_F(SnapshotTest, OdometryIsLaidOnThePath) {
  put_path();
  files::write_tum(folder_ / "odometry.tum", {{Utime::from_us(1'000'000), {7.0, 7.0, 0.1}},
                                              {Utime::from_us(2'000'000), {7.4, 7.0, 0.1}}});
  const json odometry = snapshot()["odometry"];
  ASSERT_EQ(odometry.size(), 2U);
  EXPECT_THAT(odometry[0], ElementsAre(0.0, 0.0, 0.0, 0.1));
  EXPECT_THAT(odometry[1], ElementsAre(1.0, 0.4, 0.0, 0.1));
}

TEST_F(SnapshotTest, LoopsJoinThePosesOfTheirStamps) {
  put_path();
  put("report.json", R"({"loops": [
    {"from_utime": 1000000, "to_utime": 3000000, "in_force": true},
    {"from_utime": 2000000, "to_utime": 5000000, "in_force": false},
    {"from_utime": 1, "to_utime": 5000000, "in_force": true}]})");
  EXPECT_THAT(snapshot()["loops"], ElementsAre(json({0.0, 0.0, 1.0, 0.0, "taken"}),
                                               json({0.5, 0.0, 2.0, 0.0, "refused"})));
}

TEST_F(SnapshotTest, VerdictSaysWhereAndWhatMends) {
  put("report.json",
      R"({"verdict": "doubtful", "doctor": {"open_questions": ["mirrored?"], "reasons": [
    {"why": "it is bent", "verdict": "doubtful", "x_m": 1.5, "y_m": -2.0, "picture": "doctor_1.png",
     "edits": ["forbid_loop 1 2", "drop_scans 1 2"]}]}})");
  const json verdict = snapshot()["verdict"];
  EXPECT_EQ(verdict["word"], "doubtful");
  ASSERT_EQ(verdict["reasons"].size(), 2U);
  EXPECT_EQ(verdict["reasons"][0]["text"], "it is bent");
  EXPECT_EQ(verdict["reasons"][0]["remedy"], "forbid_loop 1 2\ndrop_scans 1 2");
  EXPECT_EQ(verdict["reasons"][0]["x_m"], 1.5);
  EXPECT_EQ(verdict["reasons"][1]["text"], "mirrored?");
  EXPECT_FALSE(verdict["reasons"][1].contains("x_m"));
}

TEST_F(SnapshotTest, PhotographsStandWhereTheCameraStood) {
  fs::create_directories(folder_ / "photographs");
  put("photographs/a.jpg", "");
  put("photographs.toml", R"(
    [[photographs]]
    file = "photographs/a.jpg"
    focal_px = [600]
    position_m = [2.0, 3.0, 0.6]
    quaternion_xyzw = [-0.5, 0.5, -0.5, 0.5]
    [[photographs]]
    file = "../elsewhere.jpg"
    focal_px = [600]
    [[photographs]]
    file = "photographs/gone.jpg"
    focal_px = [600])");
  const json shown = snapshot()["photographs"];
  ASSERT_EQ(shown.size(), 1U);
  EXPECT_EQ(shown[0]["file"], "photographs/a.jpg");
  EXPECT_EQ(shown[0]["x_m"], 2.0);
  EXPECT_EQ(shown[0]["z_m"], 0.6);
  EXPECT_NEAR(shown[0]["theta_rad"].get<double>(), 0.0, 1e-9);  // it looks along x
}

TEST_F(SnapshotTest, NoFileOfAStrangersFolderLeadsOutOfIt) {
  const fs::path secret = folder_.string() + ".secret";
  std::ofstream(secret) << "1.0 0 0 0 0 0 0 1\n";
  for (const char* name :
       {"model.glb", "trajectory.tum", "trajectory_live.tum", "odometry.tum", "truth.tum",
        "report.json", "lines.json", "photographs.toml", "map.pgm", "map.yaml"}) {
    const fs::path before = folder_.string() + ".before";
    const bool was_there = fs::exists(folder_ / name);
    if (was_there) fs::rename(folder_ / name, before);
    fs::create_symlink(secret, folder_ / name);
    EXPECT_THAT([&] { export_html(folder_, "no_three.js"); },
                ThrowsMessage<std::invalid_argument>(HasSubstr("points outside its folder")))
        << name;
    fs::remove(folder_ / name);
    ASSERT_EQ(mkfifo((folder_ / name).c_str(), 0600), 0);
    EXPECT_THAT([&] { export_html(folder_, "no_three.js"); },
                ThrowsMessage<std::invalid_argument>(HasSubstr("is not a file")))
        << name;
    fs::remove(folder_ / name);
    if (was_there) fs::rename(before, folder_ / name);
  }
  put("kept.glb", "glTF");
  fs::create_symlink("kept.glb", folder_ / "model.glb");  // within it
  EXPECT_THAT(export_html(folder_, "no_three.js"), HasSubstr("Z2xURg=="));
  fs::remove(secret);
}

TEST_F(SnapshotTest, SaysWhatIsMissing) {
  fs::remove(folder_ / "map.yaml");
  EXPECT_THAT([&] { snapshot_json(folder_); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("contains no map.yaml")));
  EXPECT_THAT([&] { snapshot_json(folder_ / "gone"); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("no such folder")));
}

TEST_F(SnapshotTest, SaysWhichFileIsBroken) {
  put("report.json", "{");
  EXPECT_THAT([&] { snapshot_json(folder_); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("report.json")));
}

TEST_F(SnapshotTest, OneFileHoldsAllAndNoTextBecomesMarkup) {
  put("report.json",
      R"({"verdict": "wrong", "doctor": {"reasons": [{"why": "</script><b>bent"}]}})");
  put("model.glb", "glTF");
  const std::string page = export_html(folder_, folder_ / "no_three.js");
  EXPECT_THAT(page, Not(HasSubstr("page/page.css")));
  EXPECT_THAT(page, Not(HasSubstr("src=\"page/")));
  EXPECT_THAT(page, HasSubstr("\\u003c/script>\\u003cb>bent"));
  EXPECT_THAT(page, HasSubstr("data:model/gltf-binary;base64,Z2xURg=="));
  // Every script that is opened is closed once: nothing within ends one.
  const auto count = [&page](std::string_view word) {
    int found = 0;
    for (std::size_t at = page.find(word); at != std::string::npos; at = page.find(word, at + 1))
      ++found;
    return found;
  };
  EXPECT_EQ(count("<script"), count("</script>"));
}

}  // namespace
}  // namespace marco::web
