#pragma once

#include <algorithm>
#include <array>
#include <map>
#include <utility>
#include <vector>

#include "common/triangle_mesh.hpp"

namespace marco::testing {

struct Wholeness {
  double open_m = 0.0;      ///< length of the edges of one triangle
  std::size_t of_more = 0;  ///< number of the edges of more than two
};

/// Edges are between places: vertices at the same one count as one. Triangles of two places only
/// have none.
inline Wholeness wholeness(const TriangleMesh& mesh) {
  std::map<std::array<float, 3>, uint32_t> numbers;
  std::vector<uint32_t> number_of;
  for (const Eigen::Vector3f& p : mesh.vertices_m) {
    const auto next = static_cast<uint32_t>(numbers.size());
    number_of.push_back(numbers.try_emplace({p.x(), p.y(), p.z()}, next).first->second);
  }
  struct Edge {
    uint32_t from, to;
    float length_m;
    bool operator<(const Edge& other) const {
      return std::pair(from, to) < std::pair(other.from, other.to);
    }
  };
  std::vector<Edge> edges;
  for (const auto& triangle : mesh.triangles) {
    for (std::size_t side = 0; side < 3; ++side) {
      const uint32_t a = triangle[side], b = triangle[(side + 1) % 3];
      if (number_of[a] == number_of[b]) continue;
      const auto [from, to] = std::minmax(number_of[a], number_of[b]);
      edges.push_back({from, to, (mesh.vertices_m[a] - mesh.vertices_m[b]).norm()});
    }
  }
  std::sort(edges.begin(), edges.end());
  Wholeness found;
  for (auto first = edges.begin(); first != edges.end();) {
    const auto after = std::upper_bound(first, edges.end(), *first);
    if (after - first == 1) found.open_m += static_cast<double>(first->length_m);
    if (after - first > 2) ++found.of_more;
    first = after;
  }
  return found;
}

}  // namespace marco::testing
