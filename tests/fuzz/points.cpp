// Scans that somebody sent. The name's ending says as much of a text as its content does: each
// input becomes a file in a folder of its own.
#include "common/files/ply.hpp"
#include "common/files/points/point_files.hpp"
#include "tests/fuzz/memory_file.hpp"
#include "tests/fuzz/target.hpp"

namespace marco::fuzz {
namespace {

namespace fs = std::filesystem;

void promise_whole(const PointCloud& cloud, std::size_t bytes) {
  const std::size_t points = cloud.points_m.size();
  // LZF packs 264 bytes into 3, three bytes may be a point.
  promise(points <= 100 * bytes, "no more points than the file explains");
  promise(cloud.intensities.empty() || cloud.intensities.size() == points, "an intensity a point");
  promise(cloud.colors_rgb.empty() || cloud.colors_rgb.size() == points, "a colour a point");
  promise(cloud.rows == 0 || points % cloud.rows == 0, "rows of one length");
  promise(cloud.origin_m.allFinite(), "a finite origin");
  promise(!cloud.world_from_scanner || cloud.world_from_scanner->matrix().allFinite(),
          "a finite pose");
}

void read_mesh(const fs::path& path) {
  const TriangleMesh mesh = files::read_ply(path);
  for (const auto& triangle : mesh.triangles) {
    for (const uint32_t corner : triangle) {
      promise(corner < mesh.vertices_m.size(), "a triangle's vertices are there");
    }
  }
}

/// Reads all there is; a reader's complaint is an answer, too.
template <class Read>
void hear(Read read) {
  try {
    read();
  } catch (const std::invalid_argument&) {
  }
}

MARCO_FUZZ(point_files) {
  Input input(bytes);
  constexpr const char* kNames[] = {"a.pcd", "a.ply", "a.xyz", "a.csv", "a.pts", "a.ptx", "a.3d"};
  const std::string name = kNames[input.byte() % 7];
  static const TemporaryFolder kFolder;
  const fs::path path = kFolder.path() / name, pose = kFolder.path() / "a.pose";
  const auto pose_text = input.take(input.byte());
  if (!pose_text.empty()) write_file(pose, pose_text);
  write_file(path, input.rest());
  hear([&] {
    const PointCloud cloud = files::read_points(path);
    promise_whole(cloud, bytes.size());
    const fs::path again = kFolder.path() / "again.pcd";
    files::write_points(again, files::PointFormat::pcd, cloud);
    promise(files::read_points(again).points_m.size() == cloud.points_m.size(),
            "what was read can be written");
  });
  if (name == "a.ply") hear([&] { read_mesh(path); });
  fs::remove(path);
  fs::remove(pose);
}

}  // namespace
}  // namespace marco::fuzz
