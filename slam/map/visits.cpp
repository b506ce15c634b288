#include "slam/map/visits.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "slam/map/range_view.hpp"

namespace marco::slam {
namespace {

// Keyframes farther apart than this do not compare what they see.
constexpr double kVisitM = 3.0;
constexpr double kRevisitPathM = 8.0;  // a shorter way back is one and the same visit
constexpr double kStretchM = 3.0;      // of path: one visit
constexpr std::size_t kVisitsOfOne = 4;
constexpr Eigen::Index kEveryPoint = 3;

// Keyframes by squares, so that a large map costs no more for each.
class Squares {
 public:
  void add(const Eigen::Vector2d& place_m, int key) { keys_[square(place_m)].push_back(key); }
  template <class Use>
  void for_each_near(const Eigen::Vector2d& place_m, const Use& use) const {
    const auto [x, y] = square(place_m);
    for (int dx = -1; dx <= 1; ++dx) {
      for (int dy = -1; dy <= 1; ++dy) {
        const auto found = keys_.find({x + dx, y + dy});
        if (found == keys_.end()) continue;
        for (const int key : found->second) use(key);
      }
    }
  }

 private:
  static std::pair<int, int> square(const Eigen::Vector2d& place_m) {
    return {static_cast<int>(std::floor(place_m.x() / kVisitM)),
            static_cast<int>(std::floor(place_m.y() / kVisitM))};
  }
  std::map<std::pair<int, int>, std::vector<int>> keys_;
};

// Of those that show a side: beams pass by the legs of tables.
std::vector<Eigen::Index> solid_points(const OrientedPoints& points, Eigen::Index step) {
  std::vector<Eigen::Index> solid;
  for (Eigen::Index i = 0; i < points.points.cols(); i += step) {
    if (points.has_normal(i)) solid.push_back(i);
  }
  return solid;
}

void look(const RangeView& view, const Keyframe& other, const Pose2& from_other, Visit& visit) {
  const Eigen::Matrix2d rotation = from_other.rotation();
  for (const Eigen::Index i : solid_points(other.points_in_robot, kEveryPoint)) {
    const Eigen::Vector2d point = other.points_in_robot.points.col(i);
    const Seen seen = view.look_at(rotation * point + from_other.translation_m());
    visit.agreeing += seen == Seen::as_wall ? 1 : 0;
    visit.contradicting += seen == Seen::as_free ? 1 : 0;
  }
}

}  // namespace

Visit compare(const Keyframe& older, const Keyframe& newer, const Pose2& older_from_newer) {
  Visit visit;
  look(RangeView(older), newer, older_from_newer, visit);
  look(RangeView(newer), older, older_from_newer.inverse(), visit);
  return visit;
}

Points2 points_in_free_space(const std::vector<Keyframe>& keys,
                             const std::vector<int>& older,
                             const std::vector<int>& newer) {
  std::vector<Eigen::Vector2d> found;
  for (const int seen_from : older) {
    const Keyframe& old = keys[static_cast<std::size_t>(seen_from)];
    const RangeView view(old);
    for (const int other : newer) {
      const Keyframe& now = keys[static_cast<std::size_t>(other)];
      const Pose2 from_other = between(old.world_from_robot, now.world_from_robot);
      for (const Eigen::Index i : solid_points(now.points_in_robot, 1)) {
        const Eigen::Vector2d point = now.points_in_robot.points.col(i);
        if (view.look_at(from_other * point) != Seen::as_free) continue;
        found.push_back(now.world_from_robot * point);
      }
    }
  }
  Points2 points(2, static_cast<Eigen::Index>(found.size()));
  for (std::size_t i = 0; i < found.size(); ++i)
    points.col(static_cast<Eigen::Index>(i)) = found[i];
  return points;
}

std::vector<Visit> find_visits(const std::vector<Keyframe>& keys) {
  struct Place {
    double distance_m;
    int key;
  };
  std::vector<RangeView> views;
  views.reserve(keys.size());
  for (const Keyframe& key : keys) views.emplace_back(key);
  Squares squares;
  std::vector<Visit> visits;
  for (std::size_t newer = 0; newer < keys.size(); ++newer) {
    const Keyframe& now = keys[newer];
    const Eigen::Vector2d here = now.world_from_robot.translation_m();
    std::map<int, Place> nearest;  // of each stretch of path
    squares.for_each_near(here, [&](int key) {
      const Keyframe& old = keys[static_cast<std::size_t>(key)];
      const double distance_m = (old.world_from_robot.translation_m() - here).norm();
      if (distance_m > kVisitM || now.path_m - old.path_m < kRevisitPathM) return;
      const auto [place, is_new] =
          nearest.try_emplace(static_cast<int>(old.path_m / kStretchM), Place{distance_m, key});
      if (!is_new && distance_m < place->second.distance_m) place->second = {distance_m, key};
    });
    std::vector<Place> places;
    for (const auto& [stretch, place] : nearest) places.push_back(place);
    std::stable_sort(places.begin(), places.end(),
                     [](const Place& a, const Place& b) { return a.distance_m < b.distance_m; });
    places.resize(std::min(places.size(), kVisitsOfOne));
    for (const Place& place : places) {
      Visit visit{place.key, static_cast<int>(newer)};
      const auto older = static_cast<std::size_t>(place.key);
      const Pose2 older_from_newer = between(keys[older].world_from_robot, now.world_from_robot);
      look(views[older], now, older_from_newer, visit);
      look(views[newer], keys[older], older_from_newer.inverse(), visit);
      visits.push_back(visit);
    }
    squares.add(here, static_cast<int>(newer));
  }
  return visits;
}

}  // namespace marco::slam
