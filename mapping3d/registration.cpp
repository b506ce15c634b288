#include "mapping3d/registration.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "lcm_tools/base/check.hpp"

namespace marco::mapping3d {
namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

// One surfel in four is enough while the search is wide.
constexpr std::size_t kCoarseStride = 4;

// After this many steps with the narrowest search only alternating correspondences still move.
constexpr int kSettling = 10;

struct Scales : MatchingScales {
  std::size_t stride;
};

/// What one pair of bodies says about a turn and shift of the second against the first.
struct PairSystem {
  Matrix6d information = Matrix6d::Zero();
  Vector6d gradient = Vector6d::Zero();
  double weight = 0.0;
  std::size_t patches = 0;
  Eigen::Vector3d center_m = Eigen::Vector3d::Zero();  ///< weighted sum, as placed
};

void add(const Vector6d& jacobian, double residual_m, double weight, PairSystem& system) {
  system.information.noalias() += weight * jacobian * jacobian.transpose();
  system.gradient += weight * residual_m * jacobian;
}

PatchResiduals summary(std::vector<double>& residuals_m) {
  return {residuals_m.size(), quantile(residuals_m, 0.5), quantile(residuals_m, 0.9)};
}

class Registrar {
 public:
  Registrar(const std::vector<ScenePoints>& placed,
            const std::vector<std::size_t>& body_of,
            const RegistrationOptions& options)
      : options_(options), association_(options.matching) {
    validate(options, "registration");
    require(body_of.empty() || body_of.size() == placed.size(),
            "register_scenes: expected one body a scene");
    for (std::size_t i = 0; i < placed.size(); ++i) {
      scenes_.push_back(
          std::make_unique<SurfelIndex>(find_surfels(placed[i], options.matching.surfels)));
      const std::size_t body = body_of.empty() ? i : body_of[i];
      require(body <= bodies_.size(), "register_scenes: bodies are numbered as they first appear");
      if (body == bodies_.size()) bodies_.emplace_back();
      bodies_[body].push_back(i);
    }
    world_from_body_.assign(bodies_.size(), Pose3::Identity());
    joined_.assign(bodies_.size(), false);
    if (!joined_.empty()) joined_[0] = true;
  }

  RegistrationResult run() {
    result_.before = measure();
    const SurfelMatchingOptions& matching = options_.matching;
    Scales scales{MatchingScales::first(matching), kCoarseStride};
    bool converged = false;
    int narrow_iterations = 0;
    while (result_.iterations < options_.max_iterations && !converged) {
      const bool narrowest = scales.narrowest(matching);
      if (narrowest) scales.stride = 1;
      const double step = iterate(scales);
      ++result_.iterations;
      narrow_iterations += narrowest ? 1 : 0;
      converged = narrowest && step < (narrow_iterations > kSettling ? options_.settled_m
                                                                     : options_.converged_m);
      scales.shrink(matching);
      if (narrowest) {
        scales.lorentz_m =
            std::clamp(2.0 * quantile(residuals_m_, 0.5), 1e-4, matching.lorentz_end_m);
      }
      if (result_.overlaps == 0) break;
    }
    result_.after = measure();
    result_.world_from_placed.resize(scenes_.size());
    result_.joined.resize(scenes_.size());
    for (std::size_t body = 0; body < bodies_.size(); ++body) {
      for (const std::size_t scene : bodies_[body]) {
        result_.world_from_placed[scene] = world_from_body_[body];
        result_.joined[scene] = joined_[body];
      }
    }
    if (result_.overlaps > 0) {
      result_.status = converged ? RegistrationResult::Status::converged
                                 : RegistrationResult::Status::not_converged;
    }
    return std::move(result_);
  }

 private:
  PatchResiduals measure() {
    residuals_m_.clear();
    const std::size_t overlaps = result_.overlaps;
    const Scales scales{MatchingScales::last(options_.matching), kCoarseStride};
    for (std::size_t a = 0; a < bodies_.size(); ++a) {
      for (std::size_t b = a + 1; b < bodies_.size(); ++b) compare_bodies(a, b, scales);
    }
    result_.overlaps = overlaps;
    return summary(residuals_m_);
  }

  /// One step of all bodies. @returns its length [m, rad as m].
  double iterate(const Scales& scales) {
    const auto count = static_cast<Eigen::Index>(bodies_.size());
    Eigen::MatrixXd information = Eigen::MatrixXd::Zero(6 * count, 6 * count);
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(6 * count);
    residuals_m_.clear();
    result_.overlaps = 0;
    std::vector<std::pair<std::size_t, std::size_t>> overlaps;
    for (std::size_t a = 0; a < bodies_.size(); ++a) {
      for (std::size_t b = a + 1; b < bodies_.size(); ++b) {
        std::optional<PairSystem> pair = compare_bodies(a, b, scales);
        if (!pair) continue;
        hold_loose_shifts(a, b, *pair);
        overlaps.emplace_back(a, b);
        // A twist of a is the opposite twist of b: both are about the world's origin.
        const auto at_a = 6 * static_cast<Eigen::Index>(a), at_b = 6 * static_cast<Eigen::Index>(b);
        information.block<6, 6>(at_a, at_a) += pair->information;
        information.block<6, 6>(at_b, at_b) += pair->information;
        information.block<6, 6>(at_a, at_b) -= pair->information;
        information.block<6, 6>(at_b, at_a) -= pair->information;
        gradient.segment<6>(at_a) -= pair->gradient;
        gradient.segment<6>(at_b) += pair->gradient;
      }
    }
    find_joined(overlaps);
    return move(information, gradient);
  }

  void find_joined(const std::vector<std::pair<std::size_t, std::size_t>>& overlaps) {
    std::fill(joined_.begin(), joined_.end(), false);
    if (!joined_.empty()) joined_[0] = true;
    for (std::size_t round = 0; round < bodies_.size(); ++round) {
      for (const auto& [a, b] : overlaps) {
        if (joined_[a] || joined_[b]) {
          joined_[a] = true;
          joined_[b] = true;
        }
      }
    }
  }

  double move(Eigen::MatrixXd& information, Eigen::VectorXd& gradient) {
    for (std::size_t body = 0; body < bodies_.size(); ++body) {
      const auto at = 6 * static_cast<Eigen::Index>(body);
      // A little regularization, so that an unobservable body stays where it is.
      const double stiffness = 1e-6 * information.block<6, 6>(at, at).trace() + 1e-9;
      information.block<6, 6>(at, at).diagonal().array() += stiffness;
      if (body > 0 && joined_[body]) continue;
      information.middleRows<6>(at).setZero();
      information.middleCols<6>(at).setZero();
      information.block<6, 6>(at, at).setIdentity();
      gradient.segment<6>(at).setZero();
    }
    const Eigen::VectorXd step = information.ldlt().solve(-gradient);
    for (std::size_t body = 0; body < bodies_.size(); ++body) {
      Pose3& pose = world_from_body_[body];
      const Vector6d twist = step.segment<6>(6 * static_cast<Eigen::Index>(body));
      pose = turn_about(Eigen::Vector3d::Zero(), twist.head<3>()) * pose;
      pose.translation() += twist.tail<3>();
      pose.linear() = Eigen::Quaterniond(pose.linear()).normalized().toRotationMatrix();
    }
    return step.size() > 0 ? step.cwiseAbs().maxCoeff() : 0.0;
  }

  /// @returns nothing when the two have too few correspondences.
  std::optional<PairSystem> compare_bodies(std::size_t a, std::size_t b, const Scales& scales) {
    const std::size_t residuals_before = residuals_m_.size(), overlaps_before = result_.overlaps;
    PairSystem system;
    for (const std::size_t target : bodies_[a]) {
      for (const std::size_t source : bodies_[b]) {
        const std::size_t patches_before = system.patches;
        compare(*scenes_[target], *scenes_[source], {world_from_body_[a], world_from_body_[b]},
                scales, system);
        if (system.patches > patches_before) ++result_.overlaps;
      }
    }
    if (system.patches * scales.stride >= static_cast<std::size_t>(options_.min_pairs)) {
      return system;
    }
    residuals_m_.resize(residuals_before);
    result_.overlaps = overlaps_before;
    return std::nullopt;
  }

  struct Poses {
    const Pose3& world_from_a;
    const Pose3& world_from_b;
  };

  void compare(const SurfelIndex& target,
               const SurfelIndex& source,
               const Poses& poses,
               const Scales& scales,
               PairSystem& system) {
    if (target.box.isEmpty() || source.box.isEmpty()) return;
    const Pose3 a_from_b = poses.world_from_a.inverse(Eigen::Isometry) * poses.world_from_b;
    Eigen::AlignedBox3d reach = source.box.transformed(a_from_b);
    reach.min().array() -= scales.search_m;
    reach.max().array() += scales.search_m;
    if (!reach.intersects(target.box)) return;
    for (std::size_t i = 0; i < source.surfels.size(); i += scales.stride) {
      const Surfel& moved = source.surfels[i];
      const Eigen::Vector3d in_a = a_from_b * moved.center_m;
      const auto found =
          association_.find(target, in_a, a_from_b.linear() * moved.normal, scales.search_m);
      if (!found) continue;
      residuals_m_.push_back(std::abs(found->residual_m));
      const double thickness2_m2 =
          moved.thickness2_m2() + target.surfels[found->partner].thickness2_m2();
      const double weight = association_.weight(found->residual_m, scales.lorentz_m, thickness2_m2);
      const Eigen::Vector3d point_m = poses.world_from_a * in_a;
      const Eigen::Vector3d normal = poses.world_from_a.linear() * found->normal;
      Vector6d jacobian;
      jacobian << point_m.cross(normal), normal;
      add(jacobian, found->residual_m, weight, system);
      system.weight += weight;
      ++system.patches;
      system.center_m += weight * moved.center_m;
    }
  }

  /// Constrains the relative shift to the initial guess along directions with hardly any normals.
  void hold_loose_shifts(std::size_t a, std::size_t b, PairSystem& system) const {
    if (!(system.weight > 0.0)) return;
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
    solver.computeDirect(system.information.bottomRightCorner<3, 3>());
    const Eigen::Vector3d center_m = system.center_m / system.weight;
    const Eigen::Vector3d by_a = world_from_body_[a] * center_m;
    const Eigen::Vector3d by_b = world_from_body_[b] * center_m;
    for (Eigen::Index i = 0; i < 3; ++i) {
      if (solver.eigenvalues()[i] >= options_.min_hold * system.weight) continue;
      const Eigen::Vector3d loose = solver.eigenvectors().col(i);
      Vector6d jacobian;
      jacobian << by_b.cross(loose), loose;
      add(jacobian, loose.dot(by_b - by_a), system.weight, system);
    }
  }

  RegistrationOptions options_;
  SurfelAssociation association_;
  std::vector<std::unique_ptr<SurfelIndex>> scenes_;
  std::vector<std::vector<std::size_t>> bodies_;  ///< the scenes of each
  std::vector<Pose3> world_from_body_;
  std::vector<bool> joined_;
  std::vector<double> residuals_m_;
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

RegistrationResult register_scenes(const std::vector<ScenePoints>& placed,
                                   const RegistrationOptions& options,
                                   const std::vector<std::size_t>& body_of) {
  return Registrar(placed, body_of, options).run();
}

}  // namespace marco::mapping3d
