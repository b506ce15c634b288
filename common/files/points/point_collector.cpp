#include "common/files/points/point_collector.hpp"

namespace marco::files {
namespace {

// A float still resolves a millimetre there; no building is larger.
constexpr double kFarM = 10e3;

}  // namespace

PointCollector::PointCollector(std::optional<Eigen::Vector3d> origin_m) {
  if (!origin_m) return;
  cloud.origin_m = *origin_m;
  has_origin_ = true;
}

void PointCollector::reserve(std::size_t points, Parts more) {
  cloud.points_m.reserve(points);
  if (more.intensities) cloud.intensities.reserve(points);
  if (more.colors) cloud.colors_rgb.reserve(points);
}

void PointCollector::add(const Eigen::Vector3d& point_m) {
  const bool is_far = point_m.cwiseAbs().maxCoeff() > kFarM;
  if (!first_m_ && point_m.allFinite()) {
    first_m_ = point_m.array().round().matrix();
    if (is_far && !has_origin_) {
      cloud.origin_m = *first_m_;
      has_origin_ = true;
    }
  }
  is_far_ = is_far_ || (is_far && point_m.allFinite());
  cloud.points_m.push_back((point_m - cloud.origin_m).cast<float>());
}

std::optional<Eigen::Vector3d> PointCollector::better_origin_m() const {
  return is_far_ && !has_origin_ ? first_m_ : std::nullopt;
}

}  // namespace marco::files
