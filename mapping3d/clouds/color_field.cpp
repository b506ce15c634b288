#include "mapping3d/clouds/color_field.hpp"

#include <cmath>

namespace marco::mapping3d {
namespace {

constexpr std::array<uint8_t, 3> kUnseen{160, 160, 160};

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
  for (std::size_t i = 0; i < mesh.vertices_m.size(); ++i) {
    const Cell cell = cell_of(mesh.vertices_m[i]);
    const Sum* own = sums_.find_voxel(cell);
    const Sum sum = own != nullptr && own->count > 0.0F ? *own : around(cell);
    if (sum.count <= 0.0F) continue;
    for (std::size_t channel = 0; channel < 3; ++channel) {
      mesh.colors_rgb[i][channel] = static_cast<uint8_t>(std::lround(sum.rgb[channel] / sum.count));
    }
  }
}

}  // namespace marco::mapping3d
