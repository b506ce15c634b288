#include "mapping3d/clouds/color_field.hpp"

#include <cmath>

namespace marco::mapping3d {
namespace {

constexpr std::array<uint8_t, 3> kUnseen{160, 160, 160};

// Between points that lie far apart colours spread along the surface, an edge of a triangle at a
// time.
void spread(TriangleMesh& mesh, std::vector<bool>& painted) {
  constexpr int kMostSteps = 40;  // a metre of the default voxels
  bool changed = true;
  for (int step = 0; changed && step < kMostSteps; ++step) {
    changed = false;
    const std::vector<bool> before = painted;
    for (const auto& triangle : mesh.triangles) {
      for (std::size_t i = 0; i < 3; ++i) {
        const uint32_t to = triangle[i], from = triangle[(i + 1) % 3],
                       other = triangle[(i + 2) % 3];
        if (painted[to] || (!before[from] && !before[other])) continue;
        mesh.colors_rgb[to] = mesh.colors_rgb[before[from] ? from : other];
        painted[to] = changed = true;
      }
    }
  }
}

}  // namespace

Cell ColorField::cell_of(const Eigen::Vector3f& point_m) const {
  return (point_m / cube_m_).array().floor().matrix().cast<int>();
}

void ColorField::add(const Eigen::Vector3f& point_m, const std::array<uint8_t, 3>& rgb) {
  Sum& sum = sums_.voxel(cell_of(point_m));
  for (std::size_t i = 0; i < 3; ++i) sum.rgb[i] += static_cast<float>(rgb[i]);
  sum.count += 1.0F;
}

ColorField::Sum ColorField::around(const Cell& cell) const {
  Sum all;
  for (int i = 0; i < 27; ++i) {
    const Sum* sum = sums_.find_voxel(cell + Cell(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1));
    if (sum == nullptr) continue;
    for (std::size_t channel = 0; channel < 3; ++channel) all.rgb[channel] += sum->rgb[channel];
    all.count += sum->count;
  }
  return all;
}

void ColorField::paint(TriangleMesh& mesh) const {
  mesh.colors_rgb.assign(mesh.vertices_m.size(), kUnseen);
  std::vector<bool> painted(mesh.vertices_m.size(), false);
  for (std::size_t i = 0; i < mesh.vertices_m.size(); ++i) {
    const Cell cell = cell_of(mesh.vertices_m[i]);
    const Sum* own = sums_.find_voxel(cell);
    const Sum sum = own != nullptr && own->count > 0.0F ? *own : around(cell);
    if (sum.count <= 0.0F) continue;
    painted[i] = true;
    for (std::size_t channel = 0; channel < 3; ++channel) {
      mesh.colors_rgb[i][channel] = static_cast<uint8_t>(std::lround(sum.rgb[channel] / sum.count));
    }
  }
  spread(mesh, painted);
}

}  // namespace marco::mapping3d
