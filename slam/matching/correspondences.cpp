#include "slam/matching/correspondences.hpp"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

namespace marco::slam {
namespace {

using Float4 = float __attribute__((vector_size(16)));
constexpr std::size_t kLanes = 4;

Float4 load(const float* values) {
  Float4 result;
  std::memcpy(&result, values, sizeof result);
  return result;
}

double sum_of(const Float4& v) {
  return (static_cast<double>(v[0]) + static_cast<double>(v[1])) +
         (static_cast<double>(v[2]) + static_cast<double>(v[3]));
}

// A pose as floats.
struct Placement {
  explicit Placement(const Pose2& pose)
      : c(static_cast<float>(std::cos(pose.theta_rad))),
        s(static_cast<float>(std::sin(pose.theta_rad))),
        x(static_cast<float>(pose.x_m)),
        y(static_cast<float>(pose.y_m)) {}
  float c, s, x, y;
};

}  // namespace

Correspondences::Correspondences(const OrientedPoints& points, Eigen::Index every_nth)
    : count_(static_cast<int>((points.points.cols() + every_nth - 1) / every_nth)) {
  const std::size_t padded = (static_cast<std::size_t>(count_) + kLanes - 1) / kLanes * kLanes;
  for (std::vector<float>* values :
       {&x_m_, &y_m_, &normal_x_, &normal_y_, &wall_x_, &wall_y_, &wall_offset_m_}) {
    values->resize(padded, 0.0F);
  }
  for (std::size_t i = 0; i < static_cast<std::size_t>(count_); ++i) {
    const Eigen::Index from = static_cast<Eigen::Index>(i) * every_nth;
    x_m_[i] = static_cast<float>(points.points(0, from));
    y_m_[i] = static_cast<float>(points.points(1, from));
    normal_x_[i] = static_cast<float>(points.normals(0, from));
    normal_y_[i] = static_cast<float>(points.normals(1, from));
  }
}

void Correspondences::associate(const SurfelMap& map, const Pose2& centre_from_robot) {
  const Placement at(centre_from_robot);
  matched_ = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(count_); ++i) {
    const Eigen::Vector2f point(at.c * x_m_[i] - at.s * y_m_[i] + at.x,
                                at.s * x_m_[i] + at.c * y_m_[i] + at.y);
    const Eigen::Vector2f normal(at.c * normal_x_[i] - at.s * normal_y_[i],
                                 at.s * normal_x_[i] + at.c * normal_y_[i]);
    const WallLine line = map.line_near(point, normal);
    wall_x_[i] = line.nx;
    wall_y_[i] = line.ny;
    wall_offset_m_[i] = line.offset_m;
    matched_ += line.nx != 0.0F || line.ny != 0.0F ? 1 : 0;
  }
}

NormalSums Correspondences::sum(const Pose2& centre_from_robot, double sigma_m) const {
  const Placement at(centre_from_robot);
  const auto half_per_sigma2 = static_cast<float>(0.5 / (sigma_m * sigma_m));
  Float4 xx = {}, xy = {}, xt = {}, yy = {}, yt = {}, tt = {}, bx = {}, by = {}, bt = {};
  Float4 weights = {};
  for (std::size_t i = 0; i < x_m_.size(); i += kLanes) {
    const Float4 px = load(&x_m_[i]), py = load(&y_m_[i]);
    const Float4 nx = load(&wall_x_[i]), ny = load(&wall_y_[i]);
    const Float4 arm_x = at.c * px - at.s * py, arm_y = at.s * px + at.c * py;
    const Float4 error = nx * (arm_x + at.x) + ny * (arm_y + at.y) - load(&wall_offset_m_[i]);
    const Float4 weight = 1.0F / (1.0F + half_per_sigma2 * error * error);
    const Float4 lever = ny * arm_x - nx * arm_y;
    const Float4 wx = weight * nx, wy = weight * ny, wt = weight * lever;
    weights += weight;
    xx += wx * nx;
    xy += wx * ny;
    xt += wx * lever;
    yy += wy * ny;
    yt += wy * lever;
    tt += wt * lever;
    bx += wx * error;
    by += wy * error;
    bt += wt * error;
  }
  NormalSums sums;
  sums.xx = sum_of(xx);
  sums.xy = sum_of(xy);
  sums.xt = sum_of(xt);
  sums.yy = sum_of(yy);
  sums.yt = sum_of(yt);
  sums.tt = sum_of(tt);
  sums.bx = sum_of(bx);
  sums.by = sum_of(by);
  sums.bt = sum_of(bt);
  sums.weights =
      sum_of(weights) - static_cast<double>(x_m_.size() - static_cast<std::size_t>(count_));
  return sums;
}

void Correspondences::distances_m(const Pose2& centre_from_robot,
                                  std::vector<float>& result) const {
  const Placement at(centre_from_robot);
  result.resize(static_cast<std::size_t>(count_));
  for (std::size_t i = 0; i < result.size(); ++i) {
    const float arm_x = at.c * x_m_[i] - at.s * y_m_[i], arm_y = at.s * x_m_[i] + at.c * y_m_[i];
    const bool matched = wall_x_[i] != 0.0F || wall_y_[i] != 0.0F;
    result[i] = matched
                    ? wall_x_[i] * (arm_x + at.x) + wall_y_[i] * (arm_y + at.y) - wall_offset_m_[i]
                    : std::numeric_limits<float>::quiet_NaN();
  }
}

}  // namespace marco::slam
