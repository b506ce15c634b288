#pragma once

#include <optional>
#include <vector>

#include "lcm_tools/base/options.hpp"
#include "mapping3d/surfels.hpp"

namespace marco::mapping3d {

/// How surfels of two scenes are associated: nearest neighbour within a radius, similar normals,
/// residuals weighted by a robust kernel. Shared by registration, straightening and calibration,
/// each with defaults of its own.
struct SurfelMatchingOptions {
  SurfelOptions surfels;
  double search_start_m;   ///< search radius of the first iteration ...
  double search_end_m;     ///< ... and of the last
  double lorentz_start_m;  ///< scale of the robust kernel (Lorentzian) in the first iteration ...
  double lorentz_end_m;    ///< ... and in the last
  double shrink;           ///< factor of both per iteration
  double max_normal_deg;   ///< largest angle between the normals of a correspondence
  double thin_m;           ///< a surfel this thick has half the weight of a flat one

  template <class Visitor>
  void visit(Visitor& v) {
    v("surfels", surfels);
    v("search_start_m", search_start_m, kPositive);
    v("search_end_m", search_end_m, kPositive);
    v("lorentz_start_m", lorentz_start_m, kPositive);
    v("lorentz_end_m", lorentz_end_m, kPositive);
    v("shrink", shrink, Limits{0.1, 0.99});
    v("max_normal_deg", max_normal_deg, Limits{1.0, 90.0});
    v("thin_m", thin_m, kPositive);
  }
};

/// Search radius and kernel scale of one iteration.
struct MatchingScales {
  double search_m;
  double lorentz_m;

  static MatchingScales first(const SurfelMatchingOptions& options) {
    return {options.search_start_m, options.lorentz_start_m};
  }
  static MatchingScales last(const SurfelMatchingOptions& options) {
    return {options.search_end_m, options.lorentz_end_m};
  }
  /// Both a step smaller, not below the last.
  void shrink(const SurfelMatchingOptions& options);
  bool narrowest(const SurfelMatchingOptions& options) const;
};

/// A surfel's residual against its nearest neighbour.
struct SurfelCorrespondence {
  std::size_t partner;     ///< index in the target's surfels
  Eigen::Vector3d normal;  ///< unit, the mean of both
  double residual_m;       ///< point to plane along `normal`
};

/// Data association: finds correspondences of surfels, frame of the target. Const: safe from
/// several threads.
class SurfelAssociation {
 public:
  explicit SurfelAssociation(const SurfelMatchingOptions& options);

  /// Nothing when no surfel lies within `search_m` or the nearest one faces elsewhere.
  std::optional<SurfelCorrespondence> find(const SurfelIndex& target,
                                           const Eigen::Vector3d& center_m,
                                           const Eigen::Vector3d& normal,
                                           double search_m) const;

  /// Robust kernel: the weight of iteratively reweighted least squares for the Lorentzian
  /// rho(r) = log(1 + r^2 / (2 s^2)), which is 1 / (1 + r^2 / (2 s^2)); halved for surfels whose
  /// mean square thickness is thin_m^2.
  double weight(double residual_m, double lorentz_m, double thickness2_m2) const;

 private:
  double min_cosine_;
  double thin2_m2_;
};

}  // namespace marco::mapping3d
