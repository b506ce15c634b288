#pragma once

#include <cstdint>
#include <numeric>
#include <vector>

namespace marco::mapping3d {

/// Vertices that triangles join to islands: a union-find structure with path halving.
class Islands {
 public:
  explicit Islands(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), 0U);
  }

  /// The vertex that stands for all of the island; another one after a join().
  uint32_t root(uint32_t of) {
    while (parent_[of] != of) of = parent_[of] = parent_[parent_[of]];
    return of;
  }
  void join(uint32_t a, uint32_t b) { parent_[root(a)] = root(b); }

 private:
  std::vector<uint32_t> parent_;
};

}  // namespace marco::mapping3d
