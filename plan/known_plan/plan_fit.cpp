#include "plan/known_plan/plan_fit.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "common/linear_algebra.hpp"
#include "common/median.hpp"
#include "lcm_tools/base/check.hpp"
#include "slam/session/merge_maps.hpp"

namespace marco::plan {
namespace {

using Vector = Eigen::Vector2d;

// An end of a measured face on a drawn one.
struct Pairing {
  Vector point = {0, 0};   ///< in the drawing
  Vector normal = {0, 0};  ///< of the drawn face
  double off_m = 0.0;
  double sigma_m = 0.0;
  double length_m = 0.0;  ///< of the face
};

std::vector<Pairing> pair_up(const std::vector<DrawnFace>& drawn,
                             const std::vector<WallFace>& measured,
                             const Pose2& drawing_from_map,
                             double reach_m) {
  std::vector<Pairing> pairings;
  for (const WallFace& face : measured) {
    const Vector normal = drawing_from_map.rotation() * face.normal;
    const double inset = 0.1 * face.length_m();
    for (const double at : {face.low_m + inset, face.high_m - inset}) {
      const Vector point = drawing_from_map * face.at(at);
      const auto nearest = drawn_face_at(drawn, point, normal, reach_m);
      if (!nearest || drawn[*nearest].curved) continue;
      const WallFace& on = drawn[*nearest].face;
      pairings.push_back({point, on.normal, on.distance_m(point), face.sigma_m, face.length_m()});
    }
  }
  return pairings;
}

// One step of iteratively reweighted least squares about the faces' middle.
void step(PlanFit& fit, const std::vector<Pairing>& pairings, double kernel_m) {
  fit.middle.setZero();
  double mean_length_m = 0.0;
  for (const Pairing& pairing : pairings) {
    fit.middle += pairing.point / static_cast<double>(pairings.size());
    mean_length_m += pairing.length_m / static_cast<double>(pairings.size());
  }
  // Nothing moves along walls that are all parallel.
  NormalEquations<3> sum;
  sum.information.diagonal() << 1 / 0.25, 1 / 0.25, 1 / 0.01;
  for (const Pairing& pairing : pairings) {
    const double ratio = pairing.off_m / kernel_m;
    const double kept = std::pow(1 + ratio * ratio, -2);
    const double sigma = std::hypot(pairing.sigma_m, std::max(fit.spread_m, 0.002));
    // The two ends of a face share its noise. A wall in pieces is no more than one in one piece.
    constexpr double kShort = 0.1, kLong = 3.0;
    const double share = std::clamp(pairing.length_m / mean_length_m, kShort, kLong);
    const Vector arm = pairing.point - fit.middle;
    const Eigen::Vector3d row(pairing.normal.x(), pairing.normal.y(),
                              pairing.normal.dot(Vector(-arm.y(), arm.x())));
    sum.add(row, pairing.off_m, kept * share / (2 * sigma * sigma));
  }
  fit.covariance = sum.information.inverse();
  const Eigen::Vector3d move = -fit.covariance * sum.gradient;
  const Pose2 about_middle{fit.middle.x(), fit.middle.y(), 0.0};
  fit.drawing_from_map = about_middle * Pose2{move.x(), move.y(), move.z()} *
                         about_middle.inverse() * fit.drawing_from_map;
}

}  // namespace

WallFace moved(const WallFace& face, const Pose2& to_from_frame) {
  WallFace out = face;
  out.normal = to_from_frame.rotation() * face.normal;
  const Vector low = to_from_frame * face.at(face.low_m),
               high = to_from_frame * face.at(face.high_m);
  out.offset_m = out.normal.dot(low);
  out.low_m = out.along().dot(low);
  out.high_m = out.along().dot(high);
  return out;
}

std::optional<std::size_t> drawn_face_at(const std::vector<DrawnFace>& drawn,
                                         const Vector& point,
                                         const Vector& normal,
                                         double reach_m) {
  constexpr double kFacing = 0.97;   // cosine of 14 degrees: the fit begins turned
  constexpr double kBeyondM = 0.10;  // the end: corners are drawn and measured apart by so much
  std::optional<std::size_t> nearest;
  double least = reach_m;
  for (std::size_t i = 0; i < drawn.size(); ++i) {
    const WallFace& face = drawn[i].face;
    const double off = std::abs(face.distance_m(point));
    if (off > least || face.normal.dot(normal) < kFacing) continue;
    const double at = face.along().dot(point);
    if (at < face.low_m - kBeyondM || at > face.high_m + kBeyondM) continue;
    least = off;
    nearest = i;
  }
  return nearest;
}

std::optional<Pose2> find_in_plan(const PlanSight& plan, const std::vector<slam::Keyframe>& keys) {
  const slam::LocalizerOptions options;
  slam::FrozenMap map(plan.keyframes, options, {});
  const auto found = slam::find_session(map, keys, options);
  if (!found) return std::nullopt;
  return found->place.map_from_robot *
         keys[static_cast<std::size_t>(found->newest_key)].world_from_robot.inverse();
}

PlanFit fit_to_plan(const std::vector<DrawnFace>& drawn,
                    const std::vector<WallFace>& measured,
                    const Pose2& drawing_from_map_guess,
                    double narrowest_m) {
  constexpr std::size_t kLeast = 6;  // ends
  constexpr int kStepsEach = 6;
  PlanFit fit;
  fit.drawing_from_map = drawing_from_map_guess;
  fit.spread_m = 0.02;
  for (const double kernel_m : {0.3, 0.15, 0.08, 0.04, 0.04}) {
    if (kernel_m < narrowest_m) break;
    for (int i = 0; i < kStepsEach; ++i) {
      const auto pairings =
          pair_up(drawn, measured, fit.drawing_from_map, std::max(0.25, 2 * kernel_m));
      require(pairings.size() >= kLeast,
              "the map's walls are not near the plan's: are the start and the unit right?");
      step(fit, pairings, kernel_m);
    }
    std::vector<double> offs;
    for (const Pairing& pairing : pair_up(drawn, measured, fit.drawing_from_map, 0.25)) {
      offs.push_back(std::abs(pairing.off_m));
    }
    if (!offs.empty()) fit.spread_m = std::clamp(kSigmaOfMedian * median(offs), 0.002, 0.05);
  }
  double all = 0.0, agreeing = 0.0;
  for (const WallFace& face : measured) {
    const Vector middle = fit.drawing_from_map * face.at((face.low_m + face.high_m) / 2);
    all += face.length_m();
    if (drawn_face_at(drawn, middle, fit.drawing_from_map.rotation() * face.normal, 0.05)) {
      agreeing += face.length_m();
    }
  }
  fit.agreeing = all > 0 ? agreeing / all : 0.0;
  return fit;
}

}  // namespace marco::plan
