#include "slam/back_end/graph/robust_start.hpp"

#include <algorithm>
#include <cmath>

#include "slam/back_end/graph/loop_consistency.hpp"
#include "slam/back_end/graph/sparse_normal_equations.hpp"

namespace marco::slam {
namespace {

// By so much the kernel changes from round to round; all rounds change it by 1e16.
constexpr double kGrowth = 1.6;
constexpr int kMaxRounds = 80;
// Of the residual, for conjugate gradients; and against hanging.
constexpr double kTolerance = 1e-8;
constexpr int kMaxSolverIterations = 2000;
// Translations are judged with rotations that do not know them yet: only what is far off is wrong.
constexpr double kTranslationSlack = 2.0;
// A wrong loop bends the angles around it and hides half of its own error: better too strict, since
// what fits in the end is taken in again.
constexpr double kRotationSlack = 0.2;

using Vectors = std::vector<Eigen::Vector2d>;

// The mu to start with, at which the surrogate is convex; 0 when no loop exceeds the limit.
double first_mu(const std::vector<PoseGraphEdge>& edges,
                const std::vector<double>& chi2,
                double limit) {
  double worst = 0.0;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    if (edges[i].is_loop) worst = std::max(worst, chi2[i]);
  }
  return worst > limit ? limit / (2.0 * worst - limit) : 0.0;
}

// Weights of graduated non-convexity with the truncated least squares cost (Yang et al., RA-L
// 2020, eq. 14) for squared residuals `chi2` of the loop edges; the others keep theirs.
// @returns whether some are still undecided.
bool graduate(const std::vector<PoseGraphEdge>& edges,
              const std::vector<double>& chi2,
              double limit,
              double mu,
              std::vector<double>& weights) {
  const double off_above = (mu + 1.0) / mu * limit, on_below = mu / (mu + 1.0) * limit;
  bool undecided = false;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    if (!edges[i].is_loop) continue;
    weights[i] = chi2[i] >= off_above  ? 0.0
                 : chi2[i] <= on_below ? 1.0
                                       : std::sqrt(limit * mu * (mu + 1.0) / chi2[i]) - mu;
    undecided = undecided || (weights[i] > 0.01 && weights[i] < 0.99);
  }
  return undecided;
}

// Least squares of blocks -A u_from + u_to = c, one an edge; u_0 is known.
class LinearGraph {
 public:
  LinearGraph(std::size_t nodes, const Eigen::Vector2d& first) : equations_(nodes), first_(first) {}

  void add(const PoseGraphEdge& edge,
           const Eigen::Matrix2d& a,
           const Eigen::Vector2d& c,
           double weight) {
    if (weight <= 0.0) return;
    const Eigen::Matrix2d one = Eigen::Matrix2d::Identity();
    Eigen::Vector2d known = c;
    if (edge.from == 0) known += a * first_;
    if (edge.to == 0) known -= first_;
    equations_.add_block(edge.from, edge.from, wide_block(weight * a.transpose() * a));
    equations_.add_block(edge.to, edge.to, wide_block(weight * one));
    equations_.add_block(edge.to, edge.from, wide_block(-weight * a));
    equations_.add_gradient(edge.from, wide_vector(-weight * a.transpose() * known));
    equations_.add_gradient(edge.to, wide_vector(weight * known));
  }
  Vectors solve() const {
    const Eigen::VectorXd x = equations_.solve_iteratively(1e-12, kTolerance, kMaxSolverIterations);
    Vectors result{first_};
    for (Eigen::Index at = 0; at < x.size(); at += 3) result.emplace_back(x.segment<2>(at));
    return result;
  }

 private:
  // The third coordinate of the graph's blocks is not used.
  static Eigen::Matrix3d wide_block(const Eigen::Matrix2d& block) {
    Eigen::Matrix3d result = Eigen::Matrix3d::Zero();
    result.topLeftCorner<2, 2>() = block;
    return result;
  }
  static Eigen::Vector3d wide_vector(const Eigen::Vector2d& part) {
    return {part.x(), part.y(), 0.0};
  }

  SparseNormalEquations equations_;
  Eigen::Vector2d first_;
};

// Solves one of the two linear problems with given weights, and judges its edges.
class LinearProblem {
 public:
  virtual ~LinearProblem() = default;
  virtual void solve(const std::vector<double>& weights) = 0;
  virtual double chi2(const PoseGraphEdge& edge) const = 0;
};

// Graduated non-convexity; `weights` are where it starts and ends.
void solve_robustly(const std::vector<PoseGraphEdge>& edges,
                    LinearProblem& problem,
                    double limit,
                    std::vector<double>& weights) {
  problem.solve(weights);
  std::vector<double> chi2(edges.size(), 0.0);
  const std::vector<double> at_first = weights;
  const auto judge = [&] {
    for (std::size_t i = 0; i < edges.size(); ++i) {
      chi2[i] = at_first[i] > 0.0 ? problem.chi2(edges[i]) : 0.0;
    }
  };
  judge();
  double mu = first_mu(edges, chi2, limit);
  for (int round = 0; round < kMaxRounds && mu > 0.0; ++round) {
    const bool undecided = graduate(edges, chi2, limit, mu, weights);
    for (std::size_t i = 0; i < edges.size(); ++i) weights[i] *= at_first[i];
    problem.solve(weights);
    judge();
    if (!undecided && mu > 1.0) break;
    mu *= kGrowth;
  }
  for (double& weight : weights) weight = weight > 0.5 ? 1.0 : 0.0;
}

// Rotations: (cos_j, sin_j) = R(theta_z) (cos_i, sin_i), relaxed to any two numbers, say how often
// each angle goes round; from there on the angles themselves are linear.
class Rotations : public LinearProblem {
 public:
  Rotations(double first_rad, std::size_t nodes, const std::vector<PoseGraphEdge>& edges)
      : first_heading_(std::cos(first_rad), std::sin(first_rad)), nodes_(nodes), edges_(edges) {}

  void solve(const std::vector<double>& weights) override {
    if (angles_rad_.empty()) relax(weights);
    LinearGraph graph(nodes_, Eigen::Vector2d::Zero());
    for (std::size_t i = 0; i < edges_.size(); ++i) {
      graph.add(edges_[i], Eigen::Matrix2d::Identity(), {off_rad(edges_[i]), 0.0},
                weights[i] * edges_[i].information(2, 2));
    }
    const Vectors moves = graph.solve();
    for (std::size_t node = 0; node < nodes_; ++node) angles_rad_[node] += moves[node].x();
  }
  double chi2(const PoseGraphEdge& edge) const override {
    return off_rad(edge) * off_rad(edge) * edge.information(2, 2);
  }
  Pose2 facing(int node) const { return {0.0, 0.0, normalize_angle(angle_rad(node))}; }

 private:
  void relax(const std::vector<double>& weights) {
    LinearGraph graph(nodes_, first_heading_);
    for (std::size_t i = 0; i < edges_.size(); ++i) {
      graph.add(edges_[i], edges_[i].from_from_to.rotation(), Eigen::Vector2d::Zero(),
                weights[i] * edges_[i].information(2, 2));
    }
    for (const Eigen::Vector2d& heading : graph.solve()) {
      angles_rad_.push_back(std::atan2(heading.y(), heading.x()));
    }
  }
  double angle_rad(int node) const { return angles_rad_[static_cast<std::size_t>(node)]; }
  double off_rad(const PoseGraphEdge& edge) const {
    return normalize_angle(angle_rad(edge.from) + edge.from_from_to.theta_rad - angle_rad(edge.to));
  }

  Eigen::Vector2d first_heading_;
  std::size_t nodes_;
  const std::vector<PoseGraphEdge>& edges_;
  std::vector<double> angles_rad_;
};

// Translations, given the rotations.
class Translations : public LinearProblem {
 public:
  Translations(const Eigen::Vector2d& first_m,
               std::size_t nodes,
               const std::vector<PoseGraphEdge>& edges,
               const Rotations& rotations)
      : first_m_(first_m), nodes_(nodes), edges_(edges), rotations_(rotations) {}

  void solve(const std::vector<double>& weights) override {
    LinearGraph graph(nodes_, first_m_);
    for (std::size_t i = 0; i < edges_.size(); ++i) {
      graph.add(edges_[i], Eigen::Matrix2d::Identity(), step_m(edges_[i]),
                weights[i] * information(edges_[i]));
    }
    positions_m_ = graph.solve();
  }
  double chi2(const PoseGraphEdge& edge) const override {
    return (position_m(edge.to) - position_m(edge.from) - step_m(edge)).squaredNorm() *
           information(edge);
  }
  const Eigen::Vector2d& position_m(int node) const {
    return positions_m_[static_cast<std::size_t>(node)];
  }

 private:
  Eigen::Vector2d step_m(const PoseGraphEdge& edge) const {
    return rotations_.facing(edge.from).rotation() * edge.from_from_to.translation_m();
  }
  static double information(const PoseGraphEdge& edge) {
    return 0.5 * (edge.information(0, 0) + edge.information(1, 1));
  }

  Eigen::Vector2d first_m_;
  std::size_t nodes_;
  const std::vector<PoseGraphEdge>& edges_;
  const Rotations& rotations_;
  Vectors positions_m_;
};

}  // namespace

RobustStart robust_start(const Pose2& first,
                         std::size_t nodes,
                         const std::vector<PoseGraphEdge>& edges,
                         double loop_rejection_chi2) {
  RobustStart start;
  start.weights = consistent_loops(nodes, edges);
  Rotations rotations(first.theta_rad, nodes, edges);
  solve_robustly(edges, rotations, kRotationSlack * loop_rejection_chi2, start.weights);
  const std::vector<double> fit_rotations = start.weights;
  Translations translations(first.translation_m(), nodes, edges, rotations);
  solve_robustly(edges, translations, kTranslationSlack * loop_rejection_chi2, start.weights);
  // A wrong loop that happens to fit the rotations has bent them until now.
  if (start.weights != fit_rotations) {
    rotations.solve(start.weights);
    translations.solve(start.weights);
  }
  for (int node = 0; node < static_cast<int>(nodes); ++node) {
    Pose2 pose = rotations.facing(node);
    pose.x_m = translations.position_m(node).x();
    pose.y_m = translations.position_m(node).y();
    start.poses.push_back(pose);
  }
  return start;
}

}  // namespace marco::slam
