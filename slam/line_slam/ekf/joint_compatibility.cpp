#include "slam/line_slam/ekf/joint_compatibility.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

namespace marco::slam {
namespace {

using Eigen::Index;

// Inverse of the normal distribution by Newton's method on erfc.
double normal_quantile(double probability) {
  double x = 0.0;
  for (int i = 0; i < 60; ++i) {
    const double error = 0.5 * std::erfc(-x / std::sqrt(2.0)) - probability;
    const double density = std::exp(-0.5 * x * x) / std::sqrt(2.0 * 3.14159265358979323846);
    const double step = std::clamp(error / std::max(density, 1e-12), -0.5, 0.5);
    x -= step;
    if (std::abs(step) < 1e-12) break;
  }
  return x;
}

// Wilson and Hilferty's approximation.
double limit_of(int degrees_of_freedom, double quantile) {
  const double k = degrees_of_freedom;
  const double spread = 2.0 / (9.0 * k);
  const double root = 1.0 - spread + quantile * std::sqrt(spread);
  return k * root * root * root;
}

/// The joint innovation of a growing set of pairings: the Cholesky factor of its covariance S and
/// the whitened innovation, two rows per pairing.
class JointInnovation {
 public:
  JointInnovation(const std::vector<Pairing>& candidates,
                  const CrossCovariance& cross_covariance,
                  int most_pairings)
      : candidates_(candidates), cross_covariance_(cross_covariance) {
    const Eigen::Index most_rows = 2 * Eigen::Index{most_pairings};
    factor_.setZero(most_rows, most_rows);
    whitened_.setZero(most_rows);
  }

  int count() const { return static_cast<int>(pairings_.size()); }
  void pop() { pairings_.pop_back(); }

  /// Adds a pairing. @returns what it adds to the squared Mahalanobis distance of the set.
  double push(int candidate) {
    const Pairing& pairing = candidates_[static_cast<std::size_t>(candidate)];
    const Index size = 2 * static_cast<Index>(pairings_.size());
    Eigen::Matrix<double, Eigen::Dynamic, 2> cross(size, 2);
    for (std::size_t k = 0; k < pairings_.size(); ++k) {
      cross.middleRows<2>(2 * static_cast<Index>(k)) = cross_covariance_(pairings_[k], candidate);
    }
    for (Index i = 0; i < size; ++i) {  // L^-1 cross
      for (Index k = 0; k < i; ++k) cross.row(i) -= factor_(i, k) * cross.row(k);
      cross.row(i) /= factor_(i, i);
    }
    const Eigen::Matrix2d rest = pairing.covariance - cross.transpose().lazyProduct(cross);
    const double first = std::sqrt(rest(0, 0)), below = rest(1, 0) / first;
    const double second = std::sqrt(rest(1, 1) - below * below);
    factor_.block(size, 0, 2, size) = cross.transpose();
    factor_.block<2, 2>(size, size) << first, 0.0, below, second;
    const Eigen::Vector2d left =
        pairing.innovation - cross.transpose().lazyProduct(whitened_.head(size));
    const double y = left.x() / first;
    const Eigen::Vector2d white(y, (left.y() - below * y) / second);
    whitened_.segment<2>(size) = white;
    pairings_.push_back(candidate);
    const double added = white.squaredNorm();
    return std::isfinite(added) ? added : std::numeric_limits<double>::infinity();
  }

 private:
  const std::vector<Pairing>& candidates_;
  const CrossCovariance& cross_covariance_;
  std::vector<int> pairings_;
  Eigen::MatrixXd factor_;
  Eigen::VectorXd whitened_;
};

class BranchAndBound {
 public:
  BranchAndBound(const std::vector<Pairing>& candidates,
                 const CrossCovariance& cross_covariance,
                 int num_observations,
                 double probability)
      : candidates_(candidates),
        joint_(candidates, cross_covariance, num_observations),
        of_observation_(num_observations) {
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      of_observation_[static_cast<std::size_t>(candidates[i].observation)].push_back(
          static_cast<int>(i));
    }
    for (auto& list : of_observation_) {
      std::sort(list.begin(), list.end(),
                [&](int a, int b) { return of(a).distance2 < of(b).distance2; });
    }
    const double quantile = normal_quantile(probability);
    for (int k = 0; k <= num_observations; ++k) {
      limits_.push_back(k == 0 ? 0.0 : limit_of(2 * k, quantile));
    }
    possible_after_.assign(of_observation_.size() + 1, 0);
    for (std::size_t i = of_observation_.size(); i-- > 0;) {
      possible_after_[i] = possible_after_[i + 1] + (of_observation_[i].empty() ? 0 : 1);
    }
    chosen_.assign(of_observation_.size(), -1);
    best_ = chosen_;
  }

  std::vector<int> run() {
    descend(0, 0.0);
    return best_;
  }

 private:
  void descend(std::size_t observation, double distance2) {
    const int count = joint_.count();
    if (++nodes_ > kMaxNodes && best_count_ > 0) return;
    if (observation == of_observation_.size()) {
      if (may_win(count, distance2)) {
        best_count_ = count;
        best_distance2_ = distance2;
        best_ = chosen_;
      }
      return;
    }
    for (const int candidate : of_observation_[observation]) {
      if (!may_win(count + 1 + possible_after_[observation + 1], distance2)) break;
      const int once = of(candidate).only_once;
      if (once != Pairing::kAnyTimes && taken_.contains(once)) continue;
      const double with = distance2 + joint_.push(candidate);
      if (with <= limits_[static_cast<std::size_t>(count) + 1]) {
        chosen_[observation] = candidate;
        taken_.insert(once);
        descend(observation + 1, with);
        taken_.erase(once);
        chosen_[observation] = -1;
      }
      joint_.pop();
    }
    if (may_win(count + possible_after_[observation + 1], distance2)) {
      descend(observation + 1, distance2);
    }
  }

  bool may_win(int reachable, double distance2) const {
    return reachable > best_count_ || (reachable == best_count_ && distance2 < best_distance2_);
  }

  const Pairing& of(int candidate) const {
    return candidates_[static_cast<std::size_t>(candidate)];
  }

  static constexpr int kMaxNodes = 2000;  // then the best pairing so far; bounds a scan's time
  const std::vector<Pairing>& candidates_;
  std::set<int> taken_;  ///< what may be paired only once, and is
  JointInnovation joint_;
  std::vector<std::vector<int>> of_observation_;  ///< candidates, nearest first
  std::vector<double> limits_;                    ///< of the joint distance, by count of pairings
  std::vector<int> possible_after_;               ///< later observations that have candidates
  std::vector<int> chosen_, best_;
  int best_count_ = 0;
  double best_distance2_ = 0.0;
  int nodes_ = 0;
};

}  // namespace

double chi_square_limit(int degrees_of_freedom, double probability) {
  return limit_of(degrees_of_freedom, normal_quantile(probability));
}

double individual_distance2(const EkfState& state, const Candidate& candidate) {
  const SparseRows& rows = candidate.rows;
  const SparseRows::Square root = inverse_root(state.innovation_covariance(rows));
  const double distance2 = root.lazyProduct(rows.innovation).squaredNorm();
  return std::isfinite(distance2) ? distance2 : std::numeric_limits<double>::infinity();
}

std::vector<int> joint_compatibility(const std::vector<Pairing>& candidates,
                                     const CrossCovariance& cross_covariance,
                                     int num_observations,
                                     double probability) {
  return BranchAndBound(candidates, cross_covariance, num_observations, probability).run();
}

std::vector<int> joint_compatibility(const EkfState& state,
                                     const std::vector<Candidate>& candidates,
                                     int num_observations,
                                     double probability) {
  std::vector<Pairing> pairings;
  for (const Candidate& candidate : candidates) {
    const SparseRows& rows = candidate.rows;
    pairings.push_back({candidate.observation, Pairing::kAnyTimes, rows.innovation.head<2>(),
                        state.covariance_between(rows, rows) + rows.noise,
                        individual_distance2(state, candidate)});
  }
  const auto rows = [&](int i) -> const SparseRows& {
    return candidates[static_cast<std::size_t>(i)].rows;
  };
  return joint_compatibility(
      pairings,
      [&](int a, int b) -> Eigen::Matrix2d { return state.covariance_between(rows(a), rows(b)); },
      num_observations, probability);
}

}  // namespace marco::slam
