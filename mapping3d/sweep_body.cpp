#include "mapping3d/sweep_body.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <set>
#include <string>

#include "mapping3d/sweep_gates.hpp"

namespace marco::mapping3d {
namespace {

using namespace sweep_gates;

constexpr std::size_t kDegrees = 360;
constexpr std::size_t kMostViews = 20000;  // of a long log every nth row: 30 MB
constexpr float kSameM = 0.03F;            // noise of lasers
constexpr double kPlaceM = 0.3;            // places lie this far apart
constexpr std::size_t kMostPlaces = 24;
constexpr double kUsualPart = 0.3;  // of a bearing's returns: below it no range is usual
constexpr double kEdgePart = 0.03;  // of a bearing's returns, next to a part of the robot
constexpr std::size_t kWidestEdge = 5;
constexpr double kMarginM = 0.05;
// Of beams that reach a place: a small beam's width; and where the floor is seen at a slant of less
// than 2 deg a beam that passes it closely seems to go through.
constexpr double kPassM = 0.03, kBehindM = 0.3, kEndsM = 0.1, kFarthestM = 8.0;
constexpr int kBeams = 3;        // fewer may be mixed ranges
constexpr double kDriveM = 4.0;  // within a sweep

Pose3 world_from_sensor(const SceneRow& row) {
  return lift(row.world_from_robot) * row.robot_from_sensor_first;
}

/// What a row has under each degree of bearing: the nearest return, 0 = none.
using Nearest = std::array<float, kDegrees>;

struct View {
  Pose3 world_from_sensor;
  Nearest nearest_m{};
};

View view_of(const SceneRow& row) {
  View view{world_from_sensor(row), {}};
  for (std::size_t column = 0; column < row.ranges_m.size(); ++column) {
    const float range_m = row.ranges_m[column];
    if (!(range_m > 0.0F) || !std::isfinite(range_m)) continue;
    const double bearing_rad =
        row.first_bearing_rad + static_cast<double>(column) * row.bearing_step_rad;
    float& nearest = view.nearest_m[degree_of(bearing_rad)];
    if (nearest == 0.0F || range_m < nearest) nearest = range_m;
  }
  return view;
}

/// A degree of bearing and the range that is usual under it.
struct Spot {
  std::size_t degree = 0;
  float range_m = 0.0F;

  Eigen::Vector3d in_sensor() const {
    const double bearing_rad = deg_to_rad(static_cast<double>(degree) + 0.5);
    return static_cast<double>(range_m) *
           Eigen::Vector3d(std::cos(bearing_rad), std::sin(bearing_rad), 0.0);
  }
  bool has(float nearest_m, float within_m) const {
    return nearest_m > 0.0F && std::abs(nearest_m - range_m) <= within_m;
  }
};

struct Place {
  Eigen::Vector3d at_m;
  int same = 0, beyond = 0;  ///< rows: with the usual range, and with a larger one
};

struct Beams {
  int ended = 0, through = 0;

  bool any() const { return ended + through >= kBeams; }
  bool is_free() const { return through >= kBeams && ended * kBeams < through; }
};

class BodyOfLaser {
 public:
  BodyOfLaser(const std::vector<Scene>& scenes, const std::string& laser)
      : scenes_(scenes), laser_(laser) {
    std::size_t rows = 0;
    for (const Scene& scene : scenes) rows += scene.laser == laser ? scene.rows.size() : 0;
    const std::size_t every = 1 + rows / kMostViews;
    std::size_t number = 0;
    for (const Scene& scene : scenes) {
      if (scene.laser != laser) continue;
      for (const SceneRow& row : scene.rows) {
        if (number++ % every == 0) views_.push_back(view_of(row));
      }
    }
  }

  std::vector<BodyPart> parts() {
    for (std::size_t degree = 0; degree < kDegrees; ++degree) {
      const std::optional<Spot> spot = usual(degree);
      if (spot && is_body(*spot)) body_m_[degree] = spot->range_m;
    }
    grow();
    close_gaps();
    std::vector<BodyPart> parts;
    for (std::size_t i = 0; i < kDegrees; ++i) {
      if (body_m_[i] == 0.0F || body_m_[(i + kDegrees - 1) % kDegrees] != 0.0F) continue;
      float farthest_m = 0.0F;
      std::size_t width = 0;
      for (; width < kDegrees && body_m_[(i + width) % kDegrees] != 0.0F; ++width) {
        farthest_m = std::max(farthest_m, body_m_[(i + width) % kDegrees]);
      }
      parts.push_back({laser_, static_cast<double>(i), static_cast<double>(i + width),
                       std::ceil((static_cast<double>(farthest_m) + kMarginM) * 100.0) / 100.0});
    }
    return parts;
  }

 private:
  std::optional<Spot> usual(std::size_t degree) const {
    std::vector<float> near_m;
    std::size_t returns = 0;
    for (const View& view : views_) {
      const float nearest_m = view.nearest_m[degree];
      returns += nearest_m > 0.0F ? 1 : 0;
      if (nearest_m > 0.0F && nearest_m <= static_cast<float>(kBodyWithinM)) {
        near_m.push_back(nearest_m);
      }
    }
    std::sort(near_m.begin(), near_m.end());
    std::size_t most = 0, from = 0;
    for (std::size_t first = 0, last = 0; first < near_m.size(); ++first) {
      while (last < near_m.size() && near_m[last] <= near_m[first] + 2.0F * kSameM) ++last;
      if (last - first > most) {
        most = last - first;
        from = first;
      }
    }
    if (most < static_cast<std::size_t>(kBodyRows) ||
        static_cast<double>(most) < kUsualPart * static_cast<double>(returns)) {
      return std::nullopt;
    }
    return Spot{degree, near_m[from + most / 2]};
  }

  /// Where the laser would have seen the same thing, and whether it did.
  std::vector<Place> places_of(const Spot& spot) const {
    std::vector<Place> places;
    for (const View& view : views_) {
      const float nearest_m = view.nearest_m[spot.degree];
      const bool same = spot.has(nearest_m, kSameM);
      if (!same && nearest_m <= spot.range_m) continue;
      const Eigen::Vector3d at_m = view.world_from_sensor * spot.in_sensor();
      auto place = std::find_if(places.begin(), places.end(), [&](const Place& known) {
        return (known.at_m - at_m).squaredNorm() < kPlaceM * kPlaceM;
      });
      if (place == places.end()) {
        if (places.size() == kMostPlaces) continue;
        place = places.insert(place, {at_m});
      }
      ++(same ? place->same : place->beyond);
    }
    return places;
  }

  bool is_body(const Spot& spot) const {
    const std::vector<Place> places = places_of(spot);
    int same = 0, reached = 0, free = 0;
    for (const Place& place : places) {
      if (place.same < place.beyond) continue;
      ++same;
      const Beams beams = beams_at(place.at_m, spot);
      reached += beams.any() ? 1 : 0;
      free += beams.is_free() ? 1 : 0;
    }
    return same >= kBodyPlaces && same >= kBodyPart * static_cast<double>(places.size()) &&
           free >= kSeenThrough && free >= kSeenThroughPart * reached;
  }

  Beams beams_at(const Eigen::Vector3d& place_m, const Spot& spot) const {
    Beams beams;
    for (const Scene& scene : scenes_) {
      const Eigen::Vector3d from_m = world_from_sensor(scene.rows.front()).translation();
      if ((from_m - place_m).norm() > kFarthestM + kDriveM) continue;
      for (const SceneRow& row : scene.rows) {
        note_beam(row, place_m, scene.laser == laser_ ? &spot : nullptr, beams);
      }
    }
    return beams;
  }

  /// @param own  what the same laser sees of itself says nothing
  static void note_beam(const SceneRow& row,
                        const Eigen::Vector3d& place_m,
                        const Spot* own,
                        Beams& beams) {
    const Eigen::Vector3d in_sensor = world_from_sensor(row).inverse() * place_m;
    if (std::abs(in_sensor.z()) > kPassM) return;
    const double far_m = in_sensor.head<2>().norm();
    if (far_m > kFarthestM) return;
    const double from_rad =
        normalize_angle(std::atan2(in_sensor.y(), in_sensor.x()) - row.first_bearing_rad);
    const double turn = 2.0 * std::numbers::pi / std::abs(row.bearing_step_rad);
    double column = from_rad / row.bearing_step_rad;
    if (column < -0.5) column += turn;
    const auto nearest = static_cast<std::size_t>(std::lround(std::max(0.0, column)));
    if (nearest >= row.ranges_m.size()) return;
    if (std::abs(column - static_cast<double>(nearest)) * std::abs(row.bearing_step_rad) * far_m >
        kPassM) {
      return;
    }
    const float range_m = row.ranges_m[nearest];
    if (!(range_m > 0.0F)) return;
    if (own != nullptr && own->has(range_m, 2.0F * kSameM)) return;
    const double behind_m = static_cast<double>(range_m) - far_m;
    beams.through += behind_m > kBehindM ? 1 : 0;
    beams.ended += std::abs(behind_m) < kEndsM ? 1 : 0;
  }

  /// At its edges a part is hit by some beams only.
  void grow() {
    const auto sure_m = body_m_;
    for (const std::size_t step : {std::size_t{1}, kDegrees - 1}) {
      for (std::size_t i = 0; i < kDegrees; ++i) {
        if (sure_m[i] == 0.0F || sure_m[(i + step) % kDegrees] != 0.0F) continue;
        for (std::size_t width = 1; width <= kWidestEdge; ++width) {
          const Spot edge{(i + width * step) % kDegrees, sure_m[i]};
          if (body_m_[edge.degree] != 0.0F || !is_edge(edge)) break;
          body_m_[edge.degree] = edge.range_m;
        }
      }
    }
  }

  /// Of beams a degree apart none falls into some degrees.
  void close_gaps() {
    for (std::size_t i = 0; i < kDegrees; ++i) {
      const float before_m = body_m_[(i + kDegrees - 1) % kDegrees];
      if (body_m_[i] != 0.0F || before_m == 0.0F || body_m_[(i + 1) % kDegrees] == 0.0F) continue;
      const bool empty = std::all_of(views_.begin(), views_.end(),
                                     [i](const View& view) { return view.nearest_m[i] == 0.0F; });
      if (empty) body_m_[i] = before_m;
    }
  }

  bool is_edge(const Spot& spot) const {
    std::size_t returns = 0, same = 0;
    for (const View& view : views_) {
      const float nearest_m = view.nearest_m[spot.degree];
      returns += nearest_m > 0.0F ? 1 : 0;
      same += spot.has(nearest_m, kSameM) ? 1 : 0;
    }
    return same > 0 && static_cast<double>(same) >= kEdgePart * static_cast<double>(returns);
  }

  const std::vector<Scene>& scenes_;
  std::string laser_;
  std::vector<View> views_;
  std::array<float, kDegrees> body_m_{};  ///< under each degree, 0 = none
};

}  // namespace

std::vector<BodyPart> find_own_body(const std::vector<Scene>& scenes) {
  std::set<std::string> lasers;
  for (const Scene& scene : scenes) lasers.insert(scene.laser);
  std::vector<BodyPart> all;
  for (const std::string& laser : lasers) {
    for (BodyPart& part : BodyOfLaser(scenes, laser).parts()) all.push_back(std::move(part));
  }
  return all;
}

void blank(Scene& scene, const std::vector<BodyPart>& parts) {
  for (const BodyPart& part : parts) {
    if (part.channel != scene.laser) continue;
    for (SceneRow& row : scene.rows) {
      for (std::size_t column = 0; column < row.ranges_m.size(); ++column) {
        const double bearing_rad =
            row.first_bearing_rad + static_cast<double>(column) * row.bearing_step_rad;
        if (part.has(bearing_rad, row.ranges_m[column])) row.ranges_m[column] = 0.0F;
      }
    }
  }
}

}  // namespace marco::mapping3d
