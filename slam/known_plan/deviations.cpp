#include "slam/known_plan/deviations.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>

#include "slam/plan/free_space.hpp"
#include "slam/plan/make_plan.hpp"
#include "slam/plan/surfels.hpp"

namespace marco::slam {
namespace {

using Vector = Eigen::Vector2d;

constexpr double kSameWallM = 0.25;  // a face farther off is another wall
constexpr double kLeastM = 0.30;     // as WallFace
constexpr double kStepM = 0.05;

bool holds(const std::vector<RoomEdge>& loop, const Vector& point) {
  bool inside = false;
  for (const RoomEdge& edge : loop) {
    const Vector &a = edge.from, &b = edge.to;
    if ((a.y() > point.y()) == (b.y() > point.y())) continue;
    const double x = a.x() + (b.x() - a.x()) * (point.y() - a.y()) / (b.y() - a.y());
    if (point.x() < x) inside = !inside;
  }
  return inside;
}

double distance_to_outline(const std::vector<Vector>& outline, const Vector& point) {
  double least = 1e9;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Vector &a = outline[i], along = outline[(i + 1) % outline.size()] - a;
    const double part = along.dot(point - a) / std::max(along.squaredNorm(), 1e-12);
    least = std::min(least, (a + std::clamp(part, 0.0, 1.0) * along - point).norm());
  }
  return least;
}

class Comparison {
 public:
  Comparison(const std::vector<DrawnFace>& drawn,
             const std::vector<Keyframe>& keys,
             const Pose2& guess)
      : drawn_(drawn), plan_(make_plan(keys)) {
    std::vector<WallFace> in_map;
    for (const WallFace& face : plan_.faces) in_map.push_back(moved(face, plan_.map_from_plan));
    // With a narrow kernel lines in the middle of walls would be taken for one of their faces.
    constexpr double kWideM = 0.15;
    fit(in_map, guess, kWideM);
    draw_faces_of_axes();
    fit(in_map, out_.fit.drawing_from_map, 0.0);
    plan_from_drawing_ = (out_.fit.drawing_from_map * plan_.map_from_plan).inverse();
    taken_.resize(measured_.size(), false);
    space_.emplace(keys, out_.fit.drawing_from_map);
    surfels_ = gather_surfels(keys, out_.fit.drawing_from_map);
  }

  PlanDeviations run() {
    std::map<int, WallDeviation> curves;
    for (const DrawnFace& face : drawn_) {
      if (face.curved) {
        curves[face.shape].drawn.push_back(face);
      } else if (face.face.length_m() >= kLeastM) {
        WallDeviation wall;
        wall.drawn = {face};
        measure(wall);
        out_.walls.push_back(wall);
      }
    }
    for (auto& [shape, wall] : curves) {
      if (wall.length_m() < kLeastM) continue;
      measure_curve(wall);
      out_.walls.push_back(wall);
    }
    drop_undrawn_sides();
    number();
    for (std::size_t i = 0; i < measured_.size(); ++i) {
      if (!taken_[i]) add_undrawn(measured_[i]);
    }
    return std::move(out_);
  }

 private:
  void fit(const std::vector<WallFace>& in_map, const Pose2& guess, double narrowest_m) {
    out_.fit = fit_to_plan(drawn_, in_map, guess, narrowest_m);
    measured_.clear();
    for (const WallFace& face : in_map) {
      measured_.push_back(moved(face, out_.fit.drawing_from_map));
    }
  }

  // Whether these are the two sides of it.
  static bool is_one_line(const WallFace& front, const WallFace& back) {
    constexpr double kSameLineM = 0.005;
    return back.normal.dot(front.normal) < -0.9999 &&
           std::abs(back.offset_m + front.offset_m) < kSameLineM &&
           overlap_m(front, back) > kLeastM;
  }

  std::optional<std::size_t> back_of(const WallFace& front) const {
    for (std::size_t i = 0; i < drawn_.size(); ++i) {
      if (!drawn_[i].curved && is_one_line(front, drawn_[i].face)) return i;
    }
    return std::nullopt;
  }

  std::optional<double> measured_off(const WallFace& drawn) const {
    const std::vector<std::size_t> faces = faces_on(drawn);
    if (faces.empty()) return std::nullopt;
    const WallFace& face = measured_[faces.front()];
    return drawn.distance_m(face.at((face.low_m + face.high_m) / 2));
  }

  // Where most lines that were measured from both sides lie in the middle of their walls, moves
  // both drawn faces to where the wall's should be.
  void draw_faces_of_axes() {
    constexpr double kThinM = 0.03, kMiddle = 0.3;
    constexpr std::size_t kLeast = 4;
    std::vector<double> thick, half(drawn_.size(), 0.0);
    std::size_t in_middle = 0;
    for (std::size_t i = 0; i < drawn_.size(); ++i) {
      if (drawn_[i].curved) continue;
      const auto off = measured_off(drawn_[i].face);
      const auto back = back_of(drawn_[i].face);
      if (!off || !back) continue;
      const double thickness = *off + measured_off(drawn_[*back].face).value_or(-1e9);
      if (thickness < kThinM) continue;
      thick.push_back(thickness);
      half[i] = thickness / 2;
      in_middle += std::abs(*off - half[i]) < kMiddle * thickness ? 1 : 0;
    }
    if (thick.size() < kLeast || in_middle * 2 < thick.size()) return;
    const auto middle = thick.begin() + static_cast<std::ptrdiff_t>(thick.size() / 2);
    std::nth_element(thick.begin(), middle, thick.end());
    out_.axis_thickness_m = *middle;
    for (std::size_t i = 0; i < drawn_.size(); ++i) {
      if (!drawn_[i].curved) drawn_[i].face.offset_m += half[i] > 0 ? half[i] : *middle / 2;
    }
  }

  std::string room_at(const WallFace& face) const {
    constexpr double kBeforeM = 0.3;
    const Vector at = plan_from_drawing_ *
                      Vector(face.at((face.low_m + face.high_m) / 2) + kBeforeM * face.normal);
    for (const PlanRoom& room : plan_.rooms) {
      if (!room.loops.empty() && holds(room.loops.front(), at)) return room.name;
    }
    return {};
  }

  static double overlap_m(const WallFace& drawn, const WallFace& face) {
    const double a = drawn.along().dot(face.at(face.low_m));
    const double b = drawn.along().dot(face.at(face.high_m));
    return std::min(std::max(a, b), drawn.high_m) - std::max(std::min(a, b), drawn.low_m);
  }

  bool is_same_wall(const WallFace& drawn, const WallFace& face) const {
    constexpr double kFacing = 0.985;
    const double overlap = overlap_m(drawn, face);
    return face.normal.dot(drawn.normal) > kFacing && overlap > 0.1 &&
           overlap > 0.4 * std::min(face.length_m(), drawn.length_m()) &&
           std::abs(drawn.distance_m(face.at((face.low_m + face.high_m) / 2))) < kSameWallM;
  }

  // How far the nearest drawn face is that it can belong to: what another wall explains is none of
  // this one's.
  double nearest_drawn_m(const WallFace& face) const {
    const Vector middle = face.at((face.low_m + face.high_m) / 2);
    double nearest = kSameWallM;
    for (const DrawnFace& drawn : drawn_) {
      if (drawn.curved || !is_same_wall(drawn.face, face)) continue;
      nearest = std::min(nearest, std::abs(drawn.face.distance_m(middle)));
    }
    return nearest;
  }

  // The faces on it that lie on one line: of a wall and what stands before it, the longer.
  std::vector<std::size_t> faces_on(const WallFace& drawn) const {
    std::vector<std::size_t> near;
    for (std::size_t i = 0; i < measured_.size(); ++i) {
      if (is_same_wall(drawn, measured_[i])) near.push_back(i);
    }
    constexpr double kOneLineM = 0.04;
    std::erase_if(near, [&](std::size_t i) {
      const WallFace& face = measured_[i];
      return std::abs(drawn.distance_m(face.at((face.low_m + face.high_m) / 2))) >
             nearest_drawn_m(face) + kOneLineM;
    });
    const auto off = [&](std::size_t i) {
      const WallFace& face = measured_[i];
      return drawn.distance_m(face.at((face.low_m + face.high_m) / 2));
    };
    std::vector<std::size_t> best;
    double most_m = 0.0;
    for (const std::size_t centre : near) {
      std::vector<std::size_t> line;
      double length = 0.0;
      for (const std::size_t i : near) {
        if (std::abs(off(i) - off(centre)) > kOneLineM) continue;
        line.push_back(i);
        length += overlap_m(drawn, measured_[i]);
      }
      if (length > most_m) most_m = length, best = line;
    }
    return best;
  }

  double sigma_at(const Vector& point, const Vector& normal, double own_sigma_m) const {
    const Vector arm = point - out_.fit.middle;
    const Eigen::Vector3d row(normal.x(), normal.y(), normal.dot(Vector(-arm.y(), arm.x())));
    return std::sqrt(own_sigma_m * own_sigma_m + out_.fit.spread_m * out_.fit.spread_m +
                     row.dot(out_.fit.covariance * row));
  }

  void measure(WallDeviation& wall) {
    const WallFace& drawn = wall.drawn.front().face;
    wall.room = room_at(drawn);
    const std::vector<std::size_t> faces = faces_on(drawn);
    double weights = 0.0, own = 0.0;
    Vector middle = Vector::Zero();
    for (const std::size_t i : faces) {
      taken_[i] = true;
      const WallFace& face = measured_[i];
      const Vector at = face.at((face.low_m + face.high_m) / 2);
      const double weight = face.length_m();
      wall.off_m += weight * drawn.distance_m(at);
      wall.turn_rad +=
          weight * std::atan2(drawn.normal.x() * face.normal.y() - drawn.normal.y() * face.normal.x(),
                              drawn.normal.dot(face.normal));
      own += weight * face.sigma_m;
      middle += weight * at;
      weights += weight;
    }
    if (weights > 0) {
      wall.state = WallDeviation::State::measured;
      wall.off_m /= weights;
      wall.turn_rad /= weights;
      wall.sigma_m = sigma_at(middle / weights, drawn.normal, own / weights);
    }
    look_through(wall, faces);
  }

  // What of it was seen, and what beams went through.
  void look_through(WallDeviation& wall, const std::vector<std::size_t>& faces) {
    for (const DrawnFace& piece : wall.drawn) {
      const WallFace& drawn = piece.face;
      const int steps = std::max(1, static_cast<int>(std::lround(drawn.length_m() / kStepM)));
      const double step = drawn.length_m() / steps;
      for (int i = 0; i < steps; ++i) {
        const Vector at = drawn.at(drawn.low_m + (i + 0.5) * step);
        const bool is_seen = std::any_of(faces.begin(), faces.end(), [&](std::size_t k) {
          const WallFace& face = measured_[k];
          const double along = face.along().dot(at);
          return along > face.low_m - kStepM && along < face.high_m + kStepM;
        });
        constexpr double kInsideM = 0.03;
        if (is_seen) {
          wall.seen_m += step;
        } else if (space_->is_free(at) && space_->is_free(Vector(at - kInsideM * drawn.normal))) {
          wall.gone_m += step;
        }
      }
    }
    if (wall.state == WallDeviation::State::unseen && wall.gone_m > wall.length_m() / 2) {
      wall.state = WallDeviation::State::missing;
    }
  }

  // By the points on it: how far outwards it lies, and where its centre.
  void measure_curve(WallDeviation& wall) {
    Eigen::Matrix3d information = Eigen::Vector3d(100, 25, 25).asDiagonal();
    Eigen::Vector3d sum = Eigen::Vector3d::Zero(), found = Eigen::Vector3d::Zero();
    struct Spot {
      Eigen::Vector3d row;
      double off_m;
    };
    std::vector<Spot> spots;
    for (const DrawnFace& chord : wall.drawn) {
      bool is_seen = false;
      for (const PlanSurfel& surfel : surfels_) {
        const Vector at = surfel.mean();
        const double along = chord.face.along().dot(at), off = chord.face.distance_m(at);
        if (along < chord.face.low_m || along > chord.face.high_m || std::abs(off) > kSameWallM ||
            surfel.normal.normalized().dot(chord.face.normal) < 0.9) {
          continue;
        }
        is_seen = true;
        spots.push_back({{1.0, chord.face.normal.x(), chord.face.normal.y()}, off});
      }
      if (is_seen) wall.seen_m += chord.face.length_m();
    }
    constexpr std::size_t kLeast = 6;
    if (spots.size() >= kLeast) {
      double squares = 0.0, kept = 0.0;
      for (const double kernel_m : {0.2, 0.1, 0.05, 0.03, 0.03, 0.03}) {
        information = Eigen::Vector3d(100, 25, 25).asDiagonal();
        sum.setZero();
        squares = kept = 0.0;
        for (const Spot& spot : spots) {
          const double rest = spot.off_m - spot.row.dot(found);
          const double weight = std::pow(1 + rest * rest / (kernel_m * kernel_m), -2);
          // Four surfels side by side share their noise.
          information += weight / 4 / 1e-4 * spot.row * spot.row.transpose();
          sum += weight / 4 / 1e-4 * spot.row * spot.off_m;
          squares += weight * rest * rest;
          kept += weight;
        }
        found = information.inverse() * sum;
      }
      wall.state = WallDeviation::State::measured;
      wall.off_m = found.x();
      wall.shift_m = found.tail<2>();
      const double own = std::sqrt(information.inverse()(0, 0) * std::max(1.0, squares / kept / 1e-4));
      const WallFace& some = wall.drawn[wall.drawn.size() / 2].face;
      wall.sigma_m = sigma_at(some.at(some.low_m), some.normal, own);
    }
    const double seen_m = wall.seen_m;
    const WallFace& some = wall.drawn[wall.drawn.size() / 2].face;
    wall.room = room_at(some);
    if (wall.state == WallDeviation::State::unseen) look_through(wall, {});
    wall.seen_m = seen_m;
    // Faces that are chords of it, too.
    for (std::size_t i = 0; i < measured_.size(); ++i) {
      const WallFace& face = measured_[i];
      const auto at = drawn_face_at(wall.drawn, face.at((face.low_m + face.high_m) / 2), face.normal,
                                    kSameWallM);
      if (at) taken_[i] = true;
    }
  }

  // Where a plan draws but one face of a wall, what was measured behind it is the other.
  void drop_undrawn_sides() {
    constexpr double kThinM = 0.03;
    std::vector<bool> is_behind(out_.walls.size(), false);
    for (std::size_t i = 0; i < out_.walls.size(); ++i) {
      const WallDeviation& wall = out_.walls[i];
      if (wall.is_curve() || wall.off_m < kThinM) continue;
      for (const WallDeviation& front : out_.walls) {
        is_behind[i] = is_behind[i] ||
                       (!front.is_curve() && front.state == WallDeviation::State::measured &&
                        is_one_line(wall.drawn.front().face, front.drawn.front().face) &&
                        std::abs(front.off_m) < wall.off_m / 2);
      }
    }
    std::size_t index = 0;
    std::erase_if(out_.walls, [&](const WallDeviation&) { return is_behind[index++]; });
  }

  // Room by room, the longest first.
  void number() {
    std::stable_sort(out_.walls.begin(), out_.walls.end(),
                     [](const WallDeviation& a, const WallDeviation& b) {
                       return a.room != b.room ? a.room < b.room : a.length_m() > b.length_m();
                     });
    for (std::size_t i = 0; i < out_.walls.size(); ++i) {
      out_.walls[i].number = static_cast<int>(i) + 1;
    }
  }

  void add_undrawn(const WallFace& face) {
    UndrawnWall wall;
    wall.face = face;
    wall.room = room_at(face);
    const Vector middle = face.at((face.low_m + face.high_m) / 2);
    constexpr double kOnObjectM = 0.08, kBeforeM = 1.0;
    for (const PlanObject& object : plan_.objects) {
      const Vector at = plan_from_drawing_ * middle;
      wall.furniture |=
          object.round ? std::abs((at - object.centre).norm() - object.radius_m) < kOnObjectM
                       : !object.outline.empty() &&
                             distance_to_outline(object.outline, at) < kOnObjectM;
    }
    double nearest = kBeforeM;
    for (const WallDeviation& drawn : out_.walls) {
      const WallFace& on = drawn.drawn.front().face;
      const double off = on.distance_m(middle), along = on.along().dot(middle);
      if (drawn.is_curve() || off < 0 || off > nearest || on.normal.dot(face.normal) < 0.97) continue;
      if (along < on.low_m || along > on.high_m) continue;
      nearest = off;
      wall.before = drawn.number;
    }
    out_.undrawn.push_back(wall);
  }

  std::vector<DrawnFace> drawn_;
  FloorPlan plan_;
  PlanDeviations out_;
  Pose2 plan_from_drawing_;
  std::vector<WallFace> measured_;  ///< in the drawing
  std::vector<bool> taken_;
  std::optional<FreeSpace> space_;
  std::vector<PlanSurfel> surfels_;
};

}  // namespace

double WallDeviation::length_m() const {
  double length = 0.0;
  for (const DrawnFace& piece : drawn) length += piece.face.length_m();
  return length;
}

bool WallDeviation::is_off() const {
  constexpr double kSigmas = 3.0, kAllowedM = 0.02;
  const double off = std::max(std::abs(off_m), shift_m.norm());
  return state == State::measured && off > kSigmas * sigma_m && off > kAllowedM;
}

PlanDeviations compare_with_plan(const std::vector<DrawnFace>& drawn,
                                 const std::vector<Keyframe>& keys,
                                 const Pose2& drawing_from_map_guess) {
  return Comparison(drawn, keys, drawing_from_map_guess).run();
}

}  // namespace marco::slam
