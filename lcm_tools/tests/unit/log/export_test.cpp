#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <png.h>

#include <nlohmann/json.hpp>
#include <random>
#include <sstream>

#include "bot_core/image_t.hpp"
#include "bot_core/planar_lidar_t.hpp"
#include "lcm_tools/log/export_csv.hpp"
#include "lcm_tools/log/export_images.hpp"
#include "lcm_tools/log/export_json_lines.hpp"
#include "lcm_tools/log/export_mcap.hpp"
#include "lcm_tools/log/png.hpp"
#include "lcm_tools/tests/unit/log/mcap_reader.hpp"
#include "lcm_tools/tests/unit/log/tiny_log.hpp"
#include "robot/lidar_raw_t.hpp"
#include "robot/map_request_t.hpp"
#include "robot/slam_pose_t.hpp"

namespace marco::logs {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using Json = nlohmann::json;

const Types& types() {
  static const Types kAll({"tests/types"});
  return kAll;
}

WalkInput walk_of(const std::string& path) {
  WalkInput input;
  input.path = path;
  return input;
}

template <class Message>
void write_message(files::EventLogWriter& writer, const char* channel, const Message& message) {
  writer.write(channel, testing::encoded(message), Utime::from_us(message.utime));
}

bot_core::planar_lidar_t small_scan() {
  bot_core::planar_lidar_t scan{};
  scan.utime = kStartUs;
  scan.nranges = 3;
  scan.ranges = {1.5F, 0.0F, std::numeric_limits<float>::infinity()};
  scan.rad0 = -0.5F;
  scan.radstep = 0.5F;
  return scan;
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
  EXPECT_EQ(pose.at("type"), "robot.pose2_t");
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
    robot::slam_pose_t pose{};
    pose.covariance[1][2] = 0.5;
    write_message(writer, "A/B", pose);
    write_message(writer, "TRUE_POSE", pose);
    robot::map_request_t request;
    request.utime = 3;
    request.channel = "a, \"b\"";
    write_message(writer, "MAP_REQUEST", request);
  }
  WalkInput input = walk_of(folder / "log");
  const CsvResult result =
      export_csv(input, types(), folder / "csv", Existing::refuse, ignore_progress);
  EXPECT_THAT(result.files, ElementsAre("TRUE_POSE.csv", "LIDAR.csv", "A_B.csv",
                                        "TRUE_POSE.robot.slam_pose_t.csv", "MAP_REQUEST.csv"));
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

TEST(Mcap, HoldsEveryMessageWithSchemaChunkIndexAndSummary) {
  const ScratchFolder folder;
  constexpr int kEvents = 40000;  // some chunks
  write_poses(folder / "log", kEvents);
  OutputFile out(folder / "out", Existing::refuse, {});
  WalkInput input = walk_of(folder / "log");
  const McapResult result = export_mcap(input, types(), out, {}, ignore_progress);
  out.finish();
  EXPECT_EQ(result.messages, 1U * kEvents);
  const test::McapFile file = test::read_mcap(read_text(folder / "out"));
  EXPECT_GT(file.chunks, 3U);
  EXPECT_EQ(file.messages.size(), 1U * kEvents);
  EXPECT_EQ(file.statistics_messages, 1U * kEvents);
  EXPECT_EQ(file.indexed_messages, 1U * kEvents);
  EXPECT_EQ(file.topics.size(), 2U);
  EXPECT_EQ(file.summary_topics, file.topics);
  int next = 0;
  for (const test::McapMessage& message : file.messages) {
    EXPECT_EQ(message.time_ns, 1000ULL * (kStartUs + 100000ULL * static_cast<uint64_t>(next)));
    ASSERT_EQ(Json::parse(message.data).at("x_m"), next);
    ++next;
  }
  EXPECT_EQ(next, kEvents);
  const Json schema = Json::parse(file.schemas.at("robot.pose2_t"));
  EXPECT_EQ(schema.at("type"), "object");
  EXPECT_EQ(schema.at("properties").size(), 4U);
}

// Adds a note to every second message, and one at the end.
class Notes : public McapTranslator {
 public:
  std::vector<AddedMessage> translate(const DecodedEvent& event) override {
    if (event.head.number % 2 == 1) return {};
    return {{std::string(event.head.channel) + "/Note", "test.Note",
             "{\"event\":" + std::to_string(event.head.number) + "}"}};
  }
  std::vector<AddedMessage> finish() override {
    return {{"END", "test.End", "{}", Utime::from_us(kStartUs + 7)}};
  }
  std::string json_schema(const std::string& schema) const override {
    return "{\"title\":\"" + schema + "\"}";
  }
  std::string remark() const override { return "that was all"; }
};

TEST(Mcap, ATranslatorAddsTopicsWithSchemasOfTheirOwn) {
  const ScratchFolder folder;
  write_poses(folder / "log", 10);
  OutputFile out(folder / "out", Existing::refuse, {});
  WalkInput input = walk_of(folder / "log");
  std::vector<std::string> surveyed;
  const McapResult result = export_mcap(
      input, types(), out,
      [&](const LogInfo& log) {
        for (const ChannelInfo& channel : log.channels) surveyed.push_back(channel.name);
        return std::make_unique<Notes>();
      },
      ignore_progress);
  out.finish();
  EXPECT_THAT(surveyed, ElementsAre("OTHER", "TRUE_POSE"));
  EXPECT_EQ(result.messages, 16U);  // 10 originals, 5 notes, 1 end
  EXPECT_EQ(result.topics, 4U);
  EXPECT_EQ(result.remark, "that was all");
  const test::McapFile file = test::read_mcap(read_text(folder / "out"));
  EXPECT_EQ(file.schemas.at("test.Note"), "{\"title\":\"test.Note\"}");
  std::map<std::string, std::vector<uint64_t>> times_ns;
  for (const test::McapMessage& message : file.messages) {
    times_ns[file.topics.at(message.channel)].push_back(message.time_ns);
  }
  EXPECT_EQ(times_ns.at("TRUE_POSE/Note"), times_ns.at("TRUE_POSE"));
  EXPECT_THAT(times_ns.at("END"), ElementsAre(1000ULL * (kStartUs + 7)));
}

// Pixels of a PNG by libpng: red, green, blue each.
struct Picture {
  unsigned width = 0, height = 0;
  std::vector<uint8_t> rgb;
};

Picture read_png(const std::string& path) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  EXPECT_NE(png_image_begin_read_from_file(&image, path.c_str()), 0) << image.message;
  image.format = PNG_FORMAT_RGB;
  Picture picture{image.width, image.height, std::vector<uint8_t>(PNG_IMAGE_SIZE(image))};
  EXPECT_NE(png_image_finish_read(&image, nullptr, picture.rgb.data(), 0, nullptr), 0);
  return picture;
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
  const Picture picture = read_png(folder / "pictures/CAMERA_1.png");
  EXPECT_EQ(picture.width, 2U);
  EXPECT_THAT(picture.rgb, ElementsAre(0, 0, 255, 0, 255, 0, 255, 0, 0, 7, 7, 7));
  EXPECT_EQ(read_text(folder / "pictures/CAMERA_4.jpg"),
            std::string(image.data.begin(), image.data.end()));
}

TEST(Png, OfAnySizeReadsBack) {
  const ScratchFolder folder;
  std::mt19937 random(2);
  for (const auto& [width, height] : {std::pair(1, 1), {3, 5}, {300, 120}}) {
    for (const int bytes : {1, 3}) {
      std::vector<uint8_t> pixels(static_cast<std::size_t>(width * height * bytes));
      for (uint8_t& value : pixels) value = static_cast<uint8_t>(random());
      write_text(folder / "png", to_png(pixels, width, bytes));
      const Picture picture = read_png(folder / "png");
      ASSERT_EQ(picture.width, static_cast<unsigned>(width));
      ASSERT_EQ(picture.height, static_cast<unsigned>(height));
      std::vector<uint8_t> expected;
      for (const uint8_t value : pixels) {
        expected.insert(expected.end(), bytes == 3 ? 1 : 3, value);
      }
      ASSERT_EQ(picture.rgb, expected);
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
      robot::lidar_raw_t raw{};
      raw.num_ranges = 2;
      raw.thetas = {0.1F, 0.2F};
      raw.ranges = {1.0F, 2.0F};
      raw.times = {1, 2};
      raw.intensities = {0.0F, 0.0F};
      write_message(writer, "LIDAR_RAW", raw);
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
    const McapResult as_mcap = export_mcap(input, types(), mcap, {}, ignore_progress);
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
