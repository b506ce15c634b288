#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "slam/map/keyframe.hpp"

namespace marco::slam {

/// What a keyframe's own beams say of a point.
enum class Seen : uint8_t {
  nothing,  ///< no beam passes near, or the point lies behind what the beam hit
  as_wall,  ///< within 0.15 m of the line of the wall hit there
  as_free   ///< more than 0.3 m in front of all that the beams around hit
};

/// The free space that one keyframe saw: ranges by bearing from where its beams came from. Memory:
/// 4 kB. Const members are safe from several threads.
class RangeView {
 public:
  /// @param key  outlives the view.
  explicit RangeView(const Keyframe& key);

  Seen look_at(const Eigen::Vector2d& point_in_robot) const;

 private:
  static constexpr int kBins = 720;
  int bin_of(const Eigen::Vector2d& ray) const;
  void add_beams();
  void widen();

  const Keyframe* key_;
  std::array<float, kBins> free_m_{};  ///< 0: no beam
  std::array<int16_t, kBins> hit_{};   ///< a point of the keyframe, -1: none
};

}  // namespace marco::slam
