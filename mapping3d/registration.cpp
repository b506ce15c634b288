#include "mapping3d/registration.hpp"

#include <Eigen/Sparse>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "lcm_tools/base/check.hpp"
#include "mapping3d/registration_body.hpp"
#include "mapping3d/scene_overlaps.hpp"

namespace marco::mapping3d {
namespace {

// One surfel in four is enough while the search is wide.
constexpr std::size_t kCoarseStride = 4;

// A step is small when it is this part of a standard deviation. After ten steps with the narrowest
// search a tenth will do: then only correspondences that alternate still move.
constexpr double kConverged = 0.005, kSettled = 0.1;
constexpr int kSettling = 10;
// The smallest part of a step: shorter ones would not arrive within max_iterations.
constexpr double kLeastDamping = 0.25;

// Surfels that share their error: those of a row have its angle, those of a sweep its pose.
constexpr double kSharedError = 30.0;

// Of six degrees of freedom, 99.9 %: a larger correction contradicts the path.
constexpr double kChi2Dof6Quantile999 = 22.5;

struct Scales : MatchingScales {
  std::size_t stride;
};

/// A pair of bodies that overlap.
struct Pair {
  std::size_t a, b;
};

PatchResiduals summary(std::vector<double>& residuals_m) {
  return {residuals_m.size(), quantile(residuals_m, 0.5), quantile(residuals_m, 0.9)};
}

class Registrar {
 public:
  Registrar(const PlacedScenes& placed,
            const std::vector<std::size_t>& body_of,
            const RegistrationOptions& options)
      : options_(options), association_(options.matching), body_of_(body_of) {
    validate(options, "registration");
    require(body_of.empty() || body_of.size() == placed.count,
            "register_scenes: expected one body a scene");
    if (body_of_.empty()) {
      for (std::size_t i = 0; i < placed.count; ++i) body_of_.push_back(i);
    }
    bodies_ = make_bodies(placed, body_of_, options.matching.surfels);
    std::vector<const std::vector<Surfel>*> surfels;
    for (const RegistrationBody& body : bodies_) surfels.push_back(&body.surfels.surfels);
    for (const auto& [a, b] : find_overlaps(surfels, static_cast<std::size_t>(options.min_pairs))) {
      pairs_.push_back({a, b});
    }
    const double tilt = 1.0 / deg_to_rad(options.floor_sigma_deg),
                 plane = 1.0 / options.path_sigma_m;
    weights_ << tilt, tilt, 1.0 / deg_to_rad(options.path_sigma_deg), plane, plane,
        1.0 / options.floor_sigma_m;
    weights_ = weights_.cwiseAbs2();
  }

  RegistrationResult run() {
    result_.before = measure();
    bool converged = optimize(MatchingScales::first(options_.matching));
    while (converged && refuse_worst()) {
      converged = optimize(MatchingScales::last(options_.matching));
    }
    if (result_.overlaps > 0) {
      result_.status = converged ? RegistrationResult::Status::converged
                                 : RegistrationResult::Status::not_converged;
    }
    if (!converged) {
      for (RegistrationBody& body : bodies_) body.correction.setZero();
    }
    result_.after = measure();
    for (const std::size_t body : body_of_) {
      const bool moves = converged && is_tied(body) && !bodies_[body].refused;
      result_.joined.push_back(moves);
      result_.world_from_placed.push_back(moves ? bodies_[body].world_from_placed()
                                                : Pose3::Identity());
    }
    for (const RegistrationBody& body : bodies_) result_.refused += body.refused ? 1 : 0;
    return std::move(result_);
  }

 private:
  /// Gauss-Newton until the steps are small. Full steps of a robust estimator may overshoot and
  /// oscillate: once a step turns back, steps are halved. @returns whether they became small.
  bool optimize(const MatchingScales& first) {
    const SurfelMatchingOptions& matching = options_.matching;
    Scales scales{first, kCoarseStride};
    int narrow_iterations = 0;
    damping_ = 1.0;
    last_step_.resize(0);
    for (int iteration = 0; iteration < options_.max_iterations; ++iteration) {
      const bool narrowest = scales.narrowest(matching);
      if (narrowest) scales.stride = 1;
      const double step = iterate(scales);
      ++result_.iterations;
      if (result_.overlaps == 0) return true;
      narrow_iterations += narrowest ? 1 : 0;
      if (narrowest && step < (narrow_iterations > kSettling ? kSettled : kConverged)) return true;
      scales.shrink(matching);
      if (narrowest) {
        scales.lorentz_m =
            std::clamp(2.0 * quantile(residuals_m_, 0.5), 1e-4, matching.lorentz_end_m);
      }
    }
    return false;
  }

  PatchResiduals measure() const {
    const Scales scales{MatchingScales::last(options_.matching), kCoarseStride};
    std::vector<double> residuals_m;
    for (const Pair& pair : pairs_) {
      const std::optional<PairSystem> system = compare(pair, scales);
      if (!system) continue;
      residuals_m.insert(residuals_m.end(), system->residuals_m.begin(), system->residuals_m.end());
    }
    return summary(residuals_m);
  }

  /// Leaves the body on the path whose correction contradicts it most. @returns whether any did.
  bool refuse_worst() {
    double worst = kChi2Dof6Quantile999;
    RegistrationBody* refused = nullptr;
    for (RegistrationBody& body : bodies_) {
      const double squared_distance = body.correction.cwiseAbs2().dot(weights_);
      if (squared_distance <= worst) continue;
      worst = squared_distance;
      refused = &body;
    }
    if (refused == nullptr) return false;
    refused->refused = true;
    refused->correction.setZero();
    return true;
  }

  bool is_tied(std::size_t body) const {
    return std::any_of(tied_.begin(), tied_.end(),
                       [body](const Pair& pair) { return pair.a == body || pair.b == body; });
  }

  /// One step of all bodies. @returns its length, undamped, in standard deviations (Newton
  /// decrement), as the root of the mean square over the pairs.
  double iterate(const Scales& scales) {
    const auto size = 6 * static_cast<Eigen::Index>(bodies_.size());
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(size);
    std::vector<Eigen::Triplet<double>> entries;
    const auto add_block = [&entries](Eigen::Index row, Eigen::Index column,
                                      const Matrix6d& block) {
      for (Eigen::Index i = 0; i < 6; ++i) {
        for (Eigen::Index j = 0; j < 6; ++j) entries.emplace_back(row + i, column + j, block(i, j));
      }
    };
    for (std::size_t body = 0; body < bodies_.size(); ++body) {
      const auto at = 6 * static_cast<Eigen::Index>(body);
      add_block(at, at, Matrix6d(weights_.asDiagonal()));
      gradient.segment<6>(at) += weights_.cwiseProduct(bodies_[body].correction);
    }
    residuals_m_.clear();
    tied_.clear();
    for (const Pair& pair : pairs_) {
      const std::optional<PairSystem> system = compare(pair, scales);
      if (!system) continue;
      tied_.push_back(pair);
      residuals_m_.insert(residuals_m_.end(), system->residuals_m.begin(),
                          system->residuals_m.end());
      const Matrix6d of_a = -bodies_[pair.a].origin_from_pivot(),
                     of_b = bodies_[pair.b].origin_from_pivot();
      const auto at_a = 6 * static_cast<Eigen::Index>(pair.a),
                 at_b = 6 * static_cast<Eigen::Index>(pair.b);
      const Matrix6d by_b = system->information * of_b;
      add_block(at_a, at_a, of_a.transpose() * system->information * of_a);
      add_block(at_b, at_b, of_b.transpose() * by_b);
      add_block(at_a, at_b, of_a.transpose() * by_b);
      add_block(at_b, at_a, by_b.transpose() * of_a);
      gradient.segment<6>(at_a) += of_a.transpose() * system->gradient;
      gradient.segment<6>(at_b) += of_b.transpose() * system->gradient;
    }
    result_.overlaps = tied_.size();
    Eigen::SparseMatrix<double> information(size, size);
    information.setFromTriplets(entries.begin(), entries.end());
    const Eigen::VectorXd step =
        Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(information).solve(-gradient);
    if (last_step_.size() == size && step.dot(information * last_step_) < 0.0) {
      damping_ = std::max(kLeastDamping, 0.5 * damping_);
    }
    last_step_ = step;
    move(damping_ * step);
    const auto pairs = static_cast<double>(std::max<std::size_t>(tied_.size(), 1));
    return std::sqrt(std::abs(step.dot(gradient)) / pairs);
  }

  void move(const Eigen::VectorXd& step) {
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      RegistrationBody& body = bodies_[i];
      body.move(step.segment<6>(6 * static_cast<Eigen::Index>(i)));
    }
  }

  /// @returns nothing when the two have too few correspondences.
  std::optional<PairSystem> compare(const Pair& pair, const Scales& scales) const {
    const RegistrationBody &target = bodies_[pair.a], &source = bodies_[pair.b];
    if (target.refused || source.refused) return std::nullopt;
    const Pose3 world_from_a = target.world_from_placed();
    const Pose3 a_from_b = world_from_a.inverse(Eigen::Isometry) * source.world_from_placed();
    const double patch_weight =
        static_cast<double>(scales.stride) / (kSharedError * scales.lorentz_m * scales.lorentz_m);
    PairSystem system;
    for (std::size_t i = 0; i < source.surfels.surfels.size(); i += scales.stride) {
      const Surfel& moved = source.surfels.surfels[i];
      const Eigen::Vector3d in_a = a_from_b * moved.center_m;
      const auto found = association_.find(target.surfels, in_a, a_from_b.linear() * moved.normal,
                                           scales.search_m);
      if (!found) continue;
      system.residuals_m.push_back(std::abs(found->residual_m));
      const double thickness2_m2 =
          moved.thickness2_m2() + target.surfels.surfels[found->partner].thickness2_m2();
      const double weight =
          patch_weight * association_.weight(found->residual_m, scales.lorentz_m, thickness2_m2);
      const Eigen::Vector3d point_m = world_from_a * in_a;
      const Eigen::Vector3d normal = world_from_a.linear() * found->normal;
      Vector6d jacobian;
      jacobian << point_m.cross(normal), normal;
      system.add(jacobian, found->residual_m, weight);
      system.weight += weight;
      system.center_m += weight * moved.center_m;
    }
    const bool enough =
        system.residuals_m.size() * scales.stride >= static_cast<std::size_t>(options_.min_pairs);
    if (!enough) return std::nullopt;
    system.hold_loose_shifts(world_from_a, source.world_from_placed());
    return system;
  }

  RegistrationOptions options_;
  SurfelAssociation association_;
  std::vector<std::size_t> body_of_;  ///< one a scene
  std::vector<RegistrationBody> bodies_;
  std::vector<Pair> pairs_;  ///< that may overlap
  std::vector<Pair> tied_;   ///< of them, those with correspondences in the last iteration
  Vector6d weights_;         ///< of the path: 1 / variance of turns and shifts
  std::vector<double> residuals_m_;
  double damping_ = 1.0;       ///< of steps, see optimize()
  Eigen::VectorXd last_step_;  ///< empty before the first
  RegistrationResult result_;
};

}  // namespace

std::string to_string(RegistrationResult::Status status) {
  switch (status) {
    case RegistrationResult::Status::nothing_to_join:
      return "nothing to join";
    case RegistrationResult::Status::converged:
      return "converged";
    case RegistrationResult::Status::not_converged:
      return "not converged";
  }
  return "unknown";
}

RegistrationResult register_scenes(const PlacedScenes& placed,
                                   const RegistrationOptions& options,
                                   const std::vector<std::size_t>& body_of) {
  return Registrar(placed, body_of, options).run();
}

}  // namespace marco::mapping3d
