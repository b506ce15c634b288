#include "mapping3d/surfel_matching.hpp"

#include <algorithm>
#include <cmath>

#include "common/pose2.hpp"

namespace marco::mapping3d {

void MatchingScales::shrink(const SurfelMatchingOptions& options) {
  search_m = std::max(options.search_end_m, options.shrink * search_m);
  lorentz_m = std::max(options.lorentz_end_m, options.shrink * lorentz_m);
}

bool MatchingScales::narrowest(const SurfelMatchingOptions& options) const {
  return search_m <= options.search_end_m && lorentz_m <= options.lorentz_end_m;
}

SurfelAssociation::SurfelAssociation(const SurfelMatchingOptions& options)
    : min_cosine_(std::cos(deg_to_rad(options.max_normal_deg))),
      thin2_m2_(options.thin_m * options.thin_m) {}

std::optional<SurfelCorrespondence> SurfelAssociation::find(const SurfelIndex& target,
                                                            const Eigen::Vector3d& center_m,
                                                            const Eigen::Vector3d& normal,
                                                            double search_m) const {
  const auto nearest = target.centers.nearest(center_m.cast<float>(), static_cast<float>(search_m));
  if (!nearest) return std::nullopt;
  const Surfel& partner = target.surfels[*nearest];
  if (normal.dot(partner.normal) < min_cosine_) return std::nullopt;
  const Eigen::Vector3d mean = (normal + partner.normal).normalized();
  return SurfelCorrespondence{*nearest, mean, mean.dot(center_m - partner.center_m)};
}

double SurfelAssociation::weight(double residual_m, double lorentz_m, double thickness2_m2) const {
  const double scaled = residual_m / lorentz_m;
  return 1.0 / ((1.0 + 0.5 * scaled * scaled) * (1.0 + thickness2_m2 / thin2_m2_));
}

}  // namespace marco::mapping3d
