#include "plan/surfels.hpp"

#include <cmath>
#include <limits>
#include <map>
#include <tuple>

namespace marco::plan {
namespace {

constexpr double kCellM = 0.05;   // the map's
constexpr int kFacings = 12;      // of 30 degrees: both sides of a thin wall are apart
constexpr double kGrazing = 0.2;  // cosine of the angle between beam and normal

}  // namespace

std::vector<PlanSurfel> gather_surfels(const std::vector<slam::Keyframe>& keys,
                                       const Pose2& plan_from_map) {
  std::map<std::tuple<int, int, int>, std::size_t> index;
  std::vector<PlanSurfel> surfels;
  for (std::size_t k = 0; k < keys.size(); ++k) {
    const Pose2 plan_from_robot = plan_from_map * keys[k].world_from_robot;
    const Eigen::Vector2d sensor = plan_from_robot * keys[k].sensor_in_robot;
    const slam::OrientedPoints& scan = keys[k].points_in_robot;
    for (Eigen::Index i = 0; i < scan.points.cols(); ++i) {
      if (!scan.has_normal(i)) continue;
      const Eigen::Vector2d point = plan_from_robot * Eigen::Vector2d(scan.points.col(i));
      const Eigen::Vector2d normal = plan_from_robot.rotation() * scan.normals.col(i);
      if (normal.dot((sensor - point).normalized()) < kGrazing) continue;
      const double turn = std::atan2(normal.y(), normal.x()) / (2 * std::numbers::pi) + 0.5;
      const auto key = std::make_tuple(static_cast<int>(std::floor(point.x() / kCellM)),
                                       static_cast<int>(std::floor(point.y() / kCellM)),
                                       static_cast<int>(std::lround(turn * kFacings)) % kFacings);
      const auto [place, is_new] = index.emplace(key, surfels.size());
      if (is_new) surfels.emplace_back();
      PlanSurfel& surfel = surfels[place->second];
      surfel.count += 1;
      surfel.sum += point;
      surfel.squares += point * point.transpose();
      surfel.normal += normal;
      surfel.points.push_back(point);
      if (surfel.last_keyframe != static_cast<int>(k)) ++surfel.keyframes;
      surfel.last_keyframe = static_cast<int>(k);
    }
  }
  return surfels;
}

double main_direction_rad(const std::vector<PlanSurfel>& surfels) {
  constexpr int kBins = 360;  // of a quarter of a degree
  std::vector<double> votes(kBins, 0.0);
  const auto bin_of = [](const PlanSurfel& surfel) {
    const double quarter =
        std::atan2(surfel.normal.y(), surfel.normal.x()) / (std::numbers::pi / 2);
    return static_cast<int>((quarter - std::floor(quarter)) * kBins) % kBins;
  };
  double all = 0.0;
  for (const PlanSurfel& surfel : surfels) {
    votes[static_cast<std::size_t>(bin_of(surfel))] += 1;
    all += 1;
  }
  int best = 0;
  double most = -1;
  const auto near = [&](int bin) {
    double sum = 0;
    for (int i = -12; i <= 12; ++i) {
      sum += votes[static_cast<std::size_t>((bin + i + kBins) % kBins)] * (13 - std::abs(i));
    }
    return sum / 13;
  };
  for (int bin = 0; bin < kBins; ++bin) {
    if (near(bin) > most) most = near(bin), best = bin;
  }
  double within = 0, shift = 0;
  for (int i = -12; i <= 12; ++i) {
    const double vote = votes[static_cast<std::size_t>((best + i + kBins) % kBins)];
    within += vote;
    shift += vote * (i + 0.5);
  }
  if (all == 0 || within < all / 5) return std::numeric_limits<double>::quiet_NaN();
  double angle = (best + shift / within) / kBins * std::numbers::pi / 2;
  if (angle >= std::numbers::pi / 4) angle -= std::numbers::pi / 2;
  return angle;
}

}  // namespace marco::plan
