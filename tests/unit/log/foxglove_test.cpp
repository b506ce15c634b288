#include "tools/log/foxglove.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>
#include <random>
#include <set>

#include "lcm_tools/log/export_mcap.hpp"
#include "lcm_tools/tests/unit/log/mcap_reader.hpp"
#include "lcm_tools/tests/unit/log/tiny_log.hpp"
#include "lcmtypes/convert.hpp"
#include "marco/slam_pose_t.hpp"

namespace marco::logs {
namespace {

using ::testing::ElementsAre;
using Json = nlohmann::json;

const Types& types() {
  static const Types kAll({});
  return kAll;
}

std::unique_ptr<McapTranslator> make_translator(const LogInfo& log) {
  return std::make_unique<FoxgloveTranslator>(log);
}

WalkInput walk_of(const std::string& path) {
  WalkInput input;
  input.path = path;
  return input;
}

template <class Message>
void write_message(files::EventLogWriter& writer, const char* channel, const Message& message) {
  writer.write(channel, encode_message(message), Utime::from_us(message.utime));
}

bot_core::planar_lidar_t small_scan() {
  LaserScan scan;
  scan.utime = Utime::from_us(kStartUs);
  scan.ranges_m = {1.5F, 0.0F, std::numeric_limits<float>::infinity()};
  scan.first_bearing_rad = -0.5;
  scan.bearing_step_rad = 0.5;
  return to_message(scan);
}

std::string from_base64(const std::string& text) {
  static const std::string kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  uint32_t bits = 0;
  int count = 0;
  for (const char c : text) {
    if (c == '=') break;
    bits = bits << 6U | static_cast<uint32_t>(kDigits.find(c));
    count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes += static_cast<char>(bits >> static_cast<unsigned>(count));
  }
  return bytes;
}

std::map<std::string, Json> foxglove_of(const ScratchFolder& folder) {
  OutputFile out(folder / "out.mcap", Existing::refuse, {});
  WalkInput input = walk_of(folder / "log");
  export_mcap(input, types(), out, make_translator, ignore_progress);
  out.finish();
  const test::McapFile file = test::read_mcap(read_text(folder / "out.mcap"));
  std::map<std::string, Json> messages;
  for (const test::McapMessage& message : file.messages) {
    messages[file.topics.at(message.channel)] = Json::parse(message.data);
  }
  for (const auto& [name, schema] : file.schemas) {
    if (!name.starts_with("foxglove.")) continue;
    EXPECT_EQ(Json::parse(schema).at("title"), name);
  }
  return messages;
}

TEST(Mcap, SaysInFoxglovesWordsWhatItCanDraw) {
  const ScratchFolder folder;
  {
    files::EventLogWriter writer(folder / "log");
    SensorInfo info;
    info.parent_from_sensor = lift({0.25, 0.0, 0.0});
    write_message(writer, "SENSOR_INFO", to_message(info));
    write_message(writer, "LIDAR", small_scan());
    slam_pose_t pose{};
    pose.utime = kStartUs;
    pose.x_m = 3.0;
    pose.theta_rad = deg_to_rad(180);
    write_message(writer, "SLAM_POSE", pose);
    // RPLidar of a foreign robot: clockwise.
    LaserScan foreign;
    foreign.utime = Utime::from_us(kStartUs);
    foreign.bearings_rad = {0.5F, 1.0F};
    foreign.ranges_m = {1.0F, 2.0F};
    write_message(writer, "RPLIDAR_LASER", to_raw_message(foreign));
  }
  auto messages = foxglove_of(folder);
  const Json& scan = messages.at("LIDAR/LaserScan");
  EXPECT_EQ(scan.at("frame_id"), "LIDAR");
  EXPECT_EQ(scan.at("pose").at("position").at("x"), 0);
  EXPECT_EQ(messages.at("LIDAR/FrameTransform").at("parent_frame_id"), "robot");
  EXPECT_EQ(messages.at("LIDAR/FrameTransform").at("child_frame_id"), "LIDAR");
  EXPECT_EQ(messages.at("LIDAR/FrameTransform").at("translation").at("x"), 0.25);
  EXPECT_EQ(scan.at("start_angle"), -0.5);
  EXPECT_EQ(scan.at("end_angle"), 0.5);
  EXPECT_EQ(scan.at("ranges"), Json({1.5, 0, 0}));  // what did not return is 0
  EXPECT_EQ(scan.at("timestamp").at("sec"), kStartUs / 1000000);
  EXPECT_EQ(messages.at("SLAM_POSE/PoseInFrame").at("pose").at("position").at("x"), 3.0);
  EXPECT_NEAR(messages.at("SLAM_POSE/FrameTransform").at("rotation").at("z"), 1.0, 1e-12);
  // Without odometry SLAM says where the robot is itself.
  EXPECT_EQ(messages.at("SLAM_POSE/FrameTransform").at("child_frame_id"), "robot");
  const Json& turned = messages.at("RPLIDAR_LASER/LaserScan");
  EXPECT_EQ(turned.at("frame_id"), "robot");
  const double start = turned.at("start_angle");
  const double step = (turned.at("end_angle").get<double>() - start) /
                      static_cast<double>(turned.at("ranges").size() - 1);
  const auto& ranges = turned.at("ranges");
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    if (ranges[i] != 1.0) continue;
    EXPECT_NEAR(start + step * static_cast<double>(i), -0.5, deg_to_rad(1.0));
  }
  EXPECT_EQ(messages.count("SENSOR_INFO/LaserScan"), 0U);
}

// The grids of an export's topic, as pictures: a letter a cell.
std::vector<std::string> pictures_of(const test::McapFile& file, const std::string& topic) {
  std::vector<std::string> pictures;
  for (const test::McapMessage& message : file.messages) {
    if (file.topics.at(message.channel) != topic) continue;
    const Json grid = Json::parse(message.data);
    EXPECT_EQ(grid.at("fields").size(), 4U);
    const auto columns = grid.at("column_count").get<std::size_t>();
    EXPECT_EQ(grid.at("row_stride"), 4 * columns);
    const std::string data = from_base64(grid.at("data"));
    std::string& picture = pictures.emplace_back();
    for (std::size_t i = 0; i + 3 < data.size(); i += 4) {
      const auto grey = static_cast<uint8_t>(data[i]), alpha = static_cast<uint8_t>(data[i + 3]);
      EXPECT_EQ(data[i], data[i + 2]);
      picture += alpha == 0 ? '?' : grey == 255 ? '.' : grey == 0 ? '#' : 'o';
      if (i / 4 % columns + 1 == columns) picture += '\n';
    }
  }
  return pictures;
}

grid_map_t tile_of(int64_t revision, double x_m, double y_m, std::vector<uint8_t> cells) {
  GridMap map;
  map.origin_m = {x_m, y_m};
  map.resolution_m = 0.5;
  map.width_cells = 2;
  map.height_cells = 2;
  map.occupancy = std::move(cells);
  return to_messages(map, Utime::from_us(kStartUs + revision), revision).front();
}

test::McapFile mcap_of(const ScratchFolder& folder) {
  OutputFile out(folder / "out.mcap", Existing::replace, {});
  WalkInput input = walk_of(folder / "log");
  export_mcap(input, types(), out, make_translator, ignore_progress);
  out.finish();
  return test::read_mcap(read_text(folder / "out.mcap"));
}

TEST(Mcap, WallsAndLoopClosuresAreLinesOfAScene) {
  const ScratchFolder folder;
  {
    files::EventLogWriter writer(folder / "log");
    Wall wall;
    wall.start_m = {1.0, 2.0};
    wall.end_m = {3.0, 4.0};
    write_message(writer, "LINE_MAP", to_message(Walls{wall, wall}, Utime::from_us(kStartUs), 1));
    LoopClosure loop;
    loop.from_m = {5.0, 6.0};
    loop.to_m = {7.0, 8.0};
    write_message(writer, "LOOP_CLOSURES",
                  to_message(LoopClosures{loop}, Utime::from_us(kStartUs), 1));
    write_message(writer, "LOOP_CLOSURES", to_message(LoopClosures{}, Utime::from_us(kStartUs), 2));
  }
  const test::McapFile file = mcap_of(folder);
  std::map<std::string, std::vector<Json>> entities;
  for (const test::McapMessage& message : file.messages) {
    const std::string& topic = file.topics.at(message.channel);
    if (!topic.ends_with("/SceneUpdate")) continue;
    entities[topic].push_back(Json::parse(message.data).at("entities").at(0));
    EXPECT_EQ(entities[topic].back().at("frame_id"), "world");
  }
  const auto& walls = entities["LINE_MAP/SceneUpdate"];
  ASSERT_EQ(walls.size(), 1U);
  EXPECT_EQ(walls[0].at("lines").at(0).at("points").size(), 4U);
  const auto& loops = entities["LOOP_CLOSURES/SceneUpdate"];
  ASSERT_EQ(loops.size(), 2U);
  const Json& line = loops[0].at("lines").at(0);
  EXPECT_EQ(line.at("type"), 2);  // a list of pairs
  const Json from = {{"x", 5.0}, {"y", 6.0}, {"z", 0.0}}, to = {{"x", 7.0}, {"y", 8.0}, {"z", 0.0}};
  EXPECT_EQ(line.at("points"), Json({from, to}));
  // The newer entity takes the older one's place.
  EXPECT_EQ(loops[0].at("id"), loops[1].at("id"));
  EXPECT_NE(loops[0].at("id"), walls[0].at("id"));
  EXPECT_TRUE(loops[1].at("lines").at(0).at("points").empty());
}

TEST(Mcap, TheTilesOfAMapAreOneGrid) {
  const ScratchFolder folder;
  {
    files::EventLogWriter writer(folder / "log");
    const auto write_map = [&](int64_t revision, uint8_t last) {
      // Two tiles side by side and one above the right one; the fourth place is unknown.
      write_message(writer, "GRID_MAP", tile_of(revision, -1, 2, {0, 100, 0, 50}));
      write_message(writer, "LIDAR", small_scan());
      write_message(writer, "GRID_MAP", tile_of(revision, 0, 2, {0, 0, 255, 100}));
      write_message(writer, "GRID_MAP", tile_of(revision, 0, 3, {100, 100, 100, last}));
    };
    write_map(1, 0);
    write_map(1, 0);  // SLAM repeats a map for who came late
    write_map(2, 100);
    // Far away from all others: no map, but its own message.
    write_message(writer, "GRID_MAP", tile_of(3, 0, 0, {0, 0, 0, 0}));
    write_message(writer, "GRID_MAP", tile_of(3, 1e6, 0, {0, 0, 0, 0}));
  }
  const test::McapFile file = mcap_of(folder);
  std::set<std::string> grid_topics;
  int64_t tiles = 0;
  for (const auto& [id, topic] : file.topics) {
    if (topic.starts_with("GRID_MAP")) grid_topics.insert(topic);
  }
  for (const test::McapMessage& message : file.messages) {
    tiles += file.topics.at(message.channel) == "GRID_MAP" ? 1 : 0;
  }
  EXPECT_THAT(grid_topics, ElementsAre("GRID_MAP", "GRID_MAP/Grid"));
  EXPECT_EQ(tiles, 11);
  EXPECT_THAT(pictures_of(file, "GRID_MAP/Grid"), ElementsAre(".#..\n"
                                                              ".o?#\n"
                                                              "??##\n"
                                                              "??#.\n",
                                                              ".#..\n"
                                                              ".o?#\n"
                                                              "??##\n"
                                                              "??##\n"));
  const auto grid = std::find_if(file.messages.begin(), file.messages.end(), [&](const auto& one) {
    return file.topics.at(one.channel) == "GRID_MAP/Grid";
  });
  EXPECT_EQ(Json::parse(grid->data).at("frame_id"), "world");
  EXPECT_EQ(Json::parse(grid->data).at("pose").at("position").at("x"), -1.0);
  EXPECT_EQ(Json::parse(grid->data).at("pose").at("position").at("y"), 2.0);
  EXPECT_EQ(Json::parse(grid->data).at("cell_size").at("x"), 0.5);
}

Pose2 pose_of(const Json& transform) {
  const Json& at = transform.at("translation");
  const Json& q = transform.at("rotation");
  return {at.at("x"), at.at("y"), 2 * std::atan2(q.at("z").get<double>(), q.at("w").get<double>())};
}

// world -> odom -> robot -> laser: where the tree says the robot is, SLAM said it was.
TEST(Mcap, TheFramesFormOneTree) {
  const ScratchFolder folder;
  const Pose2 world_from_robot{3.0, -1.0, 0.5};
  {
    files::EventLogWriter writer(folder / "log");
    for (int i = 0; i < 10; ++i) {
      OdometrySample odometry;
      odometry.utime = Utime::from_us(kStartUs + 100000 * i);
      odometry.odom_from_robot = {1.0 + i, 2.0, 0.25};
      write_message(writer, "ODOMETRY", to_message(odometry));
    }
    SensorInfo pantilt;
    pantilt.utime = Utime::from_us(kStartUs);
    pantilt.channel = "PANTILT_STATE";
    pantilt.parent_from_sensor = lift({0.5, 0.0, 0.0});
    write_message(writer, "SENSOR_INFO", to_message(pantilt));
    PanTiltState state;
    state.utime = pantilt.utime;
    state.pan_rad = 0.5;
    write_message(writer, "PANTILT_STATE", to_message(state));
    slam_pose_t pose{};
    pose.utime = kStartUs + 450000;  // between two
    pose.x_m = world_from_robot.x_m;
    pose.y_m = world_from_robot.y_m;
    pose.theta_rad = world_from_robot.theta_rad;
    write_message(writer, "SLAM_POSE", pose);
    write_message(writer, "SECOND_SLAM", pose);  // a frame has one parent
    Trajectory path = {{Utime::from_us(kStartUs), {1, 2, 0}},
                       {Utime::from_us(kStartUs), {3, 4, 0}}};
    write_message(writer, "TRAJECTORY", to_message(path, Utime::from_us(kStartUs), 1));
  }
  auto messages = foxglove_of(folder);
  const Json& odom = messages.at("SLAM_POSE/FrameTransform");
  EXPECT_EQ(odom.at("parent_frame_id"), "world");
  EXPECT_EQ(odom.at("child_frame_id"), "odom");
  const Pose2 robot = pose_of(odom) * Pose2{5.5, 2.0, 0.25};
  EXPECT_NEAR(robot.x_m, world_from_robot.x_m, 1e-9);
  EXPECT_NEAR(robot.y_m, world_from_robot.y_m, 1e-9);
  EXPECT_NEAR(robot.theta_rad, world_from_robot.theta_rad, 1e-9);
  const Json& base = messages.at("ODOMETRY/FrameTransform");
  EXPECT_EQ(base.at("parent_frame_id"), "odom");
  EXPECT_EQ(base.at("child_frame_id"), "robot");
  EXPECT_NEAR(pose_of(base).x_m, 10.0, 1e-9);
  const Json& plate = messages.at("PANTILT_STATE/FrameTransform");
  EXPECT_EQ(plate.at("child_frame_id"), "plate");
  EXPECT_NEAR(pose_of(plate).x_m, 0.5, 1e-9);
  EXPECT_NEAR(pose_of(plate).theta_rad, 0.5, 1e-9);
  EXPECT_EQ(messages.count("SECOND_SLAM/FrameTransform"), 0U);
  const Json& path = messages.at("TRAJECTORY/PosesInFrame");
  EXPECT_EQ(path.at("frame_id"), "world");
  ASSERT_EQ(path.at("poses").size(), 2U);
  EXPECT_EQ(path.at("poses")[1].at("position").at("y"), 4.0);
}

TEST(Mcap, AMapTooLargeToBeDrawnIsCounted) {
  const ScratchFolder folder;
  {
    files::EventLogWriter writer(folder / "log");
    write_message(writer, "GRID_MAP", tile_of(3, 0, 0, {0, 0, 0, 0}));
    write_message(writer, "GRID_MAP", tile_of(3, 1e6, 0, {0, 0, 0, 0}));
  }
  OutputFile out(folder / "out.mcap", Existing::refuse, {});
  WalkInput input = walk_of(folder / "log");
  const McapResult result = export_mcap(input, types(), out, make_translator, ignore_progress);
  EXPECT_EQ(result.messages, 2U);
  EXPECT_EQ(result.remark, "1 maps are too large to draw: only their tiles were written");
}

// Damaged messages: what is written is whole JSON, and as many messages as are said.
TEST(Mcap, ATranslationTakesAnyBytes) {
  const ScratchFolder folder;
  {
    files::EventLogWriter writer(folder / "good");
    for (int i = 0; i < 5; ++i) {
      write_message(writer, "LIDAR", small_scan());
      writer.write("TRUE_POSE", pose_bytes(i, 0.0), Utime::from_us(i));
      LaserScan raw;
      raw.bearings_rad = {0.1F, 0.2F};
      raw.ranges_m = {1.0F, 2.0F};
      write_message(writer, "LIDAR_RAW", to_raw_message(raw));
      write_message(writer, "GRID_MAP", tile_of(i, 0, 0, {0, 100, 0, 50}));
    }
  }
  const std::string good = read_text(folder / "good");
  std::mt19937 random(8);
  std::size_t drawn = 0;
  for (int round = 0; round < 40; ++round) {
    std::string bytes = good;
    for (int flips = 0; flips < 15; ++flips)
      bytes[random() % bytes.size()] = static_cast<char>(random());
    write_text(folder / "bad", bytes);
    WalkInput input = walk_of(folder / "bad");
    OutputFile out(folder / "mcap", Existing::replace, {});
    const McapResult result = export_mcap(input, types(), out, make_translator, ignore_progress);
    out.finish();
    const test::McapFile file = test::read_mcap(read_text(folder / "mcap"));
    EXPECT_EQ(file.messages.size(), result.messages);
    for (const test::McapMessage& message : file.messages) {
      EXPECT_TRUE(Json::accept(message.data)) << message.data;
      drawn += file.topics.at(message.channel).find('/') != std::string::npos ? 1 : 0;
    }
  }
  EXPECT_GT(drawn, 200U);
}

}  // namespace
}  // namespace marco::logs
