// marco-map as a user starts it: bad input, the same twice, and live what it is in batch.
#include <gmock/gmock.h>
#include <sys/mount.h>

#include <array>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "common/files/glb.hpp"
#include "common/files/ply.hpp"
#include "common/files/tum.hpp"
#include "common/trajectory_fit.hpp"
#include "lcm_tools/files/event_log.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "marco/mesh_t.hpp"
#include "marco/pose2_t.hpp"
#include "marco/process_status_t.hpp"
#include "marco/slam_pose_t.hpp"
#include "tests/support/command_test.hpp"
#include "viewer/image_io.hpp"

namespace marco {
namespace {

using ::marco::testing::Program;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr double kSampleBeams = 181.0;  // of a scan of logs/sample.lcm

constexpr const char* kShortTour = R"(
start_m = [2.0, 3.0]
[[steps]]
kind = "sweep"
pans_deg = [0, 90]
rows = 40
[[steps]]
to_m = [5.6, 2.2]
[[steps]]
to_m = [9.6, 2.6]
[[steps]]
kind = "face"
heading_deg = 150
[[steps]]
to_m = [7.0, 4.0]
)";

class MapProcess : public testing::CommandTest {
 protected:
  // One drive for all tests, and one map of it that they only read: both take seconds.
  static void SetUpTestSuite() {
    shared_ =
        std::filesystem::temp_directory_path() / ("marco_map_process_" + std::to_string(getpid()));
    std::filesystem::create_directories(shared_);
  }
  static void TearDownTestSuite() { std::filesystem::remove_all(shared_); }
  static inline std::filesystem::path shared_;
  std::string drive() const {
    const std::string log = shared_ / "short.lcm";
    if (std::filesystem::exists(log)) return log;
    const auto tour = folder_.write("tour.toml", kShortTour);
    const Result result = run("marco-simulate", {"--world", "config/worlds/lab.toml", "--tour",
                                                 tour.string(), "--out", log});
    EXPECT_EQ(result.code, 0) << result.output;
    return log;
  }
  Result map_drive(const std::string& out) const {
    return run("marco-map", {drive(), "--out", out, "--world", "config/worlds/lab.toml"});
  }
  std::string map_of_drive() const {
    const std::string out = shared_ / "map";
    if (std::filesystem::exists(out)) return out;
    const Result result = map_drive(out);
    EXPECT_EQ(result.code, 0) << result.output;
    return out;
  }
  // The same with a picture every two seconds of three cameras; of the first, one was torn on its
  // way and one has another file's bytes.
  std::string simulate_with_cameras() {
    const auto tour = folder_.write("tour.toml", kShortTour);
    const Result result =
        run("marco-simulate",
            {"--world", "config/worlds/lab.toml", "--tour", tour.string(), "--cameras",
             "config/robots/michoacan.toml", "--pictures-every", "2", "--out", at("whole.lcm")});
    EXPECT_EQ(result.code, 0) << result.output;
    files::EventLogReader whole(at("whole.lcm"));
    files::EventLogWriter log(at("pictures.lcm"));
    int pictures = 0;
    while (auto event = whole.next()) {
      pictures += event->channel == "CAMERA" ? 1 : 0;
      const bool hit = event->channel == "CAMERA" && pictures <= 2;
      constexpr std::size_t kJpegAt = 36;  // behind fingerprint, stamp, sizes and format
      for (std::size_t i = pictures == 1 ? kJpegAt : kJpegAt + 4;
           hit && i < event->bytes.size() - 4; ++i) {
        event->bytes[i] = 0x55;
      }
      log.write(event->channel, event->bytes, event->event_time);
    }
    log.flush();
    return at("pictures.lcm");
  }
  nlohmann::json report(const std::string& out) const {
    auto read = nlohmann::json::parse(files::read_whole_file(out + "/report.json"));
    expect_explained(read, files::read_whole_file("docs/report.md"));
    return read;
  }
  // Every field of a report stands in the document; of open lists (causes, kinds) their names.
  static void expect_explained(const nlohmann::json& value, const std::string& document) {
    for (const auto& item : value.items()) {
      if (value.is_object()) {
        EXPECT_THAT(document, HasSubstr("`" + item.key() + "`"));
      }
      const bool open = item.key() == "configuration" || item.key() == "read" ||
                        (item.key() == "dropped" && item.value().is_object());
      if (item.value().is_structured() && !open) expect_explained(item.value(), document);
    }
  }
};

std::set<std::string> channels_of(const std::string& log) {
  std::set<std::string> channels;
  files::EventLogReader reader(log);
  while (const auto event = reader.next()) channels.insert(event->channel);
  return channels;
}

/// The corners of each triangle, in order.
using Corners = std::vector<std::array<Eigen::Vector3f, 3>>;

Corners sent_as_mesh(const std::string& log) {
  Corners corners;
  files::EventLogReader reader(log);
  while (const auto event = reader.next()) {
    if (event->channel != channels::kMesh) continue;
    mesh_t tile;
    EXPECT_GE(tile.decode(event->bytes.data(), 0, static_cast<int>(event->bytes.size())), 0);
    for (const auto& triangle : tile.triangles) {
      auto& three = corners.emplace_back();
      for (std::size_t i = 0; i < 3; ++i) {
        const auto& at = tile.vertices_m[static_cast<std::size_t>(triangle[i])];
        three[i] = {at[0], at[1], at[2]};
      }
    }
  }
  return corners;
}

TEST_F(MapProcess, MakesEverythingAndMeasuresItAgainstTheTruth) {
  const std::string out = map_of_drive();
  for (const char* name :
       {"map.pgm", "map.yaml", "map.png", "trajectory.tum", "trajectory_live.tum", "odometry.tum",
        "truth.tum", "model.ply", "model.glb", "model.obj", "planes.json", "model.png", "slam.lcm",
        "report.json"}) {
    EXPECT_TRUE(std::filesystem::exists(out + "/" + name)) << name;
  }
  EXPECT_FALSE(std::filesystem::exists(out + "/model_scenes.ply")) << "it is large: on demand";
  // The model that was sent is the one that was written.
  const TriangleMesh model = files::read_ply(out + "/model.ply");
  Corners written;
  for (const auto& [a, b, c] : model.triangles) {
    written.push_back({model.vertices_m[a], model.vertices_m[b], model.vertices_m[c]});
  }
  EXPECT_GT(written.size(), 10000U);
  EXPECT_TRUE(sent_as_mesh(out + "/slam.lcm") == written);
  const nlohmann::json errors = report(out).at("errors");
  // The range noise is 10 mm; a path off by more is no measurement of 361 beams.
  EXPECT_LT(errors.at("path error rms_m"), 0.01);
  EXPECT_GT(errors.at("odometry error rms_m"), 0.05);
  // Cells of 50 mm: their centres lie up to 35 mm from the wall that runs through them.
  EXPECT_LT(errors.at("map error rms_m"), 0.035);
  // Two of twelve sweeps, their scenes not yet registered in 3D: the floor's unevenness is in it.
  EXPECT_LT(errors.at("model error rms_m"), 0.02);
  const nlohmann::json surface = report(out).at("surface");
  EXPECT_LT(surface.at("simplified triangles"), 0.1 * surface.at("triangles").get<double>());
  EXPECT_LE(surface.at("simplified, farthest sample_m"), 0.01);
  const auto scans = files::read_tum(out + "/truth.tum").size();
  EXPECT_EQ(files::read_tum(out + "/trajectory.tum").size(), scans);
  EXPECT_EQ(files::read_tum(out + "/trajectory_live.tum").size(), scans);
}

// Of the simulator's colours what the light leaves as it is.
const char* colour_class(const std::array<float, 3>& rgb) {
  const auto [red, green, blue] = rgb;
  if (red + green + blue < 3 * 28) return "black";
  if (red > 1.25F * blue) return "warm";
  return blue > 1.1F * red ? "cold" : "white";
}

// What the world says is there: a brown floor, a white ceiling. Of the walls nothing is asked.
const char* true_class(const Eigen::Vector3f& at, const Eigen::Vector3f& normal) {
  if (at.z() < 0.05F && normal.z() > 0.95F) return "warm";
  return at.z() > 2.75F && normal.z() < -0.95F ? "white" : nullptr;
}

// Barycentric coordinates of points all over a triangle, 5 cm apart.
std::vector<Eigen::Vector3f> samples_of_triangle(float area_m2) {
  constexpr float kApartM = 0.05F;
  const int parts = std::max(1, static_cast<int>(std::ceil(std::sqrt(2.0F * area_m2) / kApartM)));
  std::vector<Eigen::Vector3f> samples;
  for (int i = 0; i < parts; ++i) {
    for (int j = 0; i + j < parts; ++j) {
      const float a = (static_cast<float>(i) + 1.0F / 3.0F) / static_cast<float>(parts);
      const float b = (static_cast<float>(j) + 1.0F / 3.0F) / static_cast<float>(parts);
      samples.emplace_back(a, b, 1.0F - a - b);
    }
  }
  return samples;
}

TEST_F(MapProcess, ARecordingWithPicturesMakesAModelWithTheWorldsColours) {
  const Result result = run("marco-map", {simulate_with_cameras(), "--out", at("out"),
                                          "--sweep-meshes", "--results-log"});
  ASSERT_EQ(result.code, 0) << result.output;
  EXPECT_THAT(channels_of(at("out/slam.lcm")),
              ElementsAre("GRID_MAP", "LOOP_CLOSURES", "MESH", "SCENE", "SLAM_POSE", "TRAJECTORY"));
  EXPECT_GT(files::read_ply(at("out/model_scenes.ply")).triangles.size(), 10000U);
  EXPECT_THAT(result.output, HasSubstr("skipped: "));
  const nlohmann::json told = report(at("out")).at("photographs");
  EXPECT_EQ(told.at("dropped").at("unknown picture format"), 1);
  EXPECT_EQ(told.at("painted").at("skipped"), 1);
  EXPECT_GT(told.at("painted").at("used"), 8);
  const TexturedMesh model = files::read_glb(at("out") + "/model_textured.glb");
  const viewer::Picture atlas = viewer::decode_picture(model.image);
  std::map<std::string, std::pair<float, float>> right_of_all_m2;
  for (const auto& t : model.mesh.triangles) {
    const auto& v = model.mesh.vertices_m;
    const Eigen::Vector3f across = (v[t[1]] - v[t[0]]).cross(v[t[2]] - v[t[0]]);
    const char* truth = true_class((v[t[0]] + v[t[1]] + v[t[2]]) / 3.0F, across.normalized());
    if (truth == nullptr) continue;
    auto& [right_m2, all_m2] = right_of_all_m2[truth];
    const std::vector<Eigen::Vector3f> samples = samples_of_triangle(0.5F * across.norm());
    const float area_m2 = 0.5F * across.norm() / static_cast<float>(samples.size());
    for (const Eigen::Vector3f& at : samples) {
      const Eigen::Vector2f uv =
          at.x() * model.uvs[t[0]] + at.y() * model.uvs[t[1]] + at.z() * model.uvs[t[2]];
      const viewer::Rgb pixel =
          atlas.pixels[static_cast<std::size_t>(uv.y() * static_cast<float>(atlas.height_px)) *
                           static_cast<std::size_t>(atlas.width_px) +
                       static_cast<std::size_t>(uv.x() * static_cast<float>(atlas.width_px))];
      if (pixel.red == 128 && pixel.green == 128 && pixel.blue == 128) continue;  // not seen
      const std::string seen =
          colour_class({static_cast<float>(pixel.red), static_cast<float>(pixel.green),
                        static_cast<float>(pixel.blue)});
      if (seen == truth) right_m2 += area_m2;
      all_m2 += area_m2;
    }
  }
  for (const char* name : {"warm", "white"}) {
    const auto [right_m2, all_m2] = right_of_all_m2[name];
    // A leg's or an edge's own colour bleeds over a texel or two beside it.
    EXPECT_GT(right_m2, 0.95F * all_m2) << name << ": " << right_m2 << " of " << all_m2;
    EXPECT_GT(all_m2, 1.0F) << name;
  }
}

TEST_F(MapProcess, TwoRunsAreTheSameToTheLastByte) {
  const std::string one = map_of_drive();
  ASSERT_EQ(map_drive(at("two")).code, 0);
  for (const char* name : {"slam.lcm", "trajectory.tum", "trajectory_live.tum", "map.pgm",
                           "model.ply", "model.glb", "model.obj", "planes.json"}) {
    EXPECT_TRUE(files::read_whole_file(one + "/" + name) ==
                files::read_whole_file(at("two") + "/" + name))
        << name;
  }
}

TEST_F(MapProcess, WhatCannotBeReadIsSaidAndTheExitCodeIsNotZero) {
  const auto fails = [&](const std::string& input) {
    const Result result = run("marco-map", {input, "--out", at("out")});
    EXPECT_EQ(result.code, 1) << result.output;
    return result.output;
  };
  EXPECT_THAT(fails("/nonexistent/log"), HasSubstr("/nonexistent/log: there is no such file"));
  EXPECT_THAT(fails(folder_.write("empty", "").string()), HasSubstr("empty"));
  EXPECT_THAT(fails(folder_.path().string()), HasSubstr("no 3D scan"));
  EXPECT_THAT(fails(folder_.write("p.log", "\x89PNG\r\n\x1a\n1234").string()),
              HasSubstr("PNG picture"));
}

TEST_F(MapProcess, TheReportSaysWhoMadeItAndHowAlsoOfStrangeNames) {
  const std::string name = at("a\xff.lcm");
  std::filesystem::copy_file("logs/sample.lcm", name);
  const auto config = folder_.write("map.toml", "[surface]\nvoxel_m = 0.03\n");
  const Result result =
      run("marco-map", {name, "--out", at("out"), "--config", config.string(), "--hold-out", "5"});
  ASSERT_EQ(result.code, 0) << result.output;
  const nlohmann::json found = report(at("out"));
  EXPECT_THAT(found.at("marco").get<std::string>(),
              ::testing::MatchesRegex("[0-9]+\\.[0-9]+\\.[0-9]+.*"));
  EXPECT_EQ(found.at("command_line").at(3), at("out"));
  EXPECT_THAT(found.at("command_line").at(1), HasSubstr("a\xEF\xBF\xBD.lcm"));
  EXPECT_EQ(found.at("configuration").dump(), R"({"surface":{"voxel_m":0.03}})");
}

// The map is judged by the scans that were kept out of it, and by no others.
TEST_F(MapProcess, OnlyHeldOutScansJudgeTheMap) {
  for (const char* maker : {"--loop-pictures", "--lines"}) {
    const Result result =
        run("marco-map", {"logs/sample.lcm", "--out", at("out"), "--hold-out", "5", maker});
    ASSERT_EQ(result.code, 0) << result.output;
    const nlohmann::json found = report(at("out"));
    const double held_out = found.at("scans").at("held_out");
    EXPECT_EQ(held_out, 44) << maker;  // of 223
    const double beams = found.at("errors").at("held-out beams");
    EXPECT_GT(beams, 0.5 * kSampleBeams * held_out) << maker;
    EXPECT_LE(beams, kSampleBeams * held_out) << maker;
  }
}

TEST_F(MapProcess, ADamagedLogIsUsedAsFarAsItIsGood) {
  std::string bytes = files::read_whole_file(drive());
  bytes.resize(bytes.size() - 100);  // ends within an event
  for (int i = 0; i < 100; ++i) {
    char& byte = bytes[static_cast<std::size_t>(i + 1) * (bytes.size() / 102)];
    byte = static_cast<char>(byte ^ (1 << (i % 8)));
  }
  const Result result =
      run("marco-map", {folder_.write("damaged", bytes).string(), "--out", at("out")});
  ASSERT_EQ(result.code, 0) << result.output;
  const nlohmann::json found = report(at("out"));
  EXPECT_GE(found.at("inputs").at(0).at("dropped").size(), 2U);
  // 100 events of thousands were hit: most scans must still be matched or passed by as tilted.
  EXPECT_GT(found.at("scans").at("posed"), 700);
  // The damaged log's own truth is damaged too.
  const TrajectoryFit fit = fit_to_truth(files::read_tum(at("out/trajectory.tum")),
                                         files::read_tum(map_of_drive() + "/truth.tum"));
  EXPECT_LT(fit.rms_m, 0.02);
}

// The truth is of a clock a year ahead, and arrives 170 ms late.
TEST_F(MapProcess, TheErrorAgainstTruthOfAnotherClockIsTheSameInItsOwnLog) {
  std::multimap<int64_t, files::LogEvent> events;
  files::EventLogReader sample("logs/sample.lcm");
  while (auto event = sample.next()) {
    if (event->channel == channels::kTruePose) {
      pose2_t pose{};
      ASSERT_GT(pose.decode(event->bytes.data(), 0, static_cast<int>(event->bytes.size())), 0);
      pose.utime += 31'536'000'000'000;
      event->bytes = encode_message(pose);
      event->event_time.us += 170'000;
    }
    events.emplace(event->event_time.us, *event);
  }
  files::EventLogWriter log(at("two_clocks.lcm"));
  for (const auto& [us, event] : events) log.write(event.channel, event.bytes, event.event_time);
  log.flush();
  ASSERT_EQ(run("marco-map", {at("two_clocks.lcm"), "--out", at("out")}).code, 0);
  const nlohmann::json errors = report(at("out")).at("errors");
  const double late_s = errors.at("true poses late_s"), rms_m = errors.at("path error rms_m");
  EXPECT_NEAR(late_s, 0.17, 0.03);
  std::array<char, 100> expected{};
  for (const char* truth : {"two_clocks.lcm", "out/slam.lcm"}) {
    const Result result = run("marco-evaluate", {at("out/trajectory.tum"), "--truth", at(truth)});
    std::snprintf(expected.data(), expected.size(), "rms=%.4f", rms_m);
    EXPECT_THAT(result.output, HasSubstr(expected.data())) << truth;
    std::snprintf(expected.data(), expected.size(), "truth_late_s=%.3f", late_s);
    EXPECT_THAT(result.output, HasSubstr(expected.data())) << truth;
  }
}

TEST_F(MapProcess, AFullDiskIsAFailureThatNamesTheFile) {
  const auto full = folder_.path() / "full";
  std::filesystem::create_directory(full);
  if (mount("none", full.c_str(), "tmpfs", 0, "size=1m") != 0) {
    std::printf("SKIPPED: no tmpfs of our own here\n");
    return;
  }
  const Result result = run("marco-map", {drive(), "--out", full.string()});
  umount(full.c_str());
  EXPECT_EQ(result.code, 1);
  EXPECT_THAT(result.output, HasSubstr("slam.lcm"));
  EXPECT_THAT(result.output, HasSubstr("No space left"));
}

// Poses by stamp, from SLAM_POSE.
using Poses = std::map<int64_t, Pose2>;

TEST_F(MapProcess, ALogReplayedIntoTheLiveProcessGivesThePosesOfTheBatchRun) {
  const Trajectory batch = files::read_tum(map_of_drive() + "/trajectory_live.tum");
  process::LcmBus bus("");
  process::DropCounter drops;
  Poses live;
  bool slam_is_up = false;
  bus.subscribe<process_status_t>(channels::kProcessStatus, drops,
                                  [&](const auto&, const auto&) { slam_is_up = true; });
  bus.subscribe<slam_pose_t>(channels::kSlamPose, drops, [&](const auto& pose, const auto&) {
    live[pose.utime] = {pose.x_m, pose.y_m, pose.theta_rad};
  });
  Program slam("marco-slam", {}, at("slam.out"));
  for (int i = 0; i < 100 && !slam_is_up; ++i) bus.handle_once(100);
  ASSERT_TRUE(slam_is_up) << files::read_whole_file(at("slam.out"));
  Program player("lcm-logplayer", {"--speed=2", drive()}, at("player.out"));
  // Ends when all have come, or no pose has come for three seconds of its statuses.
  std::size_t before = 0;
  for (int silent = 0; silent < 60 && live.size() < batch.size();) {
    bus.handle_once(50);
    silent = std::exchange(before, live.size()) == live.size() ? silent + 1 : 0;
  }
  slam.signal(SIGTERM);
  EXPECT_EQ(slam.wait(20), 0);
  std::size_t met = 0;
  for (const StampedPose2& pose : batch) {
    const auto same = live.find(pose.utime.us);
    if (same == live.end()) continue;
    ++met;
    const Pose2 off = between(pose.world_from_robot, same->second);
    ASSERT_LT(off.translation_m().norm(), 0.001) << "at " << pose.utime.us;
    ASSERT_LT(std::abs(off.theta_rad), 0.001) << "at " << pose.utime.us;
  }
  // The last scan waits for odometry that never comes.
  EXPECT_GE(met + 3, batch.size());
}

}  // namespace
}  // namespace marco
