#include "slam/matching/surfel_map.hpp"

#include <cmath>

#include "common/check.hpp"

namespace marco::slam {
namespace {

// Faces of one wall piece differ by less; the two faces of a thin wall and the walls of a corner by
// more.
constexpr float kSameFacing = 0.80F;

}  // namespace

SurfelMap::SurfelMap(const Eigen::Vector2d& centre_m, double half_width_m, double cell_m)
    : centre_m_(centre_m),
      cell_m_(cell_m),
      half_width_m_(static_cast<float>(half_width_m)),
      inverse_cell_(static_cast<float>(1.0 / cell_m)),
      width_(static_cast<int>(std::ceil(2.0 * half_width_m / cell_m)) + 2) {
  require(cell_m > 0.0 && half_width_m > 0.0 && half_width_m / cell_m < 5000.0,
          "SurfelMap: cell and width must be above 0, with fewer than 10000 cells a side");
  first_.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(width_), -1);
}

void SurfelMap::add(const OrientedPoints& points, const Pose2& map_from_points) {
  const Eigen::Matrix2d turn = map_from_points.rotation();
  const Eigen::Vector2d shift = map_from_points.translation_m() - centre_m_;
  for (Eigen::Index i = 0; i < points.points.cols(); ++i) {
    if (!points.has_normal(i)) continue;
    const Eigen::Vector2f point = (turn * points.points.col(i) + shift).cast<float>();
    if (!(point.cwiseAbs().maxCoeff() < half_width_m_)) continue;
    add_point(point, (turn * points.normals.col(i)).cast<float>());
  }
}

void SurfelMap::add_point(const Eigen::Vector2f& point_m, const Eigen::Vector2f& normal) {
  const int x = static_cast<int>((point_m.x() + half_width_m_) * inverse_cell_);
  const int y = static_cast<int>((point_m.y() + half_width_m_) * inverse_cell_);
  int32_t* link = &first_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                          static_cast<std::size_t>(x)];
  while (*link >= 0) {
    Surfel& surfel = surfels_[static_cast<std::size_t>(*link)];
    if (surfel.normal.dot(normal) > kSameFacing) {
      const float part = 1.0F / (surfel.weight + 1.0F);
      surfel.mean_m += part * (point_m - surfel.mean_m);
      surfel.normal = (surfel.normal * surfel.weight + normal).normalized();
      surfel.weight += 1.0F;
      return;
    }
    link = &surfel.next;
  }
  *link = static_cast<int32_t>(surfels_.size());
  surfels_.push_back({point_m, normal, 1.0F, -1});
}

const Surfel* SurfelMap::find(const Eigen::Vector2f& point_m, const Eigen::Vector2f& normal) const {
  if (!(point_m.cwiseAbs().maxCoeff() < half_width_m_)) return nullptr;
  // The four cells whose centres surround the point.
  const int x0 = static_cast<int>((point_m.x() + half_width_m_) * inverse_cell_ - 0.5F);
  const int y0 = static_cast<int>((point_m.y() + half_width_m_) * inverse_cell_ - 0.5F);
  const bool any_normal = normal.x() == 0.0F && normal.y() == 0.0F;
  const Surfel* best = nullptr;
  auto best_distance2 = static_cast<float>(cell_m_ * cell_m_);
  for (int y = y0; y <= y0 + 1; ++y) {
    for (int x = x0; x <= x0 + 1; ++x) {
      int32_t index = first_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                             static_cast<std::size_t>(x)];
      while (index >= 0) {
        const Surfel& surfel = surfels_[static_cast<std::size_t>(index)];
        index = surfel.next;
        const float distance2 = (point_m - surfel.mean_m).squaredNorm();
        if (distance2 >= best_distance2) continue;
        if (!any_normal && surfel.normal.dot(normal) < kSameFacing) continue;
        best = &surfel;
        best_distance2 = distance2;
      }
    }
  }
  return best;
}

}  // namespace marco::slam
