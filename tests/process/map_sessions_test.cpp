// marco-map on several recordings: of one building, of two; and on one in another unit.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "common/files/tum.hpp"
#include "tests/support/command_test.hpp"
#include "tests/support/flat_world.hpp"

namespace marco {
namespace {

using ::testing::HasSubstr;

class MapSessions : public testing::CommandTest {
 protected:
  nlohmann::json report(const std::string& out) const {
    return nlohmann::json::parse(files::read_whole_file(out + "/report.json"));
  }
};

// A CARMEN log of a drive round: 160 steps of 0.1 m are a square of 4.2 m with round corners.
std::string carmen_drive(
    const testing::FlatWorld& world, Pose2 pose, int steps, uint32_t seed, double metre = 1.0) {
  std::mt19937 random(seed);
  std::ostringstream log;
  const Pose2 start = pose;
  for (int i = 0; i < steps; ++i) {
    const LaserScan scan = world.scan(pose, 0.01, &random);
    log << "FLASER " << scan.size();
    for (const float range_m : scan.ranges_m) log << ' ' << metre * static_cast<double>(range_m);
    const Pose2 odom = between(start, pose);
    for (int twice = 0; twice < 2; ++twice) {
      log << ' ' << odom.x_m << ' ' << odom.y_m << ' ' << odom.theta_rad;
    }
    log << ' ' << 1000.0 * seed + 0.2 * i << " host " << 0.2 * i << '\n';
    pose = pose * Pose2{0.1, 0, deg_to_rad(i % 40 >= 32 ? 11.25 : 0.0)};
  }
  return log.str();
}

testing::FlatWorld another_building() {
  testing::FlatWorld world;
  world.add_chain({{-7, -5}, {7, -5}, {7, 2}, {9, 2}, {9, 3}, {7, 3}, {7, 5}, {-7, 5}, {-7, -5}});
  world.add_box(-1.0, -1.0, 0.6, 0.4);
  world.add_box(4.5, -3.0, 5.2, 2.0);
  world.add_box(-6.0, 2.0, -4.5, 3.5);
  return world;
}

TEST_F(MapSessions, TwoBuildingsAreKeptApartAndThatIsSaid) {
  const auto a = folder_.write("a.log", carmen_drive(testing::small_room(), {-1, -2, 0}, 90, 1));
  const auto b = folder_.write("b.log", carmen_drive(another_building(), {-2, -2.5, 0}, 130, 2));
  ASSERT_EQ(run("marco-map", {a.string(), "--out", at("a")}).code, 0);
  ASSERT_EQ(run("marco-map", {b.string(), "--out", at("b")}).code, 0);
  const Result both = run("marco-map", {a.string(), b.string(), "--out", at("both")});
  EXPECT_EQ(both.code, 1) << both.output;
  EXPECT_THAT(both.output, HasSubstr("session 2 (" + b.string() + "): not found"));
  const auto same = [&](const std::string& one, const std::string& other) {
    return files::read_whole_file(at(one)) == files::read_whole_file(at(other));
  };
  EXPECT_TRUE(same("a/map.pgm", "both/map.pgm"));
  EXPECT_TRUE(same("a/trajectory.tum", "both/trajectory.tum"));
  EXPECT_TRUE(same("b/map.pgm", "both/session_2/map.pgm"));
  EXPECT_TRUE(same("b/trajectory.tum", "both/session_2/trajectory.tum"));
  EXPECT_EQ(report(at("both")).at("kept_apart").at(0).at("folder"), "session_2");

  const std::string before = files::read_whole_file(at("a/map.marco"));
  const Result extended = run("marco-map", {b.string(), "--extend", at("a"), "--out", at("new")});
  EXPECT_EQ(extended.code, 1) << extended.output;
  EXPECT_THAT(extended.output, HasSubstr("not found in this map, which is unchanged"));
  EXPECT_EQ(files::read_whole_file(at("a/map.marco")), before);
  EXPECT_FALSE(std::filesystem::exists(at("new/map.pgm")));

  const Result lines = run("marco-map", {a.string(), b.string(), "--lines", "--out", at("lines")});
  EXPECT_EQ(lines.code, 1) << lines.output;
  EXPECT_THAT(lines.output, HasSubstr("was not found in the map of the previous recordings"));
  EXPECT_FALSE(std::filesystem::exists(at("lines/map.pgm")));
}

TEST_F(MapSessions, SessionsOfOneBuildingAreOneMap) {
  const testing::FlatWorld room = testing::small_room();
  const auto a = folder_.write("a.log", carmen_drive(room, {-1, -2, 0}, 90, 1));
  const auto b = folder_.write("b.log", carmen_drive(room, {-0.5, 2.2, 3.0}, 60, 2));
  const Result both = run("marco-map", {a.string(), b.string(), "--out", at("both")});
  EXPECT_EQ(both.code, 0) << both.output;
  EXPECT_EQ(files::read_tum(at("both/trajectory.tum")).size(), 150U);
  EXPECT_EQ(files::read_tum(at("both/trajectory_session_2.tum")).size(), 60U);
  const Pose2 found = files::read_tum(at("both/trajectory.tum"))[90].world_from_robot;
  const Pose2 truth = between({-1, -2, 0}, {-0.5, 2.2, 3.0});
  EXPECT_LT((found.translation_m() - truth.translation_m()).norm(), 0.05);
}

TEST_F(MapSessions, RangesInMillimetresOrCentimetresAreSaidAtOnce) {
  for (const auto& [metre, name] : {std::pair{1000.0, "millimetres"}, {100.0, "centimetres"}}) {
    const auto log =
        folder_.write("units.log", carmen_drive(testing::small_room(), {-1, -2, 0}, 40, 1, metre));
    const Result result = run("marco-map", {log.string(), "--out", at("out")});
    EXPECT_EQ(result.code, 1) << result.output;
    EXPECT_THAT(result.output, HasSubstr(std::string("are these ") + name + "?"));
  }
}

}  // namespace
}  // namespace marco
