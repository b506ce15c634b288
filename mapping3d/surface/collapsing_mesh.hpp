#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

namespace marco::mapping3d {

/// Triangles whose vertices can be moved onto a neighbour (half-edge collapse, Kobbelt and others
/// 1998), one after another, while the topology stays: borders stay borders, no edge gets more
/// triangles than it had, no hole closes and no piece vanishes. Numbers of triangles and vertices
/// do not change.
class CollapsingMesh {
 public:
  using Triangle = std::array<uint32_t, 3>;

  /// @param triangles  of three vertices each; one of fewer is gone from the start
  CollapsingMesh(std::vector<Triangle> triangles, std::size_t vertices);

  const std::vector<Triangle>& triangles() const { return triangles_; }
  bool is_gone(std::size_t triangle) const { return triangles_[triangle][0] == kNone; }
  /// Whether no triangle has it.
  bool is_alone(uint32_t vertex) const { return first_[vertex] == kNone; }

  /// Those of a vertex, in no order.
  template <class Visit>
  void for_each_triangle_of(uint32_t vertex, const Visit& visit) const {
    for (uint32_t corner = first_[vertex]; corner != kNone; corner = next_[corner]) {
      visit(corner / 3);
    }
  }

  /// How many an edge has.
  std::size_t triangles_between(uint32_t a, uint32_t b) const;

  /// Vertices that share an edge with this one, each once, in no order.
  void neighbours(uint32_t vertex, std::vector<uint32_t>& found);

  /// Whether a vertex lies on no edge of more than two triangles, and surfaces do not touch in it.
  bool can_ever_move(uint32_t vertex) const { return kinds_[vertex] != Kind::fixed; }

  bool is_on_border(uint32_t vertex) const { return kinds_[vertex] == Kind::border; }

  /// Whether a vertex can be moved onto a neighbour: it `can_ever_move`; on a border only along
  /// that; and both have in common just the neighbours that are corners of their edge's triangles
  /// (link condition; Dey and others 1999).
  bool can_move(uint32_t vertex, uint32_t onto);

  /// Only what `can_move`.
  void move(uint32_t vertex, uint32_t onto);

 private:
  enum class Kind : uint8_t { inner, border, fixed };
  static constexpr uint32_t kNone = ~0U;

  Kind kind_of(uint32_t vertex);
  /// Numbers of triangles that a vertex has in common with each of its neighbours, in `shared_`.
  void count_shared(uint32_t vertex);
  bool has_triangle(uint32_t vertex, uint32_t b, uint32_t c) const;
  void unlink(uint32_t vertex, uint32_t corner);

  std::vector<Triangle> triangles_;
  std::vector<uint32_t> first_;  ///< of a vertex' corners; a triangle t has 3 t to 3 t + 2 ...
  std::vector<uint32_t> next_;   ///< ... and the one after each
  std::vector<Kind> kinds_;      ///< of vertices; moving others does not change them
  std::vector<uint32_t> marks_;  ///< of vertices, with `mark_`: whether `shared_` is of now
  std::vector<uint32_t> shared_;
  uint32_t mark_ = 0;
  std::vector<std::pair<uint32_t, uint32_t>> opposite_;  ///< edges, of kind_of()
};

}  // namespace marco::mapping3d
