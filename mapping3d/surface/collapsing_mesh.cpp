#include "mapping3d/surface/collapsing_mesh.hpp"

#include <algorithm>
#include <utility>

namespace marco::mapping3d {

CollapsingMesh::CollapsingMesh(std::vector<Triangle> triangles, std::size_t vertices)
    : triangles_(std::move(triangles)),
      first_(vertices, kNone),
      next_(3 * triangles_.size(), kNone),
      marks_(vertices, 0),
      shared_(vertices, 0) {
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    Triangle& triangle = triangles_[t];
    const auto [a, b, c] = triangle;
    if (a == b || b == c || c == a) {
      triangle.fill(kNone);
      continue;
    }
    for (std::size_t k = 0; k < 3; ++k) {
      const auto corner = static_cast<uint32_t>(3 * t + k);
      next_[corner] = std::exchange(first_[triangle[k]], corner);
    }
  }
  kinds_.reserve(vertices);
  for (std::size_t i = 0; i < vertices; ++i) kinds_.push_back(kind_of(static_cast<uint32_t>(i)));
}

void CollapsingMesh::count_shared(uint32_t vertex) {
  ++mark_;
  for_each_triangle_of(vertex, [&](uint32_t t) {
    for (const uint32_t corner : triangles_[t]) {
      if (std::exchange(marks_[corner], mark_) != mark_) shared_[corner] = 0;
      ++shared_[corner];
    }
  });
}

void CollapsingMesh::neighbours(uint32_t vertex, std::vector<uint32_t>& found) {
  found.clear();
  ++mark_;
  marks_[vertex] = mark_;
  for_each_triangle_of(vertex, [&](uint32_t t) {
    for (const uint32_t corner : triangles_[t]) {
      if (std::exchange(marks_[corner], mark_) != mark_) found.push_back(corner);
    }
  });
}

// Around an inner vertex is one ring of triangles, around one on a border one strip of them; any
// other is left where it is.
CollapsingMesh::Kind CollapsingMesh::kind_of(uint32_t vertex) {
  if (is_alone(vertex)) return Kind::fixed;
  count_shared(vertex);
  std::size_t triangles = 0, rims = 0, more = 0;
  std::vector<std::pair<uint32_t, uint32_t>>& opposite = opposite_;
  opposite.clear();
  for_each_triangle_of(vertex, [&](uint32_t t) {
    const Triangle& triangle = triangles_[t];
    const std::size_t k = static_cast<std::size_t>(
        std::find(triangle.begin(), triangle.end(), vertex) - triangle.begin());
    opposite.emplace_back(triangle[(k + 1) % 3], triangle[(k + 2) % 3]);
    ++triangles;
    for (const uint32_t corner : triangle) {
      if (corner == vertex) continue;
      rims += shared_[corner] == 1 ? 1 : 0;
      more += shared_[corner] > 2 ? 1 : 0;
    }
  });
  if (more > 0) return Kind::fixed;
  // Walks from triangle to triangle, from the strip's beginning if there is one.
  uint32_t at = opposite.front().first;
  for (const auto& [from, to] : opposite) {
    if (shared_[from] == 1) at = from;
  }
  std::size_t walked = 0;
  for (; walked < triangles; ++walked) {
    const auto next = std::find_if(opposite.begin(), opposite.end(),
                                   [at](const auto& edge) { return edge.first == at; });
    if (next == opposite.end()) break;
    at = next->second;
    opposite.erase(next);
  }
  if (walked < triangles) return Kind::fixed;
  return rims == 0 ? Kind::inner : Kind::border;
}

std::size_t CollapsingMesh::triangles_between(uint32_t a, uint32_t b) const {
  std::size_t count = 0;
  for_each_triangle_of(a, [&](uint32_t t) {
    const Triangle& triangle = triangles_[t];
    count += std::find(triangle.begin(), triangle.end(), b) != triangle.end() ? 1 : 0;
  });
  return count;
}

bool CollapsingMesh::has_triangle(uint32_t vertex, uint32_t b, uint32_t c) const {
  bool found = false;
  for_each_triangle_of(vertex, [&](uint32_t t) {
    const Triangle& triangle = triangles_[t];
    found = found || (std::find(triangle.begin(), triangle.end(), b) != triangle.end() &&
                      std::find(triangle.begin(), triangle.end(), c) != triangle.end());
  });
  return found;
}

bool CollapsingMesh::can_move(uint32_t vertex, uint32_t onto) {
  if (kinds_[vertex] == Kind::fixed) return false;
  count_shared(vertex);
  const uint32_t of_edge = marks_[onto] == mark_ ? shared_[onto] : 0;
  if (of_edge != (kinds_[vertex] == Kind::border ? 1U : 2U)) return false;
  // Each triangle of the edge has one neighbour of both; others would get two triangles more.
  std::array<uint32_t, 2> corners{kNone, kNone};
  uint32_t common = 0;
  for_each_triangle_of(onto, [&](uint32_t t) {
    for (const uint32_t corner : triangles_[t]) {
      if (corner == vertex || corner == onto || marks_[corner] != mark_) continue;
      marks_[corner] = 0;  // counted
      if (common < 2) corners[common] = corner;
      ++common;
    }
  });
  if (common != of_edge) return false;
  // What only consists of the triangles of the edge would vanish, and what closes behind it too.
  std::size_t triangles = 0;
  for_each_triangle_of(vertex, [&](uint32_t /*t*/) { ++triangles; });
  if (of_edge == 2) {
    return triangles > 3 || (triangles == 3 && !has_triangle(onto, corners[0], corners[1]));
  }
  if (triangles > 1) return true;
  // An ear is cut off when another triangle holds its edge.
  return triangles_between(onto, corners[0]) > 1;
}

void CollapsingMesh::unlink(uint32_t vertex, uint32_t corner) {
  uint32_t* link = &first_[vertex];
  while (*link != corner) link = &next_[*link];
  *link = next_[corner];
}

void CollapsingMesh::move(uint32_t vertex, uint32_t onto) {
  for (uint32_t corner = std::exchange(first_[vertex], kNone); corner != kNone;) {
    const uint32_t next = next_[corner];
    Triangle& triangle = triangles_[corner / 3];
    if (std::find(triangle.begin(), triangle.end(), onto) == triangle.end()) {
      triangle[corner % 3] = onto;
      next_[corner] = std::exchange(first_[onto], corner);
    } else {
      const uint32_t first = corner - corner % 3;
      for (uint32_t k = 0; k < 3; ++k) {
        if (triangle[k] != vertex) unlink(triangle[k], first + k);
      }
      triangle.fill(kNone);
    }
    corner = next;
  }
}

}  // namespace marco::mapping3d
