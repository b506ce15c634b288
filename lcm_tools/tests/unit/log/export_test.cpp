#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <random>
#include <set>
#include <sstream>

#include "bot_core/image_t.hpp"
#include "lcm_tools/log/export_csv.hpp"
#include "lcm_tools/log/export_images.hpp"
#include "lcm_tools/log/export_json_lines.hpp"
#include "lcm_tools/log/export_mcap.hpp"
#include "lcm_tools/log/mcap_writer.hpp"
#include "lcm_tools/log/png.hpp"
#include "marco/map_request_t.hpp"
#include "marco/slam_pose_t.hpp"
#include "tests/unit/log/mcap_reader.hpp"
#include "tests/unit/log/tiny_log.hpp"
#include "viewer/image_io.hpp"

namespace marco::logs {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using Json = nlohmann::json;

const Types& types() {
  static const Types all({});
  return all;
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

TEST(Base64, HasPaddingWhereItMust) {
  const auto text = [](const char* bytes) {
    return to_base64({reinterpret_cast<const uint8_t*>(bytes), std::strlen(bytes)});
  };
  EXPECT_EQ(text(""), "");
  EXPECT_EQ(text("f"), "Zg==");
  EXPECT_EQ(text("fo"), "Zm8=");
  EXPECT_EQ(text("foobar"), "Zm9vYmFy");
}

TEST(JsonLines, OneObjectAnEventAlsoForWhatDoesNotDecode) {
  const ScratchFolder folder;
  {
    files::EventLogWriter writer(folder / "log");
    writer.write("TRUE_POSE", pose_bytes(7, 1.25), Utime::from_us(8));
    const std::vector<uint8_t> unknown = {1, 2, 3, 4, 5, 6, 7, 8, 9};
    writer.write("WHO_KNOWS", unknown, Utime::from_us(9));
    std::vector<uint8_t> broken = pose_bytes(7, 1.25);
    broken.resize(20);
    writer.write("TRUE_POSE", broken, Utime::from_us(10));
  }
  OutputFile out(folder / "out", Existing::refuse, {});
  WalkInput input = walk_of(folder / "log");
  const WalkResult result = export_json_lines(input, types(), out, ignore_progress);
  out.finish();
  EXPECT_EQ(result.events, 3);
  EXPECT_EQ(result.undecodable, 2);
  std::istringstream lines(read_text(folder / "out"));
  std::string line;
  std::getline(lines, line);
  const Json pose = Json::parse(line);
  EXPECT_EQ(pose.at("event"), 0);
  EXPECT_EQ(pose.at("time_us"), 8);
  EXPECT_EQ(pose.at("channel"), "TRUE_POSE");
  EXPECT_EQ(pose.at("type"), "marco.pose2_t");
  EXPECT_EQ(pose.at("message").at("x_m"), 1.25);
  std::getline(lines, line);
  EXPECT_EQ(Json::parse(line).at("fingerprint"), "0102030405060708");
  EXPECT_EQ(Json::parse(line).at("data"), "AQIDBAUGBwgJ");
  std::getline(lines, line);
  EXPECT_FALSE(Json::parse(line).contains("message"));
}

TEST(Csv, ATableAChannelWithAColumnAValue) {
  const ScratchFolder folder;
  {
    files::EventLogWriter writer(folder / "log");
    writer.write("TRUE_POSE", pose_bytes(7, 1.25), Utime::from_us(8));
    write_message(writer, "LIDAR", small_scan());
    slam_pose_t pose{};
    pose.covariance[1][2] = 0.5;
    write_message(writer, "A/B", pose);
    write_message(writer, "TRUE_POSE", pose);
    map_request_t request;
    request.utime = 3;
    request.channel = "a, \"b\"";
    write_message(writer, "MAP_REQUEST", request);
  }
  WalkInput input = walk_of(folder / "log");
  const CsvResult result =
      export_csv(input, types(), folder / "csv", Existing::refuse, ignore_progress);
  EXPECT_THAT(result.files, ElementsAre("TRUE_POSE.csv", "LIDAR.csv", "A_B.csv",
                                        "TRUE_POSE.marco.slam_pose_t.csv", "MAP_REQUEST.csv"));
  EXPECT_EQ(read_text(folder / "csv/TRUE_POSE.csv"),
            "event,time_us,utime,x_m,y_m,theta_rad\n0,8,7,1.25,0,0\n");
  EXPECT_EQ(read_text(folder / "csv/LIDAR.csv"),
            "event,time_us,utime,nranges,ranges,nintensities,intensities,rad0,radstep\n"
            "1,1454600000000000,1454600000000000,3,1.5 0 inf,0,,-0.5,0.5\n");
  EXPECT_THAT(read_text(folder / "csv/A_B.csv"),
              ::testing::AllOf(HasSubstr("covariance[1][2],covariance[2][0]"),
                               HasSubstr("0,0,0,0,0,0.5,0,0,0")));
  EXPECT_EQ(read_text(folder / "csv/MAP_REQUEST.csv"),
            "event,time_us,utime,channel\n4,3,3,\"a, \"\"b\"\"\"\n");
  EXPECT_THROW(export_csv(input, types(), folder / "csv", Existing::refuse, ignore_progress),
               std::invalid_argument);
}

TEST(Mcap, ChecksumIsTheUsualOne) {
  EXPECT_EQ(crc32("123456789"), 0xCBF43926U);  // the check value every CRC-32 is known by
  EXPECT_EQ(crc32("6789", crc32("12345")), 0xCBF43926U);
  EXPECT_EQ(crc32(""), 0U);
}

TEST(Mcap, HoldsEveryMessageWithSchemaChunkIndexAndSummary) {
  const ScratchFolder folder;
  constexpr int kEvents = 20000;  // some chunks
  write_poses(folder / "log", kEvents);
  OutputFile out(folder / "out", Existing::refuse, {});
  WalkInput input = walk_of(folder / "log");
  const McapResult result = export_mcap(input, types(), out, ignore_progress);
  out.finish();
  EXPECT_EQ(result.messages, 2U * kEvents);  // the poses, and each as PoseInFrame
  const test::McapFile file = test::read_mcap(read_text(folder / "out"));
  EXPECT_GT(file.chunks, 3U);
  EXPECT_EQ(file.messages.size(), 2U * kEvents);
  EXPECT_EQ(file.statistics_messages, 2U * kEvents);
  EXPECT_EQ(file.indexed_messages, 2U * kEvents);
  EXPECT_EQ(file.topics.size(), 4U);
  EXPECT_EQ(file.summary_topics, file.topics);
  int next = 0;
  for (const test::McapMessage& message : file.messages) {
    if (file.topics.at(message.channel).find('/') != std::string::npos) continue;
    EXPECT_EQ(message.time_ns, 1000ULL * (kStartUs + 100000ULL * static_cast<uint64_t>(next)));
    ASSERT_EQ(Json::parse(message.data).at("x_m"), next);
    ++next;
  }
  EXPECT_EQ(next, kEvents);
  const Json schema = Json::parse(file.schemas.at("marco.pose2_t"));
  EXPECT_EQ(schema.at("type"), "object");
  EXPECT_EQ(schema.at("properties").size(), 4U);
}

std::map<std::string, Json> foxglove_of(const ScratchFolder& folder) {
  OutputFile out(folder / "out.mcap", Existing::refuse, {});
  WalkInput input = walk_of(folder / "log");
  export_mcap(input, types(), out, ignore_progress);
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
  export_mcap(input, types(), out, ignore_progress);
  out.finish();
  return test::read_mcap(read_text(folder / "out.mcap"));
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

TEST(Images, BecomeFiles) {
  const ScratchFolder folder;
  bot_core::image_t image{};
  {
    files::EventLogWriter writer(folder / "log");
    image.utime = 1;
    image.width = 2;
    image.height = 2;
    image.row_stride = 8;
    image.pixelformat = bot_core::image_t::PIXEL_FORMAT_BGR;
    image.data = {255, 0, 0, 0, 255, 0, 9, 9, 0, 0, 255, 7, 7, 7};
    image.size = static_cast<int32_t>(image.data.size());
    write_message(writer, "CAMERA", image);
    image.utime = 2;
    image.height = 3;  // more than there are bytes
    write_message(writer, "CAMERA", image);
    image.utime = 3;
    image.pixelformat = 12345;
    write_message(writer, "CAMERA", image);
    image.utime = 4;
    image.pixelformat = bot_core::image_t::PIXEL_FORMAT_MJPEG;
    write_message(writer, "CAMERA", image);
  }
  WalkInput input = walk_of(folder / "log");
  const ImagesResult result =
      export_images(input, types(), folder / "pictures", Existing::refuse, ignore_progress);
  EXPECT_EQ(result.written, 2);
  EXPECT_EQ(result.broken, 1);
  EXPECT_EQ(result.unknown_format, 1);
  const viewer::Picture picture = viewer::read_picture(folder / "pictures/CAMERA_1.png");
  EXPECT_EQ(picture.at(0, 0), (viewer::Rgb{0, 0, 255}));
  EXPECT_EQ(picture.at(1, 0), (viewer::Rgb{0, 255, 0}));
  EXPECT_EQ(picture.at(0, 1), (viewer::Rgb{255, 0, 0}));
  EXPECT_EQ(read_text(folder / "pictures/CAMERA_4.jpg"),
            std::string(image.data.begin(), image.data.end()));
}

TEST(Png, OfAnySizeReadsBackWithAnIndependentReader) {
  const ScratchFolder folder;
  std::mt19937 random(2);
  // Rows of 1 to 300 pixels; some need several stored blocks.
  for (const auto& [width, height] : {std::pair(1, 1), {3, 5}, {300, 120}}) {
    for (const int bytes : {1, 3}) {
      std::vector<uint8_t> pixels(static_cast<std::size_t>(width * height * bytes));
      for (uint8_t& value : pixels) value = static_cast<uint8_t>(random());
      write_text(folder / "png", to_png(pixels, width, bytes));
      const viewer::Picture picture = viewer::read_picture(folder / "png");
      ASSERT_EQ(picture.width_px, width);
      ASSERT_EQ(picture.height_px, height);
      for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
        const auto at = i * static_cast<std::size_t>(bytes);
        const auto last = static_cast<std::size_t>(bytes - 1);
        ASSERT_EQ(picture.pixels[i],
                  (viewer::Rgb{pixels[at], pixels[at + std::min<std::size_t>(1, last)],
                               pixels[at + last]}));
      }
    }
  }
}

TEST(Exports, TakeAnyBytesWithoutACrash) {
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
      bot_core::image_t image{};
      image.pixelformat = bot_core::image_t::PIXEL_FORMAT_GRAY;
      image.width = image.height = 1;
      image.size = 1;
      image.data = {1};
      write_message(writer, "CAMERA", image);
    }
  }
  const std::string good = read_text(folder / "good");
  std::mt19937 random(8);
  for (int round = 0; round < 40; ++round) {
    std::string bytes = good;
    for (int flips = 0; flips < 15; ++flips)
      bytes[random() % bytes.size()] = static_cast<char>(random());
    write_text(folder / "bad", bytes);
    WalkInput input = walk_of(folder / "bad");
    // All of them see the same events, and what they write is whole.
    OutputFile mcap(folder / "mcap", Existing::replace, {});
    const McapResult as_mcap = export_mcap(input, types(), mcap, ignore_progress);
    mcap.finish();
    const test::McapFile file = test::read_mcap(read_text(folder / "mcap"));
    EXPECT_EQ(file.messages.size(), as_mcap.messages);
    for (const test::McapMessage& message : file.messages) {
      EXPECT_TRUE(Json::accept(message.data)) << message.data;
    }
    OutputFile lines(folder / "lines", Existing::replace, {});
    const WalkResult as_lines = export_json_lines(input, types(), lines, ignore_progress);
    lines.finish();
    EXPECT_EQ(as_lines.events, as_mcap.walk.events);
    EXPECT_EQ(as_lines.undecodable, as_mcap.walk.undecodable);
    std::istringstream text(read_text(folder / "lines"));
    int64_t objects = 0;
    for (std::string line; std::getline(text, line); ++objects) EXPECT_TRUE(Json::accept(line));
    EXPECT_EQ(objects, as_lines.events);
    const CsvResult as_csv =
        export_csv(input, types(), folder / "csv", Existing::replace, ignore_progress);
    EXPECT_EQ(as_csv.walk.undecodable, as_lines.undecodable);
    const ImagesResult as_images =
        export_images(input, types(), folder / "pictures", Existing::replace, ignore_progress);
    EXPECT_LE(as_images.written + as_images.broken + as_images.unknown_format, as_lines.events);
  }
}

}  // namespace
}  // namespace marco::logs
