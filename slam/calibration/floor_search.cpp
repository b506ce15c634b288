#include "slam/calibration/floor_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

#include "common/input/input_gates.hpp"

namespace marco::slam {
namespace {

using namespace input_gates;

constexpr std::size_t kHeadings = 12;       // of 30 degrees
constexpr std::size_t kMostOfHeading = 40;  // keyframes: more say nothing new
constexpr std::size_t kFewestOfHeading = 3;

constexpr std::size_t kBearings = 720;  // of half a degree
constexpr std::size_t kDirectionStep = 4;
constexpr std::size_t kHalfSector = 140;  // bearings to either side of a direction

// Distances in steps of 3 %; the line is three of them, for a robot that nods by a twentieth of its
// laser's pitch moves it by as much.
constexpr double kNearestM = 0.3, kStepRatio = 1.03;
constexpr std::size_t kDistances = 160;  // to 33 m
constexpr std::size_t kLineSteps = 3;

double steps_of(double ratio) { return std::log(ratio) / std::log(kStepRatio); }

double distance_m(std::size_t step) {
  return kNearestM * std::pow(kStepRatio, static_cast<double>(step));
}

/// A return in the sensor's frame.
struct Return {
  float steps;          ///< of its range, over kNearestM
  std::size_t bearing;  ///< one of kBearings
  std::size_t heading;  ///< of the sensor, one of kHeadings
};

std::size_t part_of_turn(double angle_rad, std::size_t parts) {
  const double turns = angle_rad / (2.0 * std::numbers::pi);
  return static_cast<std::size_t>((turns - std::floor(turns)) * static_cast<double>(parts)) % parts;
}

void add_returns(const Keyframe& key, std::size_t heading, std::vector<Return>& all) {
  for (Eigen::Index i = 0; i < key.points_in_robot.points.cols(); ++i) {
    const Eigen::Vector2d arm = key.points_in_robot.points.col(i) - key.sensor_in_robot;
    const double bearing_rad = std::atan2(arm.y(), arm.x()) - key.sensor_heading_rad;
    all.push_back({static_cast<float>(steps_of(arm.norm() / kNearestM)),
                   part_of_turn(bearing_rad, kBearings), heading});
  }
}

// As many keyframes of each heading, so that a corridor that was driven along for long counts as
// one.
std::vector<Return> sampled(const std::vector<Keyframe>& keys) {
  std::array<std::vector<const Keyframe*>, kHeadings> by_heading;
  for (const Keyframe& key : keys) {
    const double heading_rad = key.world_from_robot.theta_rad + key.sensor_heading_rad;
    by_heading[part_of_turn(heading_rad, kHeadings)].push_back(&key);
  }
  std::vector<Return> all;
  for (std::size_t heading = 0; heading < kHeadings; ++heading) {
    const auto& some = by_heading[heading];
    if (some.size() < kFewestOfHeading) continue;
    const std::size_t used = std::min(some.size(), kMostOfHeading);
    for (std::size_t i = 0; i < used; ++i) add_returns(*some[i * some.size() / used], heading, all);
  }
  return all;
}

/// How much nearer than its range a return is along a direction: steps, by its bearing from there.
const std::array<float, kHalfSector + 1>& foreshortening() {
  static const auto kTable = [] {
    std::array<float, kHalfSector + 1> table{};
    for (std::size_t i = 0; i < table.size(); ++i) {
      const double off_rad = 2.0 * std::numbers::pi * static_cast<double>(i) / kBearings;
      table[i] = static_cast<float>(steps_of(std::cos(off_rad)));
    }
    return table;
  }();
  return kTable;
}

/// Calls visit(return, step, side) of what is seen about a direction; `side` is the bearing from
/// the sector's edge.
template <class Visit>
void for_sector(const std::vector<Return>& all, std::size_t direction, Visit visit) {
  const auto& nearer = foreshortening();
  for (const Return& one : all) {
    const std::size_t side = (one.bearing + kBearings + kHalfSector - direction) % kBearings;
    if (side > 2 * kHalfSector) continue;
    const float steps =
        one.steps + nearer[side > kHalfSector ? side - kHalfSector : kHalfSector - side];
    if (steps < 0.0F || steps >= static_cast<float>(kDistances)) continue;
    visit(one, static_cast<std::size_t>(steps), side);
  }
}

/// Where returns are along one direction of the laser's frame. Each heading counts the same.
class Profile {
 public:
  Profile(const std::vector<Return>& all, std::size_t direction) {
    for_sector(all, direction, [this](const Return& one, std::size_t step, std::size_t) {
      counts_[one.heading][step] += 1.0F;
      of_heading_[one.heading] += 1.0F;
    });
    const auto seen = static_cast<float>(std::count_if(of_heading_.begin(), of_heading_.end(),
                                                       [](float count) { return count > 0.0F; }));
    for (std::size_t heading = 0; heading < kHeadings; ++heading) {
      if (of_heading_[heading] == 0.0F) continue;
      for (std::size_t step = 0; step < kDistances; ++step) {
        shares_[step] += counts_[heading][step] / (of_heading_[heading] * seen);
      }
    }
  }

  /// The nearest step of the line that holds most returns and has none beyond it.
  std::optional<std::size_t> line() const {
    std::optional<std::size_t> found;
    double beyond = 0.0, most = kFloorPart;
    for (std::size_t step = kDistances - kLineSteps; step > 0; --step) {
      if (beyond > kBeyondFloor) break;
      if (part_on(step) > most) {
        most = part_on(step);
        found = step;
      }
      beyond += static_cast<double>(shares_[step + kLineSteps - 1]);
    }
    return found;
  }

  double part_on(std::size_t line) const { return sum(shares_, line); }

 private:
  using ByStep = std::array<float, kDistances>;

  static double sum(const ByStep& counts, std::size_t line) {
    return std::accumulate(&counts[line], &counts[line] + kLineSteps, 0.0);
  }

  std::array<ByStep, kHeadings> counts_{};
  std::array<float, kHeadings> of_heading_{};
  ByStep shares_{};
};

// A laser's farthest range is an arc, a corner is a point.
bool is_straight(const std::vector<Return>& all, std::size_t direction, std::size_t line) {
  constexpr std::size_t kParts = 8;
  std::array<double, kParts> on_line{}, seen{};
  for_sector(all, direction, [&](const Return&, std::size_t step, std::size_t side) {
    const std::size_t part = side * kParts / (2 * kHalfSector + 1);
    seen[part] += 1.0;
    on_line[part] += step >= line && step < line + kLineSteps ? 1.0 : 0.0;
  });
  std::size_t straight = 0;
  for (std::size_t i = 0; i < kParts; ++i) {
    straight += seen[i] > 0.0 && 2.0 * on_line[i] >= kFloorPart * seen[i] ? 1 : 0;
  }
  return 2 * straight > kParts;
}

Pose2 sensor_of(const Keyframe& key) {
  const Eigen::Vector2d& at = key.sensor_in_robot;
  return key.world_from_robot * Pose2{at.x(), at.y(), key.sensor_heading_rad};
}

/// A keyframe in its sensor's frame: its returns, and the farthest of each degree.
struct KeyframeView {
  explicit KeyframeView(const Keyframe& key)
      : world_from_sensor(sensor_of(key)),
        returns_m(world_from_sensor.inverse() *
                  Points2(key.world_from_robot * key.points_in_robot.points)) {
    for (Eigen::Index i = 0; i < returns_m.cols(); ++i) {
      double& range_m = ranges_m[degree_of(returns_m.col(i))];
      range_m = std::max(range_m, returns_m.col(i).norm());
    }
  }

  static std::size_t degree_of(const Eigen::Vector2d& place_m) {
    return part_of_turn(std::atan2(place_m.y(), place_m.x()), 360);
  }
  double range_towards_m(const Eigen::Vector2d& place_m) const {
    return ranges_m[degree_of(place_m)];
  }

  Pose2 world_from_sensor;
  Points2 returns_m;
  std::array<double, 360> ranges_m{};  ///< 0 where nothing returned
};

// A line turned by less stays near itself; one turned by more may be a corridor's other side.
constexpr double kLeastTurnRad = 0.5, kMostTurnRad = 2.6;

/// What other keyframes near by, which look another way, say of the places of one line's returns.
class Witnesses {
 public:
  explicit Witnesses(const FloorLine& line)
      : across_(std::cos(deg_to_rad(line.bearing_deg)), std::sin(deg_to_rad(line.bearing_deg))),
        from_m_(line.from_m) {}

  void ask(const KeyframeView& seen, const KeyframeView& witness) {
    const Pose2 between = witness.world_from_sensor.inverse() * seen.world_from_sensor;
    const double turn_rad = std::abs(normalize_angle(between.theta_rad));
    if (turn_rad < kLeastTurnRad || turn_rad > kMostTurnRad) return;
    for (Eigen::Index i = 0; i < seen.returns_m.cols(); ++i) {
      const Eigen::Vector2d place_m = seen.returns_m.col(i);
      if (across_.dot(place_m) < from_m_) continue;
      // Were it the floor, the witness' own line would be well behind.
      const Eigen::Vector2d there_m = between * place_m;
      if (across_.dot(there_m) > 0.7 * from_m_) continue;
      const double range_m = witness.range_towards_m(there_m), far_m = there_m.norm();
      // A degree of a slanted wall, and poses of a map that the floor has bent.
      const double slack_m = 0.1 + 0.1 * far_m;
      if (range_m > far_m + slack_m) ++free_;
      if (std::abs(range_m - far_m) <= slack_m) ++standing_;
    }
  }

  bool say_it_turns() const {
    constexpr int kFewest = 200;  // returns: those of a handful of keyframes
    return free_ >= kFewest && free_ > kFloorFree * (free_ + standing_);
  }

 private:
  Eigen::Vector2d across_;
  double from_m_;
  int free_ = 0;
  int standing_ = 0;
};

// A wall stands where it is when the robot turns.
bool turns_with_robot(const std::vector<Keyframe>& keys, const FloorLine& line) {
  constexpr std::size_t kNext = 12;  // keyframes, a few metres: what lies between them errs little
  constexpr std::size_t kAsked = 600;
  const std::vector<KeyframeView> views(keys.begin(), keys.end());
  Witnesses witnesses(line);
  const std::size_t step = views.size() / kAsked + 1;
  for (std::size_t i = 0; i < views.size(); i += step) {
    for (std::size_t j = i > kNext ? i - kNext : 0; j < std::min(i + kNext, views.size()); ++j) {
      witnesses.ask(views[i], views[j]);
    }
  }
  return witnesses.say_it_turns();
}

}  // namespace

std::optional<FloorLine> find_floor(const std::vector<Keyframe>& keys) {
  const std::vector<Return> all = sampled(keys);
  std::optional<FloorLine> found;
  double most = 0.0;
  for (std::size_t direction = 0; direction < kBearings; direction += kDirectionStep) {
    const Profile profile(all, direction);
    const auto line = profile.line();
    if (!line || profile.part_on(*line) <= most) continue;
    if (!is_straight(all, direction, *line)) continue;
    most = profile.part_on(*line);
    const double turns = static_cast<double>(direction) / kBearings;
    found = FloorLine{"", 360.0 * (turns > 0.5 ? turns - 1.0 : turns), distance_m(*line)};
  }
  if (found && !turns_with_robot(keys, *found)) return std::nullopt;
  return found;
}

}  // namespace marco::slam
