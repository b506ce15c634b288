#include "slam/calibration/floor_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
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

// Whether no wall is parallel, for most of these headings, to a line that turns with the robot.
bool tell_walls_apart(const std::vector<Return>& all) {
  std::array<bool, kHeadings> seen{};
  for (const Return& one : all) seen[one.heading] = true;
  std::complex<double> sum;
  for (std::size_t i = 0; i < kHeadings; ++i) {
    // A wall that is followed there and back stands twice: angles are doubled.
    const double half_turns = static_cast<double>(i) / static_cast<double>(kHeadings);
    if (seen[i]) sum += std::polar(1.0, 4.0 * std::numbers::pi * half_turns);
  }
  const auto count = static_cast<double>(std::count(seen.begin(), seen.end(), true));
  return count >= kFloorHeadings && std::abs(sum) <= 0.5 * count;
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

}  // namespace

std::optional<FloorLine> find_floor(const std::vector<Keyframe>& keys) {
  const std::vector<Return> all = sampled(keys);
  if (!tell_walls_apart(all)) return std::nullopt;
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
  return found;
}

}  // namespace marco::slam
