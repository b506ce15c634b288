#include "plan/known_plan/deviations.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "plan/free_space.hpp"
#include "plan/known_plan/curve_fit.hpp"
#include "plan/known_plan/face_matching.hpp"
#include "plan/make_plan.hpp"
#include "plan/surfels.hpp"

namespace marco::plan {
namespace {

using Vector = Eigen::Vector2d;

constexpr double kLeastM = 0.30;  // as WallFace
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
             const std::vector<slam::Keyframe>& keys,
             const Pose2& guess)
      : drawn_(drawn), plan_(make_plan(keys)) {
    std::vector<WallFace> in_map;
    for (const WallFace& face : plan_.faces) in_map.push_back(moved(face, plan_.map_from_plan));
    // With a narrow kernel lines in the middle of walls would be taken for one of their faces.
    constexpr double kWideM = 0.15;
    fit(in_map, guess, kWideM);
    out_.axis_thickness_m = FaceMatching(drawn_, measured_).draw_faces_of_axes(drawn_);
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

  std::string room_at(const WallFace& face) const {
    constexpr double kBeforeM = 0.3;  // the wall: surely in the room, for none is narrower
    const Vector at = plan_from_drawing_ *
                      Vector(face.at((face.low_m + face.high_m) / 2) + kBeforeM * face.normal);
    for (const PlanRoom& room : plan_.rooms) {
      if (!room.loops.empty() && holds(room.loops.front(), at)) return room.name;
    }
    return {};
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
    const std::vector<std::size_t> faces = FaceMatching(drawn_, measured_).faces_on(drawn);
    double weights = 0.0, own = 0.0;
    Vector middle = Vector::Zero();
    for (const std::size_t i : faces) {
      taken_[i] = true;
      const WallFace& face = measured_[i];
      const Vector at = face.at((face.low_m + face.high_m) / 2);
      const double weight = face.length_m();
      wall.off_m += weight * drawn.distance_m(at);
      wall.turn_rad += weight * std::atan2(drawn.normal.x() * face.normal.y() -
                                               drawn.normal.y() * face.normal.x(),
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
        constexpr double kInsideM = 0.03;  // the wall: more than noise, less than its thickness
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

  void measure_curve(WallDeviation& wall) {
    const WallFace& some = wall.drawn[wall.drawn.size() / 2].face;
    wall.room = room_at(some);
    const CurveFit fit = fit_curve(wall.drawn, surfels_);
    if (fit.found) {
      wall.state = WallDeviation::State::measured;
      wall.off_m = fit.off_m;
      wall.shift_m = fit.shift_m;
      wall.sigma_m = sigma_at(some.at(some.low_m), some.normal, fit.sigma_m);
    } else {
      look_through(wall, {});
    }
    wall.seen_m = fit.seen_m;
    // Faces that are chords of it, too.
    for (std::size_t i = 0; i < measured_.size(); ++i) {
      const WallFace& face = measured_[i];
      const Vector middle = face.at((face.low_m + face.high_m) / 2);
      if (drawn_face_at(wall.drawn, middle, face.normal, kSameWallM)) taken_[i] = true;
    }
  }

  // Where a plan draws but one face of a wall, what was measured behind it is the other.
  void drop_undrawn_sides() {
    constexpr double kThinM = 0.03;  // nearer is the same face, measured twice
    std::vector<bool> is_behind(out_.walls.size(), false);
    for (std::size_t i = 0; i < out_.walls.size(); ++i) {
      const WallDeviation& wall = out_.walls[i];
      if (wall.is_curve() || wall.off_m < kThinM) continue;
      for (const WallDeviation& front : out_.walls) {
        is_behind[i] =
            is_behind[i] || (!front.is_curve() && front.state == WallDeviation::State::measured &&
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
    constexpr double kOnObjectM = 0.08;  // an object's outline and a face of it
    constexpr double kBeforeM = 1.0;     // the deepest furniture that stands at walls
    for (const PlanObject& object : plan_.objects) {
      const Vector at = plan_from_drawing_ * middle;
      wall.furniture |=
          object.round
              ? std::abs((at - object.centre).norm() - object.radius_m) < kOnObjectM
              : !object.outline.empty() && distance_to_outline(object.outline, at) < kOnObjectM;
    }
    double nearest = kBeforeM;
    for (const WallDeviation& drawn : out_.walls) {
      const WallFace& on = drawn.drawn.front().face;
      const double off = on.distance_m(middle), along = on.along().dot(middle);
      if (drawn.is_curve() || off < 0 || off > nearest || on.normal.dot(face.normal) < 0.97)
        continue;
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
  constexpr double kSigmas = 3.0;     // one right wall of 370 is told wrongly
  constexpr double kAllowedM = 0.02;  // plaster and skirting, which no plan draws
  const double off = std::max(std::abs(off_m), shift_m.norm());
  return state == State::measured && off > kSigmas * sigma_m && off > kAllowedM;
}

PlanDeviations compare_with_plan(const std::vector<DrawnFace>& drawn,
                                 const std::vector<slam::Keyframe>& keys,
                                 const Pose2& drawing_from_map_guess) {
  return Comparison(drawn, keys, drawing_from_map_guess).run();
}

}  // namespace marco::plan
