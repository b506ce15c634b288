#include "plan/known_plan/curve_fit.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "common/linear_algebra.hpp"
#include "plan/known_plan/face_matching.hpp"

namespace marco::plan {
namespace {

// A point beside the curve.
struct Spot {
  Eigen::Vector3d row;  ///< how it depends on (off, shift x, shift y)
  double off_m;
};

constexpr double kNoiseM = 0.01;  // of a surfel's place
constexpr double kSharing = 4.0;  // surfels side by side share their noise

std::vector<Spot> spots_on(const std::vector<DrawnFace>& chords,
                           const std::vector<PlanSurfel>& surfels,
                           CurveFit& fit) {
  constexpr double kFacing = 0.9;  // cosine: a chord differs from its arc by less
  std::vector<Spot> spots;
  for (const DrawnFace& chord : chords) {
    const WallFace& drawn = chord.face;
    const std::size_t before = spots.size();
    for (const PlanSurfel& surfel : surfels) {
      const Eigen::Vector2d at = surfel.mean();
      const double along = drawn.along().dot(at), off = drawn.distance_m(at);
      if (along < drawn.low_m || along > drawn.high_m || std::abs(off) > kSameWallM) continue;
      if (surfel.normal.normalized().dot(drawn.normal) < kFacing) continue;
      spots.push_back({{1.0, drawn.normal.x(), drawn.normal.y()}, off});
    }
    if (spots.size() > before) fit.seen_m += drawn.length_m();
  }
  return spots;
}

}  // namespace

CurveFit fit_curve(const std::vector<DrawnFace>& chords, const std::vector<PlanSurfel>& surfels) {
  constexpr std::size_t kLeast = 6;  // twice the unknowns
  CurveFit fit;
  const std::vector<Spot> spots = spots_on(chords, surfels, fit);
  if (spots.size() < kLeast) return fit;
  Eigen::Vector3d found = Eigen::Vector3d::Zero();
  for (const double kernel_m : {0.2, 0.1, 0.05, 0.03, 0.03, 0.03}) {
    // What a short arc does not show stays near what is drawn.
    constexpr double kPriorOffM = 0.1, kPriorShiftM = 0.2;
    NormalEquations<3> sum;
    sum.information.diagonal() << std::pow(kPriorOffM, -2), std::pow(kPriorShiftM, -2),
        std::pow(kPriorShiftM, -2);
    double squares = 0.0, kept = 0.0;
    for (const Spot& spot : spots) {
      const double rest = spot.off_m - spot.row.dot(found);
      const double weight = std::pow(1 + std::pow(rest / kernel_m, 2), -2);
      sum.add(spot.row, spot.off_m, weight / kSharing / (kNoiseM * kNoiseM));
      squares += weight * rest * rest;
      kept += weight;
    }
    const Eigen::Matrix3d covariance = sum.information.inverse();
    found = covariance * sum.gradient;
    fit.sigma_m = std::sqrt(covariance(0, 0) * std::max(1.0, squares / kept / (kNoiseM * kNoiseM)));
  }
  fit.found = true;
  fit.off_m = found.x();
  fit.shift_m = found.tail<2>();
  return fit;
}

}  // namespace marco::plan
