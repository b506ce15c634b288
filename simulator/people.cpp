#include "simulator/people.hpp"

#include <algorithm>
#include <cmath>

#include "lcm_tools/base/check.hpp"

namespace marco::sim {
namespace {

constexpr double kStrideM = 1.3;  // from a foothold to the same foot's next
constexpr double kHalfHipsM = 0.1;

}  // namespace

std::optional<double> range_to_leg(const Leg& leg,
                                   const Eigen::Vector3d& origin_m,
                                   const Eigen::Vector3d& direction) {
  // |p + t d| = r on the floor plan: a t^2 + 2 b t + c = 0.
  const Eigen::Vector2d p = origin_m.head<2>() - leg.centre_m, d = direction.head<2>();
  const double a = d.squaredNorm(), b = p.dot(d),
               c = p.squaredNorm() - Leg::kRadiusM * Leg::kRadiusM;
  if (c > 0.0) {
    if (b >= 0.0 || b * b < a * c) return std::nullopt;
    const double side_m = c / (std::sqrt(b * b - a * c) - b);
    const double z_m = origin_m.z() + side_m * direction.z();
    if (z_m >= 0.0 && z_m <= Leg::kHeightM) return side_m;
  }
  if (origin_m.z() <= Leg::kHeightM || direction.z() >= 0.0) return std::nullopt;
  const double top_m = (Leg::kHeightM - origin_m.z()) / direction.z();
  if ((p + top_m * d).norm() > Leg::kRadiusM) return std::nullopt;
  return top_m;
}

Person::Person(const std::vector<Eigen::Vector2d>& waypoints_m,
               double speed_m_per_s,
               double ahead_s)
    : speed_m_per_s_(speed_m_per_s), ahead_s_(ahead_s) {
  const std::size_t count = waypoints_m.size();
  require(count >= 2, "people.waypoints_m: expected at least two");
  for (std::size_t i = 1; i < count; ++i) add_piece(waypoints_m[i - 1], waypoints_m[i]);
  const bool to_and_fro = waypoints_m.front() != waypoints_m.back();
  for (std::size_t i = count - 1; to_and_fro && i > 0; --i) {
    add_piece(waypoints_m[i], waypoints_m[i - 1]);
  }
  require(!pieces_.empty(), "people.waypoints_m: all are identical");
}

void Person::add_piece(const Eigen::Vector2d& from_m, const Eigen::Vector2d& to_m) {
  if (from_m == to_m) return;
  pieces_.push_back({length_m_, from_m, (to_m - from_m).normalized()});
  length_m_ += (to_m - from_m).norm();
}

Eigen::Vector2d Person::foothold(double walked_m, double side) const {
  const double along_m = walked_m - std::floor(walked_m / length_m_) * length_m_;
  const Piece* piece = &pieces_.back();
  while (piece->starts_m > along_m) --piece;  // the first starts at 0
  return piece->from_m + (along_m - piece->starts_m) * piece->ahead +
         side * kHalfHipsM * Eigen::Vector2d(-piece->ahead.y(), piece->ahead.x());
}

Leg Person::leg_at(double walked_m, double side) const {
  const double later_m = side < 0.0 ? 0.5 * kStrideM : 0.0;  // the right foot after the left
  const double strides = (walked_m - later_m) / kStrideM, begun = std::floor(strides);
  // It stands from a quarter of a stride ahead of the body to a quarter behind, then swings.
  const double stands_m = later_m + (begun + 0.25) * kStrideM;
  const double swung = std::clamp(2.0 * (strides - begun) - 1.0, 0.0, 1.0);
  const double eased = swung * swung * (3.0 - 2.0 * swung);
  const Eigen::Vector2d from_m = foothold(stands_m, side);
  return {from_m + eased * (foothold(stands_m + kStrideM, side) - from_m)};
}

std::array<Leg, 2> Person::legs_at(double seconds) const {
  const double walked_m = speed_m_per_s_ * (seconds + ahead_s_);
  return {leg_at(walked_m, 1.0), leg_at(walked_m, -1.0)};
}

}  // namespace marco::sim
