#include "mapping3d/registration.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "mapping3d/point_tree.hpp"

namespace marco::mapping3d {
namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

struct IndexedScene {
  std::vector<Surfel> surfels;
  PointTree tree;
};

std::unique_ptr<IndexedScene> index(std::vector<Surfel> surfels) {
  std::vector<Eigen::Vector3f> centers_m;
  centers_m.reserve(surfels.size());
  for (const Surfel& surfel : surfels) centers_m.push_back(surfel.center_m.cast<float>());
  return std::make_unique<IndexedScene>(IndexedScene{std::move(surfels), PointTree(centers_m)});
}

struct Scales {
  double search_m;
  double lorentz_m;
};

/// What one pair of scenes says about a turn and shift of the second against the first.
struct PairSystem {
  Matrix6d information = Matrix6d::Zero();
  Vector6d gradient = Vector6d::Zero();
};

class Registrar {
 public:
  Registrar(const std::vector<ScenePoints>& placed, const RegistrationOptions& options)
      : options_(options), min_cosine_(std::cos(deg_to_rad(options.max_normal_deg))) {
    validate(options, "registration");
    for (const ScenePoints& scene : placed) {
      scenes_.push_back(index(find_surfels(scene, options.surfels)));
    }
    result_.world_from_placed.assign(placed.size(), Pose3::Identity());
    result_.joined.assign(placed.size(), false);
    if (!placed.empty()) result_.joined[0] = true;
  }

  RegistrationResult run() {
    Scales scales{options_.search_start_m, options_.lorentz_start_m};
    while (result_.iterations < options_.max_iterations && !result_.converged) {
      const bool narrowest =
          scales.search_m <= options_.search_end_m && scales.lorentz_m <= options_.lorentz_end_m;
      const double step = iterate(scales);
      ++result_.iterations;
      result_.converged = narrowest && step < options_.converged_m;
      scales.search_m = std::max(options_.search_end_m, options_.shrink * scales.search_m);
      scales.lorentz_m = std::max(options_.lorentz_end_m, options_.shrink * scales.lorentz_m);
    }
    result_.pairs = residuals_.size();
    if (!residuals_.empty()) {
      const auto middle = residuals_.begin() + static_cast<std::ptrdiff_t>(residuals_.size() / 2);
      std::nth_element(residuals_.begin(), middle, residuals_.end());
      result_.median_residual_m = *middle;
    }
    return std::move(result_);
  }

 private:
  /// One step of all scenes. @returns its length [m, rad as m].
  double iterate(const Scales& scales) {
    const auto count = static_cast<Eigen::Index>(scenes_.size());
    Eigen::MatrixXd information = Eigen::MatrixXd::Zero(6 * count, 6 * count);
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(6 * count);
    residuals_.clear();
    std::vector<std::pair<std::size_t, std::size_t>> overlaps;
    for (std::size_t a = 0; a < scenes_.size(); ++a) {
      for (std::size_t b = a + 1; b < scenes_.size(); ++b) {
        const std::optional<PairSystem> pair = compare(a, b, scales);
        if (!pair) continue;
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
    std::fill(result_.joined.begin(), result_.joined.end(), false);
    if (!result_.joined.empty()) result_.joined[0] = true;
    for (std::size_t round = 0; round < scenes_.size(); ++round) {
      for (const auto& [a, b] : overlaps) {
        if (result_.joined[a] || result_.joined[b]) {
          result_.joined[a] = true;
          result_.joined[b] = true;
        }
      }
    }
  }

  double move(Eigen::MatrixXd& information, Eigen::VectorXd& gradient) {
    for (std::size_t scene = 0; scene < scenes_.size(); ++scene) {
      const auto at = 6 * static_cast<Eigen::Index>(scene);
      // A breath of stiffness: what no patch holds stays where it is.
      const double stiffness = 1e-6 * information.block<6, 6>(at, at).trace() + 1e-9;
      information.block<6, 6>(at, at).diagonal().array() += stiffness;
      if (scene > 0 && result_.joined[scene]) continue;
      information.middleRows<6>(at).setZero();
      information.middleCols<6>(at).setZero();
      information.block<6, 6>(at, at).setIdentity();
      gradient.segment<6>(at).setZero();
    }
    const Eigen::VectorXd step = information.ldlt().solve(-gradient);
    for (std::size_t scene = 0; scene < scenes_.size(); ++scene) {
      const Vector6d twist = step.segment<6>(6 * static_cast<Eigen::Index>(scene));
      const double angle_rad = twist.head<3>().norm();
      Pose3 moved = Pose3::Identity();
      if (angle_rad > 0.0) {
        moved.linear() =
            Eigen::AngleAxisd(angle_rad, twist.head<3>() / angle_rad).toRotationMatrix();
      }
      moved.translation() = twist.tail<3>();
      Pose3& pose = result_.world_from_placed[scene];
      pose = moved * pose;
      pose.linear() = Eigen::Quaterniond(pose.linear()).normalized().toRotationMatrix();
    }
    return step.size() > 0 ? step.cwiseAbs().maxCoeff() : 0.0;
  }

  std::optional<PairSystem> compare(std::size_t a, std::size_t b, const Scales& scales) {
    const IndexedScene& target = *scenes_[a];
    const Pose3 world_from_a = result_.world_from_placed[a];
    const Pose3 a_from_b = world_from_a.inverse(Eigen::Isometry) * result_.world_from_placed[b];
    const std::size_t residuals_before = residuals_.size();
    PairSystem system;
    for (const Surfel& moved : scenes_[b]->surfels) {
      const Eigen::Vector3d in_a = a_from_b * moved.center_m;
      const std::optional<uint32_t> nearest =
          target.tree.nearest(in_a.cast<float>(), static_cast<float>(scales.search_m));
      if (!nearest) continue;
      const Surfel& partner = target.surfels[*nearest];
      const Eigen::Vector3d turned = a_from_b.linear() * moved.normal;
      if (turned.dot(partner.normal) < min_cosine_) continue;
      const Eigen::Vector3d normal = world_from_a.linear() * (turned + partner.normal).normalized();
      add(world_from_a * in_a, normal,
          normal.dot(world_from_a.linear() * (in_a - partner.center_m)), scales, system);
    }
    if (residuals_.size() - residuals_before < static_cast<std::size_t>(options_.min_pairs)) {
      residuals_.resize(residuals_before);
      return std::nullopt;
    }
    return system;
  }

  void add(const Eigen::Vector3d& point_m,
           const Eigen::Vector3d& normal,
           double residual_m,
           const Scales& scales,
           PairSystem& system) {
    const double scaled = residual_m / scales.lorentz_m;
    const double weight = 1.0 / (1.0 + 0.5 * scaled * scaled);
    Vector6d jacobian;
    jacobian << point_m.cross(normal), normal;
    system.information.noalias() += weight * jacobian * jacobian.transpose();
    system.gradient += (weight * residual_m) * jacobian;
    residuals_.push_back(std::abs(residual_m));
  }

  RegistrationOptions options_;
  double min_cosine_;
  std::vector<std::unique_ptr<IndexedScene>> scenes_;
  std::vector<double> residuals_;
  RegistrationResult result_;
};

}  // namespace

std::vector<Surfel> find_surfels(const ScenePoints& scene, const SurfelOptions& options) {
  validate(options, "surfels");
  const auto block = static_cast<std::size_t>(options.block_cells);
  const double needed = options.min_filled * static_cast<double>(block * block);
  const double max_thickness2 = options.max_thickness_m * options.max_thickness_m;
  const double max_length2 = options.max_half_length_m * options.max_half_length_m;
  std::vector<Surfel> surfels;
  surfels.reserve(scene.points_m.size() / (block * block));
  for (std::size_t row = 0; row + block <= scene.rows; row += block) {
    for (std::size_t column = 0; column + block <= scene.columns; column += block) {
      Eigen::Vector3d reference = Eigen::Vector3d::Zero();
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
      double count = 0.0;
      for (std::size_t r = row; r < row + block; ++r) {
        for (std::size_t c = column; c < column + block; ++c) {
          if (scene.valid[scene.index(r, c)] == 0) continue;
          const Eigen::Vector3d point = scene.points_m[scene.index(r, c)].cast<double>();
          if (count == 0.0) reference = point;
          const Eigen::Vector3d offset = point - reference;
          sum += offset;
          squares.noalias() += offset * offset.transpose();
          count += 1.0;
        }
      }
      if (count < needed || count < 4.0) continue;
      const Eigen::Vector3d mean = sum / count;
      const Eigen::Matrix3d covariance = squares / count - mean * mean.transpose();
      if (covariance.trace() > 2.0 * max_length2) continue;
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
      solver.computeDirect(covariance);
      // A line of points has no plane.
      if (solver.eigenvalues()[0] > max_thickness2 ||
          solver.eigenvalues()[1] < 4.0 * solver.eigenvalues()[0]) {
        continue;
      }
      Surfel surfel{reference + mean, solver.eigenvectors().col(0)};
      const Eigen::Vector3d origin = scene.origins_m[row].cast<double>();
      if (surfel.normal.dot(surfel.center_m - origin) > 0.0) surfel.normal = -surfel.normal;
      surfels.push_back(surfel);
    }
  }
  return surfels;
}

RegistrationResult register_scenes(const std::vector<ScenePoints>& placed,
                                   const RegistrationOptions& options) {
  return Registrar(placed, options).run();
}

}  // namespace marco::mapping3d
