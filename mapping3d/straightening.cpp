#include "mapping3d/straightening.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

#include "lcm_tools/base/check.hpp"
#include "mapping3d/sparse_least_squares.hpp"

namespace marco::mapping3d {
namespace {

/// Where each parameter stands in the vector of unknowns: rows of all scenes, six of each body, the
/// range offset.
class StraighteningUnknowns {
 public:
  StraighteningUnknowns(const std::vector<Scene>& scenes, const std::vector<std::size_t>& body_of) {
    for (const Scene& scene : scenes) {
      first_row_.push_back(count_);
      count_ += scene.rows.size();
    }
    for (std::size_t i = 0; i < scenes.size(); ++i) {
      body_of_.push_back(body_of.empty() ? i : body_of[i]);
      bodies_ = std::max(bodies_, body_of_[i] + 1);
    }
    first_body_ = count_;
    count_ += 6 * bodies_ + 1;
  }

  std::size_t row(std::size_t scene, std::size_t row) const { return first_row_[scene] + row; }
  std::size_t body_of(std::size_t scene) const { return body_of_[scene]; }
  std::size_t bodies() const { return bodies_; }
  /// Three turns, then three shifts.
  std::size_t body(std::size_t body) const { return first_body_ + 6 * body; }
  std::size_t range() const { return count_ - 1; }
  std::size_t count() const { return count_; }

 private:
  std::vector<std::size_t> first_row_;  ///< of each scene
  std::vector<std::size_t> body_of_;
  std::size_t bodies_ = 0;
  std::size_t first_body_ = 0;
  std::size_t count_ = 0;
};

/// A scene by the current estimate, registered frame.
struct Swept {
  std::unique_ptr<SurfelIndex> patches;
  /// Of each patch, row by row: the mean of the row's returns, NaN without any.
  std::vector<Eigen::Vector3f> row_means_m;
  std::vector<Eigen::Vector3f> origins_m;  ///< one a row
  std::vector<SweepAxis> axes;             ///< one a row
};

class Straightener {
 public:
  Straightener(const std::vector<Scene>& scenes,
               const RobotBox& robot,
               const std::vector<std::size_t>& body_of,
               const StraighteningOptions& options)
      : scenes_(scenes),
        robot_(robot),
        options_(options),
        association_(options.matching),
        block_(static_cast<std::size_t>(options.matching.surfels.block_cells)),
        unknowns_(scenes, body_of) {
    validate(options, "straightening");
  }

  Straightening run(const std::vector<Pose3>& world_from_placed) {
    Straightening now, given;
    for (const Scene& scene : scenes_) now.turns_rad.emplace_back(scene.rows.size(), 0.0);
    now.world_from_placed = world_from_placed;
    given = now;
    MatchingScales scales = MatchingScales::first(options_.matching);
    for (int i = 0; i < options_.iterations; ++i) {
      std::vector<Equation> equations = residuals(now, scales);
      const std::size_t seen = equations.size();
      if (seen == 0) return given;
      add_priors(now, equations);
      const Eigen::VectorXd step = solve(equations, static_cast<Eigen::Index>(unknowns_.count()));
      if (i == 0) {
        equations.resize(seen);
        now.explained = given.explained = explained(equations, step);
        now.before_m = given.before_m = given.after_m = quantile(residuals_m_, 0.5);
        if (now.explained < options_.min_explained) return given;
      }
      take(step, now);
      scales.shrink(options_.matching);
    }
    residuals(now, {options_.matching.search_start_m, options_.matching.lorentz_end_m});
    now.after_m = quantile(residuals_m_, 0.5);
    now.turn_rms_rad = rms_rad(now.turns_rad);
    // Turns far beyond the prior come from wrong correspondences.
    now.bent = now.after_m <= options_.max_left * now.before_m &&
               now.turn_rms_rad <= 1.5 * deg_to_rad(options_.row_error_deg);
    return now.bent ? now : given;
  }

 private:
  Swept swept(std::size_t scene, const Straightening& now) const {
    Swept result;
    const Scene corrected = straightened(scenes_[scene], now.turns_rad[scene], now.range_m);
    ScenePoints points = place(corrected, robot_);
    move(points, now.world_from_placed[scene]);
    result.patches = std::make_unique<SurfelIndex>(find_surfels(points, options_.matching.surfels));
    for (const Surfel& patch : result.patches->surfels) {
      for (std::size_t row = patch.row; row < patch.row + block_; ++row) {
        const Eigen::Vector3d mean_m = block_mean(points, {row, patch.column, 1, block_})
                                           .value_or(Eigen::Vector3d::Constant(std::nan("")));
        result.row_means_m.push_back(mean_m.cast<float>());
      }
    }
    result.origins_m = std::move(points.origins_m);
    for (std::size_t row = 0; row < corrected.rows.size(); ++row) {
      const SweepAxis in_robot = sweep_axis(scenes_[scene], row);
      const Pose3 from_robot =
          now.world_from_placed[scene] * lift(corrected.rows[row].world_from_robot);
      result.axes.push_back(
          {from_robot.linear() * in_robot.direction, from_robot * in_robot.point_m});
    }
    return result;
  }

  /// Derivative of a point's position along `normal` by the turn of its row.
  static double by_turn(const Swept& scene,
                        std::size_t row,
                        const Eigen::Vector3d& at_m,
                        const Eigen::Vector3d& normal) {
    const SweepAxis& axis = scene.axes[row];
    return normal.dot(axis.direction.cross(at_m - axis.point_m));
  }
  /// The same by the range offset.
  static double by_range(const Swept& scene,
                         std::size_t row,
                         const Eigen::Vector3d& at_m,
                         const Eigen::Vector3d& normal) {
    return normal.dot((at_m - scene.origins_m[row].cast<double>()).normalized());
  }

  std::vector<Equation> residuals(const Straightening& now, const MatchingScales& scales) {
    std::vector<Swept> all;
    pivots_m_.assign(unknowns_.bodies(), Eigen::Vector3d::Zero());
    std::vector<double> counts(unknowns_.bodies(), 0.0);
    for (std::size_t i = 0; i < scenes_.size(); ++i) {
      all.push_back(swept(i, now));
      const std::size_t body = unknowns_.body_of(i);
      for (const Surfel& patch : all[i].patches->surfels) pivots_m_[body] += patch.center_m;
      counts[body] += static_cast<double>(all[i].patches->surfels.size());
    }
    for (std::size_t i = 0; i < counts.size(); ++i) pivots_m_[i] /= std::max(1.0, counts[i]);
    std::vector<Equation> equations;
    residuals_m_.clear();
    for (std::size_t a = 0; a < all.size(); ++a) {
      for (std::size_t b = 0; b < all.size(); ++b) {
        Eigen::AlignedBox3d box = all[b].patches->box;
        if (a == b || box.isEmpty() || all[a].patches->box.isEmpty()) continue;
        box.min().array() -= scales.search_m;
        box.max().array() += scales.search_m;
        if (box.intersects(all[a].patches->box)) compare({all, a, b}, scales, equations);
      }
    }
    return equations;
  }

  struct Pair {
    const std::vector<Swept>& all;
    std::size_t target;
    std::size_t source;
  };

  /// Each row of each surfel of the source against the nearest surfel of the target.
  void compare(const Pair& pair, const MatchingScales& scales, std::vector<Equation>& equations) {
    const SurfelIndex& target = *pair.all[pair.target].patches;
    const Swept& source = pair.all[pair.source];
    // With many scenes each surfel has many correspondences.
    const std::size_t stride = 1 + pair.all.size() / 8;
    for (std::size_t i = 0; i < source.patches->surfels.size(); i += stride) {
      const Surfel& patch = source.patches->surfels[i];
      for (std::size_t k = 0; k < block_; ++k) {
        const Eigen::Vector3d at_m = source.row_means_m[i * block_ + k].cast<double>();
        if (at_m.hasNaN()) continue;
        const auto found = association_.find(target, at_m, patch.normal, scales.search_m);
        if (!found) continue;
        equations.push_back(equation(pair, {at_m, patch.row + k, *found}, scales.lorentz_m));
      }
    }
  }

  struct Piece {
    Eigen::Vector3d at_m;
    std::size_t row;
    SurfelCorrespondence found;
  };

  Equation equation(const Pair& pair, const Piece& piece, double lorentz_m) {
    const Swept& target = pair.all[pair.target];
    const Swept& source = pair.all[pair.source];
    const Surfel& partner = target.patches->surfels[piece.found.partner];
    const Eigen::Vector3d& normal = piece.found.normal;
    residuals_m_.push_back(std::abs(piece.found.residual_m));
    Equation result;
    result.residual = static_cast<float>(piece.found.residual_m);
    result.weight = static_cast<float>(
        association_.weight(piece.found.residual_m, lorentz_m, partner.thickness2_m2()));
    result.add(unknowns_.row(pair.source, piece.row),
               by_turn(source, piece.row, piece.at_m, normal));
    for (std::size_t row = partner.row; row < partner.row + block_; ++row) {
      if (result.count + 13 >= Equation::kMost) break;
      result.add(unknowns_.row(pair.target, row),
                 -by_turn(target, row, partner.center_m, normal) / static_cast<double>(block_));
    }
    result.add(unknowns_.range(), by_range(source, piece.row, piece.at_m, normal) -
                                      by_range(target, partner.row, partner.center_m, normal));
    const std::size_t a = unknowns_.body_of(pair.target), b = unknowns_.body_of(pair.source);
    if (a == b) return result;
    add_body(b, piece.at_m, normal, result);
    add_body(a, piece.at_m, -normal, result);
    return result;
  }

  void add_body(std::size_t body,
                const Eigen::Vector3d& at_m,
                const Eigen::Vector3d& normal,
                Equation& equation) const {
    if (body == 0) return;  // fixed
    const Eigen::Vector3d turn = (at_m - pivots_m_[body]).cross(normal);
    for (std::size_t k = 0; k < 3; ++k) {
      const auto axis = static_cast<Eigen::Index>(k);
      equation.add(unknowns_.body(body) + k, turn[axis]);
      equation.add(unknowns_.body(body) + 3 + k, normal[axis]);
    }
  }

  void add_priors(const Straightening& now, std::vector<Equation>& equations) const {
    const double variance_m2 = options_.error_m * options_.error_m;
    const auto prior = [&](double value, double sigma) {
      Equation equation;
      equation.residual = static_cast<float>(value);
      equation.weight = static_cast<float>(variance_m2 / (sigma * sigma));
      return equation;
    };
    const double row_rad = deg_to_rad(options_.row_error_deg);
    const double step_rad = deg_to_rad(options_.row_step_deg);
    for (std::size_t i = 0; i < scenes_.size(); ++i) {
      const RowTurns& turns = now.turns_rad[i];
      for (std::size_t row = 0; row < turns.size(); ++row) {
        Equation small = prior(turns[row], row_rad);
        small.add(unknowns_.row(i, row), 1.0);
        equations.push_back(small);
        if (row + 1 == turns.size()) continue;
        const double jump = turns[row + 1] - turns[row];
        Equation smooth =
            prior(jump, step_rad * std::sqrt(1.0 + 0.5 * jump * jump / (step_rad * step_rad)));
        smooth.add(unknowns_.row(i, row), -1.0);
        smooth.add(unknowns_.row(i, row + 1), 1.0);
        equations.push_back(smooth);
      }
    }
    Equation zero = prior(now.range_m, options_.range_error_m);
    zero.add(unknowns_.range(), 1.0);
    equations.push_back(zero);
  }

  void take(const Eigen::VectorXd& step, Straightening& now) const {
    const auto at = [&step](std::size_t unknown) {
      return step[static_cast<Eigen::Index>(unknown)];
    };
    for (std::size_t i = 0; i < scenes_.size(); ++i) {
      RowTurns& turns = now.turns_rad[i];
      for (std::size_t row = 0; row < turns.size(); ++row) turns[row] += at(unknowns_.row(i, row));
      const std::size_t body = unknowns_.body_of(i);
      const auto first = static_cast<Eigen::Index>(unknowns_.body(body));
      Pose3 moved = turn_about(pivots_m_[body], step.segment<3>(first));
      moved.translation() += step.segment<3>(first + 3);
      now.world_from_placed[i] = moved * now.world_from_placed[i];
    }
    now.range_m += at(unknowns_.range());
  }

  const std::vector<Scene>& scenes_;
  RobotBox robot_;
  StraighteningOptions options_;
  SurfelAssociation association_;
  std::size_t block_;  ///< cells of a surfel
  StraighteningUnknowns unknowns_;
  std::vector<Eigen::Vector3d> pivots_m_;  ///< one a body, about which it turns
  std::vector<double> residuals_m_;
};

/// Some of a log's scenes, of a few stretches: neighbours see the same.
std::vector<std::size_t> probed(std::size_t count, std::size_t wanted) {
  constexpr std::size_t kProbes = 4;
  std::vector<std::size_t> chosen;
  const std::size_t length = wanted / kProbes;
  for (std::size_t k = 0; k < kProbes; ++k) {
    const std::size_t first = k * (count - length) / (kProbes - 1);
    for (std::size_t i = first; i < first + length; ++i) chosen.push_back(i);
  }
  return chosen;
}

}  // namespace

Straightening straighten(const std::vector<Scene>& scenes,
                         const RobotBox& robot,
                         const std::vector<Pose3>& world_from_placed,
                         const std::vector<std::size_t>& body_of,
                         const StraighteningOptions& options) {
  require(world_from_placed.size() == scenes.size(), "straighten: expected one pose a scene");
  require(body_of.empty() || body_of.size() == scenes.size(),
          "straighten: expected one body a scene");
  const auto run = [&](const std::vector<Scene>& of, const std::vector<Pose3>& start,
                       const std::vector<std::size_t>& bodies) {
    return Straightener(of, robot, bodies, options).run(start);
  };
  if (scenes.size() > 2 * options.probed_scenes) {
    std::vector<Scene> some;
    std::vector<Pose3> start;
    std::vector<std::size_t> bodies;
    std::map<std::size_t, std::size_t> numbers;
    for (const std::size_t i : probed(scenes.size(), options.probed_scenes)) {
      some.push_back(scenes[i]);
      start.push_back(world_from_placed[i]);
      const std::size_t body = body_of.empty() ? i : body_of[i];
      bodies.push_back(numbers.try_emplace(body, numbers.size()).first->second);
    }
    Straightening probe = run(some, start, bodies);
    const bool saw_the_same = probe.before_m > 0.0;
    if (saw_the_same && !probe.bent) {
      probe.turns_rad.clear();
      for (const Scene& scene : scenes) probe.turns_rad.emplace_back(scene.rows.size(), 0.0);
      probe.world_from_placed = world_from_placed;
      return probe;
    }
  }
  return run(scenes, world_from_placed, body_of);
}

}  // namespace marco::mapping3d
