#include "mapping3d/straightening.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include "lcm_tools/base/check.hpp"
#include "mapping3d/sparse_least_squares.hpp"

namespace marco::mapping3d {
namespace {

struct Reach {
  double search_m;
  double lorentz_m;
};

/// A scene as it is thought to be, in the joined frame.
struct Swept {
  ScenePoints points;
  std::unique_ptr<SurfelIndex> patches;
  std::vector<SweepAxis> axes;  ///< one a row
};

class Straightener {
 public:
  Straightener(const std::vector<Scene>& scenes,
               const RobotBox& robot,
               const std::vector<std::size_t>& body_of,
               const StraighteningOptions& options)
      : scenes_(scenes),
        robot_(robot),
        body_of_(body_of),
        options_(options),
        min_cosine_(std::cos(deg_to_rad(options.max_normal_deg))) {
    validate(options, "straightening");
    for (const Scene& scene : scenes) {
      first_row_.push_back(unknowns_);
      unknowns_ += scene.rows.size();
    }
    for (std::size_t i = 0; i < scenes.size(); ++i) {
      if (body_of_.size() <= i) body_of_.push_back(i);
      bodies_ = std::max(bodies_, body_of_[i] + 1);
    }
    first_body_ = unknowns_;
    unknowns_ += 6 * bodies_;
    range_ = unknowns_++;
  }

  Straightening run(const std::vector<Pose3>& world_from_placed) {
    Straightening now, given;
    for (const Scene& scene : scenes_) now.turns_rad.emplace_back(scene.rows.size(), 0.0);
    now.world_from_placed = world_from_placed;
    given = now;
    Reach reach{options_.search_start_m, options_.lorentz_start_m};
    for (int i = 0; i < options_.iterations; ++i) {
      std::vector<Equation> equations = distances(now, reach);
      const std::size_t seen = equations.size();
      if (seen == 0) return given;
      add_priors(now, equations);
      const Eigen::VectorXd step = solve(equations, static_cast<Eigen::Index>(unknowns_));
      if (i == 0) {
        equations.resize(seen);
        now.explained = given.explained = explained(equations, step);
        now.before_m = given.before_m = given.after_m = quantile(residuals_m_, 0.5);
        if (now.explained < options_.min_explained) return given;
      }
      take(step, now);
      reach.search_m = std::max(options_.search_end_m, options_.shrink * reach.search_m);
      reach.lorentz_m = std::max(options_.lorentz_end_m, options_.shrink * reach.lorentz_m);
    }
    distances(now, {options_.search_start_m, options_.lorentz_end_m});
    now.after_m = quantile(residuals_m_, 0.5);
    now.turn_rms_rad = rms_rad(now.turns_rad);
    // Turns far beyond what rows are wrong by have laid surfaces on each other that are not one.
    now.bent = now.after_m <= options_.max_left * now.before_m &&
               now.turn_rms_rad <= 1.5 * deg_to_rad(options_.row_error_deg);
    return now.bent ? now : given;
  }

 private:
  Swept swept(std::size_t scene, const Straightening& now) const {
    Swept result;
    const Scene mended = straightened(scenes_[scene], now.turns_rad[scene], now.range_m);
    result.points = place(mended, robot_);
    move(result.points, now.world_from_placed[scene]);
    result.patches = std::make_unique<SurfelIndex>(find_surfels(result.points, options_.surfels));
    for (std::size_t row = 0; row < mended.rows.size(); ++row) {
      const SweepAxis in_robot = sweep_axis(scenes_[scene], row);
      const Pose3 from_robot =
          now.world_from_placed[scene] * lift(mended.rows[row].world_from_robot);
      result.axes.push_back(
          {from_robot.linear() * in_robot.direction, from_robot * in_robot.point_m});
    }
    return result;
  }

  /// Of a point of a row, along `normal`, when the row turns.
  static double by_turn(const Swept& scene,
                        std::size_t row,
                        const Eigen::Vector3d& at_m,
                        const Eigen::Vector3d& normal) {
    const SweepAxis& axis = scene.axes[row];
    return normal.dot(axis.direction.cross(at_m - axis.point_m));
  }
  static double by_range(const Swept& scene,
                         std::size_t row,
                         const Eigen::Vector3d& at_m,
                         const Eigen::Vector3d& normal) {
    return normal.dot((at_m - scene.points.origins_m[row].cast<double>()).normalized());
  }

  std::vector<Equation> distances(const Straightening& now, const Reach& reach) {
    std::vector<Swept> all;
    pivots_m_.assign(bodies_, Eigen::Vector3d::Zero());
    std::vector<double> counts(bodies_, 0.0);
    for (std::size_t i = 0; i < scenes_.size(); ++i) {
      all.push_back(swept(i, now));
      for (const Surfel& patch : all[i].patches->surfels) pivots_m_[body_of_[i]] += patch.center_m;
      counts[body_of_[i]] += static_cast<double>(all[i].patches->surfels.size());
    }
    for (std::size_t i = 0; i < bodies_; ++i) pivots_m_[i] /= std::max(1.0, counts[i]);
    std::vector<Equation> equations;
    residuals_m_.clear();
    for (std::size_t a = 0; a < all.size(); ++a) {
      for (std::size_t b = 0; b < all.size(); ++b) {
        Eigen::AlignedBox3d box = all[b].patches->box;
        if (a == b || box.isEmpty() || all[a].patches->box.isEmpty()) continue;
        box.min().array() -= reach.search_m;
        box.max().array() += reach.search_m;
        if (box.intersects(all[a].patches->box)) compare({all, a, b}, reach, equations);
      }
    }
    return equations;
  }

  struct Pair {
    const std::vector<Swept>& all;
    std::size_t target;
    std::size_t source;
  };

  /// Each row of each patch of the source against the nearest patch of the target.
  void compare(const Pair& pair, const Reach& reach, std::vector<Equation>& equations) {
    const Swept& target = pair.all[pair.target];
    const Swept& source = pair.all[pair.source];
    const auto block = static_cast<std::size_t>(options_.surfels.block_cells);
    // With many scenes each patch has many partners.
    const std::size_t stride = 1 + pair.all.size() / 8;
    for (std::size_t i = 0; i < source.patches->surfels.size(); i += stride) {
      const Surfel& patch = source.patches->surfels[i];
      for (std::size_t row = patch.row; row < patch.row + block; ++row) {
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        double count = 0.0;
        for (std::size_t column = patch.column; column < patch.column + block; ++column) {
          const std::size_t at = source.points.index(row, column);
          if (source.points.valid[at] == 0) continue;
          sum += source.points.points_m[at].cast<double>();
          count += 1.0;
        }
        if (count == 0.0) continue;
        const Eigen::Vector3d at_m = sum / count;
        const auto nearest =
            target.patches->centers.nearest(at_m.cast<float>(), static_cast<float>(reach.search_m));
        if (!nearest) continue;
        const Surfel& partner = target.patches->surfels[*nearest];
        if (patch.normal.dot(partner.normal) < min_cosine_) continue;
        equations.push_back(equation(pair, {at_m, row, patch.normal}, partner, reach));
      }
    }
  }

  struct Piece {
    Eigen::Vector3d at_m;
    std::size_t row;
    Eigen::Vector3d normal;
  };

  Equation equation(const Pair& pair,
                    const Piece& piece,
                    const Surfel& partner,
                    const Reach& reach) {
    const Eigen::Vector3d normal = (piece.normal + partner.normal).normalized();
    const double residual_m = normal.dot(piece.at_m - partner.center_m);
    residuals_m_.push_back(std::abs(residual_m));
    Equation result;
    result.residual = static_cast<float>(residual_m);
    const double scaled = residual_m / reach.lorentz_m,
                 thick = partner.thickness_m / options_.thin_m;
    result.weight =
        static_cast<float>(1.0 / ((1.0 + 0.5 * scaled * scaled) * (1.0 + thick * thick)));
    const Swept& target = pair.all[pair.target];
    const Swept& source = pair.all[pair.source];
    result.add(first_row_[pair.source] + piece.row, by_turn(source, piece.row, piece.at_m, normal));
    const auto block = static_cast<std::size_t>(options_.surfels.block_cells);
    for (std::size_t row = partner.row; row < partner.row + block; ++row) {
      if (result.count + 13 >= Equation::kMost) break;
      result.add(first_row_[pair.target] + row,
                 -by_turn(target, row, partner.center_m, normal) / static_cast<double>(block));
    }
    result.add(range_, by_range(source, piece.row, piece.at_m, normal) -
                           by_range(target, partner.row, partner.center_m, normal));
    const std::size_t a = body_of_[pair.target], b = body_of_[pair.source];
    if (a == b) return result;
    const Eigen::Vector3d turn_b = (piece.at_m - pivots_m_[b]).cross(normal);
    const Eigen::Vector3d turn_a = (piece.at_m - pivots_m_[a]).cross(normal);
    for (Eigen::Index k = 0; k < 3; ++k) {
      const auto at = static_cast<std::size_t>(k);
      if (b > 0) result.add(first_body_ + 6 * b + at, turn_b[k]);
      if (b > 0) result.add(first_body_ + 6 * b + 3 + at, normal[k]);
      if (a > 0) result.add(first_body_ + 6 * a + at, -turn_a[k]);
      if (a > 0) result.add(first_body_ + 6 * a + 3 + at, -normal[k]);
    }
    return result;
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
        small.add(first_row_[i] + row, 1.0);
        equations.push_back(small);
        if (row + 1 == turns.size()) continue;
        const double jump = turns[row + 1] - turns[row];
        Equation smooth =
            prior(jump, step_rad * std::sqrt(1.0 + 0.5 * jump * jump / (step_rad * step_rad)));
        smooth.add(first_row_[i] + row, -1.0);
        smooth.add(first_row_[i] + row + 1, 1.0);
        equations.push_back(smooth);
      }
    }
    Equation zero = prior(now.range_m, options_.range_error_m);
    zero.add(range_, 1.0);
    equations.push_back(zero);
  }

  void take(const Eigen::VectorXd& step, Straightening& now) const {
    const auto at = [&step](std::size_t unknown) {
      return step[static_cast<Eigen::Index>(unknown)];
    };
    for (std::size_t i = 0; i < scenes_.size(); ++i) {
      RowTurns& turns = now.turns_rad[i];
      for (std::size_t row = 0; row < turns.size(); ++row) turns[row] += at(first_row_[i] + row);
      const auto body = static_cast<Eigen::Index>(first_body_ + 6 * body_of_[i]);
      const Eigen::Vector3d turn = step.segment<3>(body);
      const Eigen::Vector3d pivot_m = pivots_m_[body_of_[i]];
      Pose3 moved = Pose3::Identity();
      if (turn.norm() > 0.0) {
        moved.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
      }
      moved.translation() = pivot_m - moved.linear() * pivot_m + step.segment<3>(body + 3);
      now.world_from_placed[i] = moved * now.world_from_placed[i];
    }
    now.range_m += at(range_);
  }

  const std::vector<Scene>& scenes_;
  RobotBox robot_;
  std::vector<std::size_t> body_of_;
  StraighteningOptions options_;
  double min_cosine_;
  std::vector<std::size_t> first_row_;  ///< of each scene among the unknowns
  std::size_t bodies_ = 0;
  std::size_t first_body_ = 0;  ///< of the turns and shifts of bodies
  std::size_t range_ = 0;
  std::size_t unknowns_ = 0;
  std::vector<Eigen::Vector3d> pivots_m_;  ///< about which bodies turn
  std::vector<double> residuals_m_;
};

}  // namespace

Straightening straighten(const std::vector<Scene>& scenes,
                         const RobotBox& robot,
                         const std::vector<Pose3>& world_from_placed,
                         const std::vector<std::size_t>& body_of,
                         const StraighteningOptions& options) {
  require(world_from_placed.size() == scenes.size(), "straighten: expected one pose a scene");
  require(body_of.empty() || body_of.size() == scenes.size(),
          "straighten: expected one body a scene");
  return Straightener(scenes, robot, body_of, options).run(world_from_placed);
}

}  // namespace marco::mapping3d
