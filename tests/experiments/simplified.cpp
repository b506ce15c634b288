// Whether simplified models are as whole as what they are made of: simplified MODEL.ply...
// For each the mesh as it is and as simplify() makes it: triangles; open edges [m] and edges of
// more than two triangles, of vertices at the same place as one; the part of the area with a second
// sheet that faces the same way within 2 cm behind it. Then the distances both ways, and CPU
// seconds.
#include <algorithm>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <vector>

#include "common/files/ply.hpp"
#include "common/mesh_distance.hpp"
#include "common/mesh_samples.hpp"
#include "mapping3d/surface/simplify.hpp"
#include "tests/support/mesh_wholeness.hpp"
#include "tests/support/second_sheets.hpp"

namespace marco {
namespace {

constexpr float kSampleM2 = 2e-4F;  // as simplify() itself
constexpr float kFarM = 0.05F;      // distances are measured up to here

void print_wholeness(const char* name, const TriangleMesh& mesh) {
  const testing::Wholeness whole = testing::wholeness(mesh);
  const auto doubled = testing::second_sheets(mesh);
  std::printf(
      "  %-10s %8zu triangles, %8.2f m open, %6zu edges of more than two, "
      "second sheet %.2f %%\n",
      name, mesh.triangles.size(), whole.open_m, whole.of_more, 100.0 * doubled[0]);
}

void print_distances(const char* name, const TriangleMesh& from, const TriangleMesh& to) {
  const MeshDistance distance(to, kFarM);
  std::vector<float> found;
  for_each_sample(from, kSampleM2, [&](const Eigen::Vector3f& point, std::size_t /*triangle*/) {
    found.push_back(distance(point));
  });
  std::sort(found.begin(), found.end());
  std::printf("  %-10s p99 %.2f mm, largest %.2f mm\n", name,
              1e3 * static_cast<double>(found[found.size() * 99 / 100]),
              1e3 * static_cast<double>(found.back()));
}

void run(const std::filesystem::path& path) {
  const TriangleMesh mesh = files::read_ply(path);
  const std::vector<mapping3d::SurfacePlane> planes = mapping3d::find_planes(mesh);
  const std::clock_t start = std::clock();
  const mapping3d::Simplified fewer = mapping3d::simplify(mesh, planes);
  const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  std::printf("%s: simplified in %.2f s\n", path.c_str(), seconds);
  print_wholeness("full", mesh);
  print_wholeness("simplified", fewer.mesh);
  print_distances("there", mesh, fewer.mesh);
  print_distances("and back", fewer.mesh, mesh);
}

}  // namespace
}  // namespace marco

int main(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) marco::run(argv[i]);
  return argc > 1 ? 0 : 2;
}
