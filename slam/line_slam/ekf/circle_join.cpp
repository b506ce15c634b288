#include <Eigen/Dense>
#include <algorithm>

#include "slam/line_slam/ekf/circle_map.hpp"

namespace marco::slam {
namespace {

constexpr double kConcentricSigmaM = 0.005;  // two halves of one column differ by no more

SparseRows concentricity(const EkfState& state, const MapCircle& a, const MapCircle& b) {
  SparseRows rows;
  rows.resize(3);
  rows.num_blocks = 2;
  rows.blocks = {a.block, b.block, 0};
  rows.jacobian.block<3, 3>(0, 0).setIdentity();
  rows.jacobian.block<3, 3>(0, 4) = -Eigen::Matrix3d::Identity();
  rows.innovation = -(state.mean(a.block) - state.mean(b.block)).head<3>();
  rows.noise = kConcentricSigmaM * kConcentricSigmaM * Eigen::Matrix3d::Identity();
  return rows;
}

}  // namespace

bool CircleMap::are_one(const EkfState& state, std::size_t a, std::size_t b) const {
  const MapCircle &one = circles_[a], &other = circles_[b];
  constexpr double kFarM = 1.0;  // centres of short arcs are known as poorly
  if (one.from_inside != other.from_inside) return false;
  const double off_m = (state.mean(one.block) - state.mean(other.block)).head<2>().norm();
  if (off_m > kFarM) return false;
  const SparseRows rows = concentricity(state, one, other);
  const Eigen::Matrix3d s = state.innovation_covariance(rows);
  const Eigen::Vector3d nu = rows.innovation;
  return nu.dot(s.ldlt().solve(nu)) <= gate_;
}

void CircleMap::join_concentric(EkfState& state) {
  for (std::size_t a = 0; a < circles_.size(); ++a) {
    for (std::size_t b = circles_.size(); b-- > a + 1;) {
      if (are_one(state, a, b)) join(state, a, b);
    }
  }
}

void CircleMap::join(EkfState& state, std::size_t a, std::size_t b) {
  state.correct(concentricity(state, circles_[a], circles_[b]));
  state.finish_corrections();
  MapCircle& kept = circles_[a];
  const MapCircle& other = circles_[b];
  kept.arc.merge(other.arc);
  kept.times_seen = std::max(kept.times_seen, other.times_seen);
  kept.advantage += other.advantage;
  kept.id = std::min(kept.id, other.id);
  remove(state, b);
}

}  // namespace marco::slam
