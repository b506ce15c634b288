#include "mapping3d/surface/facets.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace marco::mapping3d {
namespace {

class Facets {
 public:
  Facets(const SmoothScene& scene, const FacetOptions& options)
      : scene_(scene),
        plane_gap_m_(static_cast<float>(options.plane_gap_m)),
        plane_share_(static_cast<float>(options.plane_gap_share)),
        max_edge_m_(static_cast<float>(options.max_edge_m)),
        corner_factor_(static_cast<float>(options.corner_factor)),
        corner_floor_m_(static_cast<float>(options.corner_floor_m)),
        max_corner_m_(static_cast<float>(options.max_corner_m)),
        max_loose_m_(static_cast<float>(options.max_loose_m)),
        loose_factor_(static_cast<float>(options.loose_factor)),
        loose_floor_m_(static_cast<float>(options.loose_floor_m)) {
    validate(options, "facets");
    measure();
  }

  std::vector<std::array<uint32_t, 3>> run() {
    for (std::size_t row = 0; row + 1 < scene_.rows; ++row) {
      for (std::size_t column = 0; column + 1 < scene_.columns; ++column) {
        const auto at = static_cast<uint32_t>(row * scene_.columns + column);
        const auto below = static_cast<uint32_t>(at + scene_.columns);
        add_quad({at, at + 1, below + 1, below});
      }
    }
    return std::move(triangles_);
  }

 private:
  bool there(uint32_t i) const { return scene_.kinds[i] != SmoothScene::Kind::none; }
  bool on_plane(uint32_t i) const { return scene_.kinds[i] == SmoothScene::Kind::plane; }

  // Ranges, and the mean angle between diagonal neighbours.
  void measure() {
    ranges_m_.resize(scene_.points_m.size(), 0.0F);
    std::vector<Eigen::Vector3f> beams(scene_.points_m.size(), Eigen::Vector3f::Zero());
    for (std::size_t i = 0; i < ranges_m_.size(); ++i) {
      if (scene_.kinds[i] == SmoothScene::Kind::none) continue;
      const Eigen::Vector3f beam = scene_.points_m[i] - scene_.origins_m[i / scene_.columns];
      ranges_m_[i] = beam.norm();
      beams[i] = beam / std::max(1e-6F, ranges_m_[i]);
    }
    double sum = 0.0;
    int count = 0;
    for (std::size_t row = 0; row + 1 < scene_.rows; ++row) {
      for (std::size_t column = 0; column + 1 < scene_.columns; ++column) {
        const std::size_t a = row * scene_.columns + column, b = a + scene_.columns + 1;
        if (ranges_m_[a] <= 0.0F || ranges_m_[b] <= 0.0F) continue;
        sum += static_cast<double>((beams[a] - beams[b]).norm());
        ++count;
      }
    }
    spacing_rad_ = count > 0 ? static_cast<float>(sum / count) : 0.0F;
  }

  bool joined(uint32_t a, uint32_t b) const {
    const Eigen::Vector3f edge = scene_.points_m[b] - scene_.points_m[a];
    const float length2 = edge.squaredNorm();
    const float spacing_m = spacing_rad_ * std::min(ranges_m_[a], ranges_m_[b]);
    const bool planes = on_plane(a) && on_plane(b);
    const float near_m = planes ? corner_floor_m_ + spacing_m * corner_factor_
                                : loose_floor_m_ + spacing_m * loose_factor_;
    const float max_m = planes ? max_corner_m_ : max_loose_m_;
    if (length2 <= std::min(near_m * near_m, max_m * max_m)) return true;
    if (!planes || length2 > max_edge_m_ * max_edge_m_) return false;
    // Twice the noise: two windows of one plane, far away or at a slant, differ by as much.
    const float noise_m = 2.0F * std::hypot(scene_.sigmas_m[a], scene_.sigmas_m[b]);
    const float gap_m = plane_gap_m_ + plane_share_ * std::sqrt(length2) + noise_m;
    return std::abs(scene_.normals[a].dot(edge)) <= gap_m &&
           std::abs(scene_.normals[b].dot(edge)) <= gap_m;
  }

  void add_quad(const std::array<uint32_t, 4>& quad) {
    const int count = there(quad[0]) + there(quad[1]) + there(quad[2]) + there(quad[3]);
    if (count < 3) return;
    if (count == 3) {
      std::array<uint32_t, 3> triangle{};
      std::size_t next = 0;
      for (const uint32_t corner : quad) {
        if (there(corner)) triangle[next++] = corner;
      }
      add_triangle(triangle);
      return;
    }
    const auto& p = scene_.points_m;
    if ((p[quad[0]] - p[quad[2]]).squaredNorm() <= (p[quad[1]] - p[quad[3]]).squaredNorm()) {
      add_triangle({quad[0], quad[1], quad[2]});
      add_triangle({quad[0], quad[2], quad[3]});
    } else {
      add_triangle({quad[0], quad[1], quad[3]});
      add_triangle({quad[1], quad[2], quad[3]});
    }
  }

  void add_triangle(std::array<uint32_t, 3> t) {
    if (!joined(t[0], t[1]) || !joined(t[1], t[2]) || !joined(t[2], t[0])) return;
    const auto& p = scene_.points_m;
    const Eigen::Vector3f normal = (p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]);
    if (!(normal.squaredNorm() > 0.0F)) return;
    if (normal.dot(p[t[0]] - scene_.origins_m[t[0] / scene_.columns]) > 0.0F) {
      std::swap(t[1], t[2]);
    }
    triangles_.push_back(t);
  }

  const SmoothScene& scene_;
  float plane_gap_m_, plane_share_, max_edge_m_;
  float corner_factor_, corner_floor_m_, max_corner_m_, max_loose_m_, loose_factor_, loose_floor_m_;
  float spacing_rad_ = 0.0F;
  std::vector<float> ranges_m_;
  std::vector<std::array<uint32_t, 3>> triangles_;
};

}  // namespace

std::vector<std::array<uint32_t, 3>> facets(const SmoothScene& scene, const FacetOptions& options) {
  return Facets(scene, options).run();
}

}  // namespace marco::mapping3d
