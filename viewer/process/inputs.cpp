#include "viewer/process/inputs.hpp"

#include <array>
#include <filesystem>
#include <memory>
#include <stdexcept>

#include "common/trajectory_fit.hpp"
#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/inside_folder.hpp"

namespace marco::viewer {
namespace {

namespace fs = std::filesystem;

struct PathKind {
  const char* file;
  Rgb color;
  const char* label;
};
// In the order they are drawn: the estimate lies on top.
constexpr std::array<PathKind, 3> kPathKinds{{{"odometry.tum", palette::kOdometry, "odometry"},
                                              {"truth.tum", palette::kTruth, "truth"},
                                              {"trajectory.tum", palette::kEstimate, "estimate"}}};

class InputReader {
 public:
  InputReader(const FileReaders& readers, FolderModel model) : readers_(readers), model_(model) {}

  void read(const std::string& path) {
    const fs::path input(path);
    require(fs::exists(input), path + ": no such file or folder");
    const std::size_t before = used_;
    if (fs::is_directory(input)) {
      read_folder(input);
    } else {
      read_file("", input, PathKind{"", palette::kSeries[inputs_.scene.paths.size() % 8], ""});
    }
    require(used_ > before,
            path + (inputs_.skipped.empty()
                        ? ": contains no model.ply, map.yaml or trajectory.tum; was it written by "
                          "`map`?"
                        : ": contains nothing to draw; " + inputs_.skipped.back()));
  }

  Inputs take() { return std::move(inputs_); }

 private:
  void read_folder(const fs::path& folder) {
    const bool is_simplified =
        model_ == FolderModel::simplified && fs::exists(folder / "model.glb");
    for (const char* name : {is_simplified ? "model.glb" : "model.ply", "map.yaml"})
      if (fs::exists(folder / name)) read_file(folder, name, {});
    const std::size_t first_path = inputs_.scene.paths.size();
    for (const PathKind& kind : kPathKinds)
      if (fs::exists(folder / kind.file)) read_file(folder, kind.file, kind);
    lay_on_estimate(first_path);
  }

  // As recorded, odometry and truth have frames of their own.
  void lay_on_estimate(std::size_t first_path) {
    auto& paths = inputs_.scene.paths;
    if (paths.size() <= first_path || paths.back().label != "estimate") return;
    const Trajectory estimate = paths.back().poses;
    for (std::size_t i = first_path; i + 1 < paths.size(); ++i) {
      paths[i].poses = paths[i].label == "truth" ? truth_on_estimate(estimate, {paths[i].poses})
                                                 : odometry_on_estimate(estimate, paths[i].poses);
    }
    std::erase_if(paths, [](const auto& path) { return path.poses.empty(); });
  }

  /// @param folder  that the file shall not lead out of; "" = the user named the file
  void read_file(const fs::path& folder, const fs::path& file, const PathKind& kind) {
    try {
      add(folder.empty() ? file : files::inside_folder(folder, file), kind);
      ++used_;
    } catch (const std::exception& failure) {
      inputs_.skipped.push_back(failure.what());
    }
  }

  void add(const fs::path& file, const PathKind& kind) {
    const std::string extension = file.extension().string();
    Scene& scene = inputs_.scene;
    if (extension == ".ply" || extension == ".obj" || extension == ".glb") {
      TriangleMesh mesh = readers_.mesh(file.string());
      require(!mesh.triangles.empty(), file.string() + ": a mesh without triangles");
      const Rgb color = palette::kSeries[scene.meshes.size() % palette::kSeries.size()];
      scene.meshes.push_back({std::make_shared<const TriangleMesh>(std::move(mesh)), color});
    } else if (extension == ".yaml") {
      require(!scene.grid, file.string() + ": a second map; a picture shows one map");
      scene.grid = readers_.grid(file.string());
    } else if (extension == ".tum") {
      Trajectory poses = readers_.trajectory(file.string());
      require(!poses.empty(), file.string() + ": a trajectory without poses");
      const std::string label = *kind.label != '\0' ? kind.label : file.stem().string();
      scene.paths.push_back({std::move(poses), kind.color, label});
    } else {
      throw std::invalid_argument(
          file.string() + ": expected .ply, .obj, .glb, .yaml, .tum or a folder written by `map`");
    }
  }

  const FileReaders& readers_;
  FolderModel model_;
  Inputs inputs_;
  std::size_t used_ = 0;
};

}  // namespace

Inputs read_inputs(const std::vector<std::string>& paths,
                   const FileReaders& readers,
                   FolderModel model) {
  InputReader reader(readers, model);
  for (const std::string& path : paths) reader.read(path);
  return reader.take();
}

}  // namespace marco::viewer
