#include "slam/back_end/graph/robust_start.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "slam/back_end/graph/sparse_normal_equations.hpp"

namespace marco::slam {
namespace {

constexpr double kGrowth = 1.6;
constexpr int kMaxRounds = 80;
constexpr double kTolerance = 1e-8;
constexpr int kMaxSolverIterations = 2000;
// Translations are judged with rotations that do not know them yet: only what is far off is wrong.
constexpr double kTranslationSlack = 2.0;
// A wrong loop bends the angles around it and hides half of its own error: better too strict, since
// what fits in the end is taken in again.
constexpr double kRotationSlack = 0.2;

using Vectors = std::vector<Eigen::Vector2d>;

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

struct Robust {
  std::function<Vectors(const std::vector<double>& weights)> solve;
  std::function<double(const Vectors& solution, const PoseGraphEdge& edge)> chi2;
};

// Graduated non-convexity; `weights` are where it starts and ends.
Vectors solve_robustly(const std::vector<PoseGraphEdge>& edges,
                       const Robust& problem,
                       double limit,
                       std::vector<double>& weights) {
  Vectors solution = problem.solve(weights);
  std::vector<double> chi2(edges.size(), 0.0);
  const std::vector<double> at_first = weights;
  const auto judge = [&] {
    for (std::size_t i = 0; i < edges.size(); ++i) {
      chi2[i] = at_first[i] > 0.0 ? problem.chi2(solution, edges[i]) : 0.0;
    }
  };
  judge();
  double mu = first_mu(edges, chi2, limit);
  for (int round = 0; round < kMaxRounds && mu > 0.0; ++round) {
    const bool undecided = graduate(edges, chi2, limit, mu, weights);
    for (std::size_t i = 0; i < edges.size(); ++i) weights[i] *= at_first[i];
    solution = problem.solve(weights);
    judge();
    if (!undecided && mu > 1.0) break;
    mu *= kGrowth;
  }
  for (double& weight : weights) weight = weight > 0.5 ? 1.0 : 0.0;
  return solution;
}

// The chain of consecutive nodes, and how uncertain it is from its start on.
struct Chain {
  std::vector<Pose2> poses;
  std::vector<double> turn_variance, shift_variance;  // summed along the way

  Chain(std::size_t nodes, const std::vector<PoseGraphEdge>& edges)
      : poses(nodes), turn_variance(nodes, 0.0), shift_variance(nodes, 0.0) {
    std::vector<const PoseGraphEdge*> to_next(nodes, nullptr);
    for (const PoseGraphEdge& edge : edges) {
      if (edge.to == edge.from + 1 && !edge.is_loop) {
        to_next[static_cast<std::size_t>(edge.from)] = &edge;
      }
    }
    for (std::size_t i = 0; i + 1 < nodes; ++i) {
      const PoseGraphEdge* edge = to_next[i];
      poses[i + 1] = edge == nullptr ? poses[i] : poses[i] * edge->from_from_to;
      turn_variance[i + 1] = turn_variance[i] + turn_variance_of(edge);
      shift_variance[i + 1] = shift_variance[i] + shift_variance_of(edge);
    }
  }
  static double turn_variance_of(const PoseGraphEdge* edge) {
    return edge == nullptr ? 1e6 : 1.0 / edge->information(2, 2);
  }
  static double shift_variance_of(const PoseGraphEdge* edge) {
    return edge == nullptr ? 1e6 : 1.0 / edge->information(0, 0) + 1.0 / edge->information(1, 1);
  }
};

// Whether two loops and the ways between their ends, a short cycle, lead back to the start.
bool agree(const Chain& chain, const PoseGraphEdge& a, const PoseGraphEdge& b) {
  constexpr double kLimit = 9.0;  // 3 sigma
  const auto at = [](int node) { return static_cast<std::size_t>(node); };
  const Pose2 old_step = between(chain.poses[at(a.from)], chain.poses[at(b.from)]);
  const Pose2 new_step = between(chain.poses[at(a.to)], chain.poses[at(b.to)]);
  const Pose2 cycle = between(a.from_from_to * new_step, old_step * b.from_from_to);
  const double way_turn =
      std::abs(chain.turn_variance[at(a.from)] - chain.turn_variance[at(b.from)]) +
      std::abs(chain.turn_variance[at(a.to)] - chain.turn_variance[at(b.to)]);
  const double turn = way_turn + Chain::turn_variance_of(&a) + Chain::turn_variance_of(&b);
  const double lever2 = old_step.translation_m().squaredNorm() +
                        new_step.translation_m().squaredNorm() +
                        b.from_from_to.translation_m().squaredNorm();
  const double shift =
      std::abs(chain.shift_variance[at(a.from)] - chain.shift_variance[at(b.from)]) +
      std::abs(chain.shift_variance[at(a.to)] - chain.shift_variance[at(b.to)]) +
      Chain::shift_variance_of(&a) + Chain::shift_variance_of(&b) + turn * lever2;
  return cycle.theta_rad * cycle.theta_rad < kLimit * turn &&
         cycle.translation_m().squaredNorm() < kLimit * shift;
}

// Weights with 1 for loops that another one nearby agrees with. Wrong loops are rarely alone in
// being wrong, but they are wrong each in its own way.
std::vector<double> trusted(std::size_t nodes, const std::vector<PoseGraphEdge>& edges) {
  constexpr int kNear = 20;
  constexpr double kEnough = 0.4;
  const Chain chain(nodes, edges);
  struct Loop {
    PoseGraphEdge edge;
    std::size_t index;
  };
  std::vector<Loop> loops;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    PoseGraphEdge edge = edges[i];
    if (!edge.is_loop) continue;
    if (edge.from > edge.to) {
      std::swap(edge.from, edge.to);
      edge.from_from_to = edge.from_from_to.inverse();
    }
    loops.push_back({edge, i});
  }
  std::sort(loops.begin(), loops.end(), [](const Loop& a, const Loop& b) {
    return a.edge.from != b.edge.from ? a.edge.from < b.edge.from : a.index < b.index;
  });
  std::vector<double> weights(edges.size(), 1.0);
  for (const Loop& loop : loops) weights[loop.index] = 0.0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < loops.size(); ++i) {
    for (std::size_t k = i + 1;
         k < loops.size() && loops[k].edge.from - loops[i].edge.from <= kNear; ++k) {
      if (std::abs(loops[k].edge.to - loops[i].edge.to) > kNear) continue;
      if (!agree(chain, loops[i].edge, loops[k].edge)) continue;
      for (const std::size_t index : {loops[i].index, loops[k].index}) {
        count += weights[index] == 0.0 ? 1 : 0;
        weights[index] = 1.0;
      }
    }
  }
  // Where loops are few they stand alone, and say nothing of each other.
  if (static_cast<double>(count) < kEnough * static_cast<double>(loops.size())) {
    std::fill(weights.begin(), weights.end(), 1.0);
  }
  return weights;
}

Pose2 facing(const Eigen::Vector2d& heading) {
  return {0.0, 0.0, std::atan2(heading.y(), heading.x())};
}

}  // namespace

double first_mu(const std::vector<PoseGraphEdge>& edges,
                const std::vector<double>& chi2,
                double limit) {
  double worst = 0.0;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    if (edges[i].is_loop) worst = std::max(worst, chi2[i]);
  }
  return worst > limit ? limit / (2.0 * worst - limit) : 0.0;
}

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

RobustStart robust_start(const Pose2& first,
                         std::size_t nodes,
                         const std::vector<PoseGraphEdge>& edges,
                         double loop_rejection_chi2) {
  RobustStart start;
  start.weights = trusted(nodes, edges);
  const auto at = [](const Vectors& values, int node) -> const Eigen::Vector2d& {
    return values[static_cast<std::size_t>(node)];
  };
  // Rotations: (cos_j, sin_j) = R(theta_z) (cos_i, sin_i), relaxed to any two numbers, say how
  // often each angle goes round; from there on the angles themselves are linear.
  std::vector<double> angles_rad;
  const auto angle = [&](int node) -> double& {
    return angles_rad[static_cast<std::size_t>(node)];
  };
  const auto off_rad = [&](const PoseGraphEdge& edge) {
    return normalize_angle(angle(edge.from) + edge.from_from_to.theta_rad - angle(edge.to));
  };
  const Eigen::Vector2d first_heading(std::cos(first.theta_rad), std::sin(first.theta_rad));
  Robust rotations;
  rotations.solve = [&](const std::vector<double>& weights) {
    if (angles_rad.empty()) {
      LinearGraph graph(nodes, first_heading);
      for (std::size_t i = 0; i < edges.size(); ++i) {
        graph.add(edges[i], edges[i].from_from_to.rotation(), Eigen::Vector2d::Zero(),
                  weights[i] * edges[i].information(2, 2));
      }
      for (const Eigen::Vector2d& heading : graph.solve()) {
        angles_rad.push_back(std::atan2(heading.y(), heading.x()));
      }
    }
    LinearGraph graph(nodes, Eigen::Vector2d::Zero());
    for (std::size_t i = 0; i < edges.size(); ++i) {
      graph.add(edges[i], Eigen::Matrix2d::Identity(), {off_rad(edges[i]), 0.0},
                weights[i] * edges[i].information(2, 2));
    }
    const Vectors moves = graph.solve();
    Vectors headings;
    for (std::size_t node = 0; node < nodes; ++node) {
      angles_rad[node] += moves[node].x();
      headings.emplace_back(std::cos(angles_rad[node]), std::sin(angles_rad[node]));
    }
    return headings;
  };
  rotations.chi2 = [&](const Vectors&, const PoseGraphEdge& edge) {
    return off_rad(edge) * off_rad(edge) * edge.information(2, 2);
  };
  Vectors headings =
      solve_robustly(edges, rotations, kRotationSlack * loop_rejection_chi2, start.weights);
  const std::vector<double> fit_rotations = start.weights;
  // Translations, given these.
  const auto step = [&](const PoseGraphEdge& edge) {
    return Eigen::Vector2d(facing(at(headings, edge.from)).rotation() *
                           edge.from_from_to.translation_m());
  };
  const auto information = [](const PoseGraphEdge& edge) {
    return 0.5 * (edge.information(0, 0) + edge.information(1, 1));
  };
  Robust translations;
  translations.solve = [&](const std::vector<double>& weights) {
    LinearGraph graph(nodes, first.translation_m());
    for (std::size_t i = 0; i < edges.size(); ++i) {
      graph.add(edges[i], Eigen::Matrix2d::Identity(), step(edges[i]),
                weights[i] * information(edges[i]));
    }
    return graph.solve();
  };
  translations.chi2 = [&](const Vectors& positions, const PoseGraphEdge& edge) {
    return (at(positions, edge.to) - at(positions, edge.from) - step(edge)).squaredNorm() *
           information(edge);
  };
  Vectors positions =
      solve_robustly(edges, translations, kTranslationSlack * loop_rejection_chi2, start.weights);
  // A wrong loop that happens to fit the rotations has bent them until now.
  if (start.weights != fit_rotations) {
    headings = rotations.solve(start.weights);
    positions = translations.solve(start.weights);
  }
  for (std::size_t node = 0; node < nodes; ++node) {
    Pose2 pose = facing(headings[node]);
    pose.x_m = positions[node].x();
    pose.y_m = positions[node].y();
    start.poses.push_back(pose);
  }
  return start;
}

}  // namespace marco::slam
