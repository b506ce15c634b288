#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "mapping3d/scene.hpp"

namespace marco::testing {

/// What a return is of, judged by its neighbours in the sweep alone.
enum class ReturnClass : uint8_t {
  none,
  alone,    ///< no two neighbours near it: dust, the outdoors through a window, mixed ranges
  between,  ///< on the way from what is before an edge to what is behind it: a mixed range
  flat,     ///< its neighbourhood is a plane
  steep,    ///< likewise, seen at over 75 deg
  rough,    ///< the others: furniture, plants, edges
};
constexpr std::array<const char*, 6> kReturnClasses = {"none", "alone", "between",
                                                       "flat", "steep", "rough"};

class ReturnClasses {
 public:
  explicit ReturnClasses(const mapping3d::ScenePoints& scene) : scene_(scene) {
    ranges_m_.resize(scene.points_m.size(), 0.0F);
    beams_.resize(ranges_m_.size(), Eigen::Vector3f::Zero());
    for (std::size_t i = 0; i < ranges_m_.size(); ++i) {
      if (scene.valid[i] == 0) continue;
      const Eigen::Vector3f way = scene.points_m[i] - scene.origins_m[i / scene.columns];
      ranges_m_[i] = way.norm();
      beams_[i] = way / ranges_m_[i];
    }
  }

  float range_m(std::size_t i) const { return ranges_m_[i]; }

  ReturnClass operator()(std::size_t row, std::size_t column) const {
    const std::size_t i = scene_.index(row, column);
    if (ranges_m_[i] <= 0.0F) return ReturnClass::none;
    if (is_between(i, column, scene_.columns, 1) ||
        is_between(i, row, scene_.rows, scene_.columns)) {
      return ReturnClass::between;
    }
    std::vector<std::pair<float, Eigen::Vector3f>> near;
    int beside = 0;
    const auto y = static_cast<int>(row), x = static_cast<int>(column);
    for (int v = std::max(0, y - 4); v <= std::min(static_cast<int>(scene_.rows) - 1, y + 4); ++v) {
      for (int u = std::max(0, x - 4); u <= std::min(static_cast<int>(scene_.columns) - 1, x + 4);
           ++u) {
        const std::size_t j =
            scene_.index(static_cast<std::size_t>(v), static_cast<std::size_t>(u));
        if (ranges_m_[j] <= 0.0F) continue;
        near.emplace_back((scene_.points_m[j] - scene_.points_m[i]).norm(), scene_.points_m[j]);
        if (j == i || std::abs(v - y) > 1 || std::abs(u - x) > 1) continue;
        const float step = (beams_[j] - beams_[i]).norm();
        if (near.back().first < kNearM + kNearSteps * step * ranges_m_[i]) ++beside;
      }
    }
    if (beside < 2 || near.size() < kPlane) return ReturnClass::alone;
    return of_plane(i, near);
  }

 private:
  static constexpr std::size_t kPlane = 16;
  static constexpr float kNearM = 0.05F, kNearSteps = 4.0F;

  bool is_between(std::size_t i, std::size_t at, std::size_t end, std::size_t stride) const {
    if (at < 2 || at + 2 >= end) return false;
    std::array<float, 5> r{};
    for (std::size_t k = 0; k < 5; ++k) {
      r[k] = ranges_m_[i + k * stride - 2 * stride];
      if (r[k] <= 0.0F) return false;
    }
    const float jump = r[3] - r[1], flank = 0.4F * std::abs(jump);
    const float step = (beams_[i + stride] - beams_[i - stride]).norm();
    return std::abs(jump) > 0.1F + 3.0F * step * std::min(r[1], r[3]) &&
           (r[2] - r[1]) * jump > 0.15F * jump * jump &&
           (r[3] - r[2]) * jump > 0.15F * jump * jump && std::abs(r[1] - r[0]) < flank &&
           std::abs(r[4] - r[3]) < flank;
  }

  ReturnClass of_plane(std::size_t i, std::vector<std::pair<float, Eigen::Vector3f>>& near) const {
    std::nth_element(near.begin(), near.begin() + kPlane - 1, near.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    Eigen::Vector3f mean = Eigen::Vector3f::Zero();
    for (std::size_t k = 0; k < kPlane; ++k) mean += near[k].second / kPlane;
    Eigen::Matrix3f spread = Eigen::Matrix3f::Zero();
    for (std::size_t k = 0; k < kPlane; ++k) {
      spread += (near[k].second - mean) * (near[k].second - mean).transpose() / kPlane;
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> axes(spread);
    const Eigen::Vector3f values = axes.eigenvalues(), normal = axes.eigenvectors().col(0);
    const bool flat = std::sqrt(std::max(0.0F, values[0])) < 0.02F && values[1] > 4.0F * values[0];
    if (!flat) return ReturnClass::rough;
    return std::abs(normal.dot(beams_[i])) < std::cos(75.0F * 3.14159265F / 180.0F)
               ? ReturnClass::steep
               : ReturnClass::flat;
  }

  const mapping3d::ScenePoints& scene_;
  std::vector<float> ranges_m_;
  std::vector<Eigen::Vector3f> beams_;
};

}  // namespace marco::testing
