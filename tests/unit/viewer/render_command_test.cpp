#include "viewer/process/render_command.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tests/unit/viewer/tiny_room.hpp"
#include "viewer/process/inputs.hpp"

namespace marco::viewer {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

// A folder that goes with the test.
class Folder {
 public:
  explicit Folder(const std::string& name) : path_(fs::path(::testing::TempDir()) / name) {
    fs::remove_all(path_);
    fs::create_directories(path_);
  }
  ~Folder() { fs::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  std::string touch(const std::string& name) const {
    std::ofstream(path_ / name) << "x";
    return (path_ / name).string();
  }
  std::string path() const { return path_.string(); }

 private:
  fs::path path_;
};

FileReaders tiny_readers() {
  FileReaders readers;
  readers.mesh = [](const std::string& path) {
    if (path.find("broken") != std::string::npos) throw std::invalid_argument(path + ": broken");
    return testing::make_room();
  };
  readers.grid = [](const std::string&) {
    GridMap grid;
    grid.width_cells = grid.height_cells = 20;
    grid.occupancy.assign(400, 0);
    return grid;
  };
  readers.trajectory = [](const std::string&) {
    return Trajectory{{Utime::from_us(0), {0.2, 0.2, 0.0}}, {Utime::from_us(1), {0.8, 0.8, 0.0}}};
  };
  return readers;
}

TEST(Inputs, TakesFromAFolderWhatMapWrites) {
  const Folder folder("marco_viewer_inputs");
  for (const char* name : {"model.ply", "map.yaml", "trajectory.tum", "truth.tum", "report.json"})
    folder.touch(name);
  const Inputs inputs = read_inputs({folder.path()}, tiny_readers());
  EXPECT_EQ(inputs.scene.meshes.size(), 1U);
  EXPECT_TRUE(inputs.scene.grid.has_value());
  ASSERT_EQ(inputs.scene.paths.size(), 2U);
  EXPECT_EQ(inputs.scene.paths[0].label, "truth");
  EXPECT_EQ(inputs.scene.paths[1].color, palette::kEstimate);
  EXPECT_TRUE(inputs.skipped.empty());
}

TEST(Inputs, TakesAFoldersSimplifiedModelWhenAsked) {
  const Folder folder("marco_viewer_simplified");
  folder.touch("model.ply");
  std::string taken;
  FileReaders readers = tiny_readers();
  readers.mesh = [&](const std::string& path) {
    taken = fs::path(path).filename().string();
    return testing::make_room();
  };
  read_inputs({folder.path()}, readers, FolderModel::simplified);
  EXPECT_EQ(taken, "model.ply");  // there is no other
  folder.touch("model.glb");
  read_inputs({folder.path()}, readers, FolderModel::simplified);
  EXPECT_EQ(taken, "model.glb");
  read_inputs({folder.path()}, readers);
  EXPECT_EQ(taken, "model.ply");
}

TEST(Inputs, LaysOdometryAndTruthOnTheEstimate) {
  const Folder folder("marco_viewer_frames");
  for (const char* name : {"trajectory.tum", "truth.tum", "odometry.tum"}) folder.touch(name);
  FileReaders readers = tiny_readers();
  const Pose2 elsewhere{30.0, -7.0, 1.2};
  readers.trajectory = [&](const std::string& path) {
    Trajectory poses{{Utime::from_us(0), {0.2, 0.2, 0.0}}, {Utime::from_us(1), {0.8, 0.8, 0.0}}};
    if (path.find("trajectory.tum") != std::string::npos) return poses;
    for (auto& pose : poses) pose.world_from_robot = elsewhere * pose.world_from_robot;
    return poses;
  };
  const Inputs inputs = read_inputs({folder.path()}, readers);
  ASSERT_EQ(inputs.scene.paths.size(), 3U);
  for (const auto& path : inputs.scene.paths) {
    ASSERT_EQ(path.poses.size(), 2U) << path.label;
    EXPECT_NEAR(path.poses[1].world_from_robot.x_m, 0.8, 1e-9) << path.label;
    EXPECT_NEAR(path.poses[1].world_from_robot.y_m, 0.8, 1e-9) << path.label;
  }
}

TEST(Inputs, NamesWhatIsMissingEmptyOrBroken) {
  const Folder folder("marco_viewer_bad_inputs");
  const auto message = [&](const std::string& path) -> std::string {
    try {
      read_inputs({path}, tiny_readers());
    } catch (const std::invalid_argument& failure) {
      return failure.what();
    }
    return "";
  };
  EXPECT_THAT(message(folder.path() + "/none.ply"), HasSubstr("no such file"));
  EXPECT_THAT(message(folder.path()), HasSubstr("was it written by `map`"));
  EXPECT_THAT(message(folder.touch("notes.txt")), HasSubstr("expected .ply"));
  EXPECT_THAT(message(folder.touch("broken.ply")), HasSubstr("broken.ply: broken"));
}

TEST(Inputs, GoodPartsOfAFolderSurviveABrokenOne) {
  const Folder folder("marco_viewer_broken_inputs");
  folder.touch("model.ply");
  folder.touch("trajectory.tum");
  const Inputs inputs = read_inputs({folder.path()}, tiny_readers());
  EXPECT_EQ(inputs.scene.meshes.size(), 0U);
  EXPECT_EQ(inputs.scene.paths.size(), 1U);
  ASSERT_EQ(inputs.skipped.size(), 1U);
  EXPECT_THAT(inputs.skipped[0], HasSubstr("model.ply: broken"));
}

TEST(RenderCommand, ReadsSizes) {
  EXPECT_EQ(parse_size("640x480").width_px, 640);
  EXPECT_EQ(parse_size("640x480").height_px, 480);
  for (const char* bad : {"", "640", "640x", "x480", "640x480x3", "0x10", "-5x5", "640 x 480 px"})
    EXPECT_THROW(parse_size(bad), std::invalid_argument) << bad;
}

TEST(RenderCommand, TheRobotsOwnViewIsFromItsNewestPlace) {
  Scene scene = testing::room_scene();
  RenderRequest request;
  request.size = {160, 90};
  request.camera = "robot";
  EXPECT_THROW(render_scene(scene, request), std::invalid_argument);
  PathItem path;
  path.poses = {{Utime::from_us(0), {1.0, 1.0, 0.0}},
                {Utime::from_us(1), {3.0, 3.0, deg_to_rad(90.0)}}};
  scene.paths.push_back(path);
  Renderer renderer;
  renderer.load(scene);
  const ViewPlan plan = plan_request(scene, request, renderer);
  EXPECT_NEAR(plan.camera.eye_m.x(), 3.0, 1e-9);
  EXPECT_NEAR(plan.camera.eye_m.y(), 3.0, 1e-9);
  EXPECT_GT(plan.camera.target_m.y(), plan.camera.eye_m.y());
  // It stands 1 m before the wall at y = 4.
  const std::vector<float> depths = renderer.draw_depth_m(plan.camera, plan.look, request.size);
  EXPECT_NEAR(depths[160 * 45 + 80], 1.0F, 0.01F);
}

TEST(RenderCommand, WalksByKeys) {
  RenderRequest request;
  request.size = {160, 90};
  const std::string keys = "aaxi";
  std::size_t at = 0;
  std::vector<Picture> seen;
  const int count = render_walk_by_keys(
      testing::room_scene(), request, [&] { return at < keys.size() ? keys[at++] : '\0'; },
      [&](const Picture& picture) { seen.push_back(picture); });
  ASSERT_EQ(count, 4);  // x is no key
  ASSERT_EQ(seen.size(), 4U);
  for (std::size_t i = 1; i < seen.size(); ++i) EXPECT_NE(seen[i].pixels, seen[i - 1].pixels);
}

TEST(RenderCommand, DrawsAMapFlatAndAModelInSpace) {
  Scene map;
  map.grid = tiny_readers().grid("");
  RenderRequest request;
  request.size = {320, 180};
  EXPECT_NE(render_scene(map, request).height_px, 180);  // margins and legend are added
  request.camera = "above";
  EXPECT_EQ(render_scene(map, request).height_px, 180);
  for (const char* camera : {"", "above", "eye", "front", "1,2,1,0,0"}) {
    request.camera = camera;
    EXPECT_EQ(render_scene(testing::room_scene(), request).width_px, 320) << camera;
  }
  request.camera = "sideways";
  EXPECT_THROW(render_scene(testing::room_scene(), request), std::invalid_argument);
  request.camera = "";
  EXPECT_THROW(render_scene({}, request), std::invalid_argument);
}

}  // namespace
}  // namespace marco::viewer
