#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "mapping3d/scene.hpp"

namespace marco::mapping3d {

/// Where each parameter stands in the vector of unknowns: rows of all scenes, six of each body, the
/// range offset.
class StraighteningUnknowns {
 public:
  StraighteningUnknowns(const std::vector<Scene>& scenes, const std::vector<std::size_t>& body_of) {
    for (const Scene& scene : scenes) {
      first_row_.push_back(count_);
      count_ += scene.rows.size();
    }
    for (std::size_t i = 0; i < scenes.size(); ++i) {
      body_of_.push_back(body_of.empty() ? i : body_of[i]);
      bodies_ = std::max(bodies_, body_of_[i] + 1);
    }
    first_body_ = count_;
    count_ += 6 * bodies_ + 1;
  }

  std::size_t row(std::size_t scene, std::size_t row) const { return first_row_[scene] + row; }
  std::size_t body_of(std::size_t scene) const { return body_of_[scene]; }
  std::size_t bodies() const { return bodies_; }
  /// Three turns, then three shifts.
  std::size_t body(std::size_t body) const { return first_body_ + 6 * body; }
  std::size_t range() const { return count_ - 1; }
  std::size_t count() const { return count_; }

 private:
  std::vector<std::size_t> first_row_;  ///< of each scene
  std::vector<std::size_t> body_of_;
  std::size_t bodies_ = 0;
  std::size_t first_body_ = 0;
  std::size_t count_ = 0;
};

}  // namespace marco::mapping3d
