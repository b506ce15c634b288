#include "slam/back_end/graph/loop_choice.hpp"

#include <algorithm>
#include <cmath>

#include "slam/back_end/graph/edge_judgement.hpp"
#include "slam/back_end/graph/robust_start.hpp"

namespace marco::slam {
namespace {

// How much farther off than its limit a loop may be at first, before the rest has settled.
constexpr double kFirstSlack = 64.0, kStartSlack = 16.0;

// So few loops can be tried one by one.
constexpr std::ptrdiff_t kFewLoops = 64;

bool is_in(const std::vector<double>& weights, std::size_t edge) { return weights[edge] > 0.0; }

}  // namespace

PoseGraphResult LoopChoice::run() {
  if (graph_.node_count() < 2) return graph_.optimize();
  const double limit = options_.loop_rejection_chi2;
  const std::vector<Pose2> before = graph_.poses();
  PoseGraphResult best = optimize_trimmed(fitting_edges(kFirstSlack), kFirstSlack);
  if (all_agree(best)) return best;
  best = choose_loops(best, limit);
  std::vector<Pose2> best_poses = graph_.poses();
  const auto keep_better = [&](const PoseGraphResult& other) {
    if (choice_cost(other, limit) < choice_cost(best, limit)) {
      best = other;
      best_poses = graph_.poses();
    }
  };
  const RobustStart start =
      robust_start(before.front(), graph_.poses().size(), graph_.edges(), limit);
  graph_.set_poses(start.poses);
  keep_better(choose_loops(optimize_trimmed(start.weights, kStartSlack), limit));
  const auto loops = std::count_if(graph_.edges().begin(), graph_.edges().end(),
                                   [](const PoseGraphEdge& edge) { return edge.is_loop; });
  if (loops <= kFewLoops) {
    graph_.set_poses(before);
    keep_better(choose_loops(try_one_by_one(), limit));
  }
  graph_.set_poses(best_poses);
  // Loops left out together may fit together, now that the wrong ones are gone.
  keep_better(choose_loops(optimize_trimmed(fitting_edges(kStartSlack), kStartSlack), limit));
  graph_.set_poses(best_poses);
  return choose_loops(best, limit_by_noise(best));
}

bool LoopChoice::all_agree(const PoseGraphResult& result) const {
  const std::vector<bool>& is_inlier = result.edge_is_inlier;
  if (std::find(is_inlier.begin(), is_inlier.end(), false) != is_inlier.end()) return false;
  const std::vector<double> distance2 = squared_mahalanobis_distances(is_inlier);
  return std::all_of(distance2.begin(), distance2.end(),
                     [this](double of_one) { return of_one <= options_.loop_rejection_chi2; });
}

double LoopChoice::limit_by_noise(const PoseGraphResult& result) const {
  // Three quarters of honest ones lie below (chi2 of 3 degrees of freedom); twice as many standard
  // deviations are let pass, since the tails of real noise are longer.
  constexpr double kSlack = 4.0, kLeast = 0.05;
  const std::vector<double> distance2 = squared_mahalanobis_distances(result.edge_is_inlier);
  std::vector<double> of_loops;
  for (std::size_t i = 0; i < graph_.edges().size(); ++i) {
    if (graph_.edges()[i].is_loop && result.edge_is_inlier[i]) of_loops.push_back(distance2[i]);
  }
  if (of_loops.empty()) return options_.loop_rejection_chi2;
  const auto quartile = of_loops.begin() + 3 * static_cast<std::ptrdiff_t>(of_loops.size()) / 4;
  std::nth_element(of_loops.begin(), quartile, of_loops.end());
  return options_.loop_rejection_chi2 *
         std::clamp(kSlack * *quartile / kChi2Dof3Quantile75, kLeast, 1.0);
}

double LoopChoice::choice_cost(const PoseGraphResult& result, double limit) {
  const auto out = std::count(result.edge_is_inlier.begin(), result.edge_is_inlier.end(), false);
  return result.chi2 + limit * static_cast<double>(out);
}

PoseGraphResult LoopChoice::try_one_by_one() {
  std::vector<double> weights(graph_.edges().size(), 1.0);
  std::vector<std::size_t> loops;
  for (std::size_t i = 0; i < graph_.edges().size(); ++i) {
    if (!graph_.edges()[i].is_loop) continue;
    weights[i] = 0.0;
    loops.push_back(i);
  }
  // The shorter the way between its ends, the surer is what it is held against, and the more so
  // once the shorter ones are in.
  const auto span = [this](std::size_t i) {
    return std::abs(graph_.edges()[i].to - graph_.edges()[i].from);
  };
  std::stable_sort(loops.begin(), loops.end(),
                   [&](std::size_t a, std::size_t b) { return span(a) < span(b); });
  PoseGraphResult result = graph_.optimize_weighted(weights, options_.rough_relative_decrease);
  for (const std::size_t loop : loops) {
    const std::vector<Pose2> without = graph_.poses();
    weights[loop] = 1.0;
    const PoseGraphResult with =
        graph_.optimize_weighted(weights, options_.rough_relative_decrease);
    if (with.chi2 - result.chi2 <= options_.loop_rejection_chi2) {
      result = with;
    } else {
      weights[loop] = 0.0;
      graph_.set_poses(without);
    }
  }
  for (std::size_t i = 0; i < graph_.edges().size(); ++i)
    result.edge_is_inlier[i] = is_in(weights, i);
  return result;
}

PoseGraphResult LoopChoice::choose_loops(PoseGraphResult chosen, double limit) {
  constexpr int kMaxRounds = 40;  // against hanging
  bool one_at_a_time = false;
  for (int round = 0; round < kMaxRounds; ++round) {
    std::vector<bool> is_inlier = better_choice(chosen.edge_is_inlier, limit, one_at_a_time);
    if (is_inlier == chosen.edge_is_inlier) break;
    const std::vector<Pose2> before = graph_.poses();
    PoseGraphResult other = graph_.optimize_weighted(
        std::vector<double>(is_inlier.begin(), is_inlier.end()), options_.min_relative_decrease);
    other.edge_is_inlier = std::move(is_inlier);
    if (choice_cost(other, limit) < choice_cost(chosen, limit)) {
      chosen = std::move(other);
      continue;
    }
    graph_.set_poses(before);
    if (one_at_a_time) break;
    one_at_a_time = true;
  }
  return chosen;
}

std::vector<bool> LoopChoice::better_choice(std::vector<bool> is_inlier,
                                            double limit,
                                            bool one_at_a_time) const {
  // Of what exceeds the limit, the worst go at once; others may be right without them.
  constexpr double kWorst = 0.25;
  const std::vector<double> distance2 = squared_mahalanobis_distances(is_inlier);
  // By how much the truncated cost falls when a loop goes in or out.
  const auto gain = [&](std::size_t i) {
    if (!graph_.edges()[i].is_loop) return 0.0;
    return is_inlier[i] ? distance2[i] - limit : limit - distance2[i];
  };
  double most = 0.0, worst = 0.0;
  for (std::size_t i = 0; i < graph_.edges().size(); ++i) {
    most = std::max(most, gain(i));
    if (is_inlier[i]) worst = std::max(worst, distance2[i]);
  }
  std::vector<bool> better = is_inlier;
  for (std::size_t i = 0; i < graph_.edges().size(); ++i) {
    if (gain(i) <= 0.0) continue;
    const bool now =
        one_at_a_time ? gain(i) == most : !is_inlier[i] || distance2[i] >= kWorst * worst;
    if (now) better[i] = !is_inlier[i];
  }
  return better;
}

std::vector<double> LoopChoice::squared_mahalanobis_distances(
    const std::vector<bool>& is_inlier) const {
  std::vector<double> result;
  for (const EdgeJudgement& edge :
       judge_edges(graph_, is_inlier, JudgedEdges::loops, options_.loop_rejection_chi2)) {
    result.push_back(edge.squared_distance);
  }
  return result;
}

std::vector<double> LoopChoice::fitting_edges(double slack) const {
  std::vector<double> weights(graph_.edges().size(), 1.0);
  for (std::size_t i = 0; i < graph_.edges().size(); ++i) {
    const bool wrong = graph_.edges()[i].is_loop &&
                       graph_.edge_chi2(graph_.edges()[i]) > slack * options_.loop_rejection_chi2;
    weights[i] = wrong ? 0.0 : 1.0;
  }
  return weights;
}

PoseGraphResult LoopChoice::optimize_trimmed(std::vector<double> weights, double slack) {
  // Loops that were left out may turn out to fit, and the other way round, once the rest agrees.
  constexpr int kMaxRounds = 10;
  constexpr double kShrink = 0.25;
  PoseGraphResult result;
  for (int round = 0; round < kMaxRounds; ++round) {
    result = graph_.optimize_weighted(
        weights, slack > 1.0 ? options_.rough_relative_decrease : options_.min_relative_decrease);
    const std::vector<double> before = weights;
    weights = fitting_edges(slack);
    if (slack <= 1.0 && weights == before) break;
    slack = std::max(1.0, slack * kShrink);
  }
  for (std::size_t i = 0; i < graph_.edges().size(); ++i)
    result.edge_is_inlier[i] = weights[i] > 0.0;
  return result;
}

}  // namespace marco::slam
