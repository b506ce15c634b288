#include "mapping3d/thesis_mesh.hpp"

namespace marco::mapping3d {
namespace {

class ThesisRule {
 public:
  ThesisRule(const ScenePoints& scene, const ThesisMeshOptions& options)
      : scene_(scene),
        min2_(static_cast<float>(options.min_edge_m * options.min_edge_m)),
        max2_(static_cast<float>(options.max_edge_m * options.max_edge_m)) {
    validate(options, "thesis_mesh");
  }
  template <std::size_t N>
  bool allows(const std::array<uint32_t, N>& polygon) const {
    if (scene_.valid[polygon[0]] == 0) return false;
    for (std::size_t i = 1; i < N; ++i) {
      if (scene_.valid[polygon[i]] == 0) return false;
      const float length2 =
          (scene_.points_m[polygon[i]] - scene_.points_m[polygon[0]]).squaredNorm();
      if (length2 < min2_ || length2 > max2_) return false;
    }
    return true;
  }

 private:
  const ScenePoints& scene_;
  float min2_;
  float max2_;
};

template <class Visit>
void for_each_quad(const ScenePoints& scene, const Visit& visit) {
  for (std::size_t row = 0; row + 1 < scene.rows; ++row) {
    for (std::size_t column = 0; column + 1 < scene.columns; ++column) {
      const auto at = static_cast<uint32_t>(scene.index(row, column));
      const auto below = static_cast<uint32_t>(scene.index(row + 1, column));
      visit(std::array<uint32_t, 4>{at, at + 1, below + 1, below});
    }
  }
}

}  // namespace

std::vector<std::array<uint32_t, 4>> thesis_quads(const ScenePoints& scene,
                                                  const ThesisMeshOptions& options) {
  const ThesisRule rule(scene, options);
  std::vector<std::array<uint32_t, 4>> quads;
  for_each_quad(scene, [&](const std::array<uint32_t, 4>& quad) {
    if (rule.allows(quad)) quads.push_back(quad);
  });
  return quads;
}

std::vector<std::array<uint32_t, 3>> thesis_triangles(const ScenePoints& scene,
                                                      const ThesisMeshOptions& options) {
  const ThesisRule rule(scene, options);
  std::vector<std::array<uint32_t, 3>> triangles;
  for_each_quad(scene, [&](const std::array<uint32_t, 4>& quad) {
    const std::array<uint32_t, 3> first{quad[0], quad[1], quad[2]};
    const std::array<uint32_t, 3> second{quad[0], quad[2], quad[3]};
    if (rule.allows(first)) triangles.push_back(first);
    if (rule.allows(second)) triangles.push_back(second);
  });
  return triangles;
}

}  // namespace marco::mapping3d
