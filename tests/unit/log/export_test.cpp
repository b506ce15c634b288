#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <random>
#include <sstream>

#include "bot_core/image_t.hpp"
#include "marco/map_request_t.hpp"
#include "marco/slam_pose_t.hpp"
#include "tests/unit/log/mcap_reader.hpp"
#include "tests/unit/log/tiny_log.hpp"
#include "tools/log/export_csv.hpp"
#include "tools/log/export_images.hpp"
#include "tools/log/export_json_lines.hpp"
#include "tools/log/export_mcap.hpp"
#include "tools/log/mcap_writer.hpp"
#include "tools/log/png.hpp"
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
    GridMap map;
    map.origin_m = {-1.0, 2.0};
    map.resolution_m = 0.5;
    map.width_cells = 2;
    map.height_cells = 1;
    map.occupancy = {0, 100};
    write_message(writer, "GRID_MAP", to_messages(map, Utime::from_us(kStartUs), 1).front());
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
  EXPECT_EQ(scan.at("frame_id"), "robot");
  EXPECT_EQ(scan.at("pose").at("position").at("x"), 0.25);
  EXPECT_EQ(scan.at("start_angle"), -0.5);
  EXPECT_EQ(scan.at("end_angle"), 0.5);
  EXPECT_EQ(scan.at("ranges"), Json({1.5, 0, 0}));  // what did not return is 0
  EXPECT_EQ(scan.at("timestamp").at("sec"), kStartUs / 1000000);
  const Json& grid = messages.at("GRID_MAP/Grid_0");
  EXPECT_EQ(grid.at("pose").at("position").at("y"), 2.0);
  EXPECT_EQ(grid.at("column_count"), 2);
  EXPECT_EQ(grid.at("data"), "AGQ=");
  EXPECT_EQ(messages.at("SLAM_POSE/PoseInFrame").at("pose").at("position").at("x"), 3.0);
  EXPECT_NEAR(messages.at("SLAM_POSE/FrameTransform").at("rotation").at("z"), 1.0, 1e-12);
  const Json& turned = messages.at("RPLIDAR_LASER/LaserScan");
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
    OutputFile mcap(folder / "mcap", Existing::replace, {});
    export_mcap(input, types(), mcap, ignore_progress);
    OutputFile lines(folder / "lines", Existing::replace, {});
    export_json_lines(input, types(), lines, ignore_progress);
    export_csv(input, types(), folder / "csv", Existing::replace, ignore_progress);
    export_images(input, types(), folder / "pictures", Existing::replace, ignore_progress);
  }
}

}  // namespace
}  // namespace marco::logs
