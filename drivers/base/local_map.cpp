#include "drivers/base/local_map.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace marco::drivers {
namespace {

// Powers of two of cells, over twice kReachM.
constexpr int32_t kHitCells = 128, kPlaces = 64;
constexpr double kHitCellM = 2.0 * LocalMap::kReachM / kHitCells;
constexpr double kPlaceM = 2.0 * LocalMap::kReachM / kPlaces;
constexpr double kMattersToM = 2.5;  // from the sensor: what is farther is looked at again
constexpr double kSeenNowS = 1.5;
constexpr int kPasses = 3;         // of scans take a point away
constexpr double kBesideM = 0.01;  // a beam that passes so near a point
constexpr double kBeyondM = 0.10;  // takes it away if it ends this far behind it
constexpr double kSameHeightM = 0.05;
constexpr double kDeepM = 0.05;      // in the body, where nothing stands
constexpr double kLeastLevel = 0.2;  // steeper beams see next to nothing of the floor plan

int32_t cell_of(double value_m, double cell_m) {
  const double cell = value_m / cell_m;
  const auto towards_zero = static_cast<int32_t>(cell);
  return towards_zero - (cell < towards_zero ? 1 : 0);
}

std::size_t wrapped(int32_t x, int32_t y, int32_t cells) {
  return static_cast<std::size_t>((y & (cells - 1)) * cells + (x & (cells - 1)));
}

template <class Visit>
void for_cells_about(const Eigen::Vector2d& middle, double reach_m, double cell_m, Visit visit) {
  for (int32_t y = cell_of(middle.y() - reach_m, cell_m);
       y <= cell_of(middle.y() + reach_m, cell_m); ++y) {
    for (int32_t x = cell_of(middle.x() - reach_m, cell_m);
         x <= cell_of(middle.x() + reach_m, cell_m); ++x) {
      visit(x, y);
    }
  }
}

/// As far as a beam says that the way is free.
double free_to_m(const SeenBeam& beam, double when_no_answer_m) {
  switch (beam.end) {
    case SeenBeam::End::hit:
      return beam.range_m;
    case SeenBeam::End::far:
      return kMattersToM;
    case SeenBeam::End::no_answer:
      return when_no_answer_m;
    default:
      return 0.0;
  }
}

/// The turn from one direction to another, on the floor.
double turn_to(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  return std::atan2(from.x() * to.y() - from.y() * to.x(), from.x() * to.x() + from.y() * to.y());
}

/// The beam that passes nearest to a point. Each may begin elsewhere and look anywhere, but their
/// bearings grow about evenly.
std::size_t beam_towards(std::span<const SeenBeam> beams, const Eigen::Vector3d& point_m) {
  const auto last = static_cast<double>(beams.size() - 1);
  const std::size_t quarter = std::max<std::size_t>(1, beams.size() / 4);  // no full turn
  const double step_rad =
      turn_to(beams.front().along, beams[quarter].along) / static_cast<double>(quarter);
  if (step_rad == 0.0) return 0;
  double i = static_cast<double>(beams.size() / 2);
  for (int round = 0; round < 3; ++round) {
    const SeenBeam& beam = beams[static_cast<std::size_t>(i)];
    const double off_rad = turn_to(beam.along, point_m - beam.from_m);
    i = std::clamp(i + std::round(off_rad / step_rad), 0.0, last);
  }
  return static_cast<std::size_t>(i);
}

}  // namespace

LocalMap::LocalMap() : hits_(kHitCells * kHitCells), places_(kPlaces * kPlaces) {}

LocalMap::Place& LocalMap::place_at(double x_m, double y_m) {
  const int32_t x = cell_of(x_m, kPlaceM), y = cell_of(y_m, kPlaceM);
  Place& place = places_[wrapped(x, y, kPlaces)];
  if (place.x != x || place.y != y) place = {x, y, {}, {}};
  return place;
}

void LocalMap::on_body(const Footprint& body, const Pose2& odom_from_robot, Utime now) {
  const Pose2 robot_from_odom = odom_from_robot.inverse();
  const Eigen::Vector2d here = odom_from_robot.translation_m();
  const double r = body.radius_m();
  for_cells_about(here, r, kPlaceM, [&](int32_t x, int32_t y) {
    const Eigen::Vector2d middle = kPlaceM * Eigen::Vector2d(x + 0.5, y + 0.5);
    if (body.distance_m(robot_from_odom * middle) < 0.0)
      place_at(middle.x(), middle.y()).covered = now;
  });
  for_cells_about(here, r, kHitCellM, [&](int32_t x, int32_t y) {
    Hit& hit = hits_[wrapped(x, y, kHitCells)];
    if (hit.when == Utime{}) return;
    if (body.distance_m(robot_from_odom * Eigen::Vector2d(hit.point_m.head<2>())) < -kDeepM)
      hit = {};
  });
}

void LocalMap::on_beams(std::span<const SeenBeam> beams, const Heights& counted, Utime now) {
  for (const SeenBeam& beam : beams) see(beam, counted, now);
  if (beams.size() > 2) pass_points(beams);
  for (const SeenBeam& beam : beams) insert(beam, counted, now);
}

void LocalMap::see(const SeenBeam& beam, const Heights& counted, Utime now) {
  const double level = beam.along.head<2>().norm();
  if (level < kLeastLevel) return;
  const double to_m = std::min(free_to_m(beam, kMattersToM), kMattersToM);
  for (double at_m = 0.0; at_m < to_m; at_m += kPlaceM / level) {
    const Eigen::Vector3d point = beam.from_m + at_m * beam.along;
    if (counted.contain(point.z())) place_at(point.x(), point.y()).seen = now;
  }
}

void LocalMap::pass_points(std::span<const SeenBeam> beams) {
  constexpr double kAny = std::numeric_limits<double>::infinity();
  const SeenBeam& middle = beams[beams.size() / 2];
  for_cells_about(middle.from_m.head<2>(), kMattersToM, kHitCellM, [&](int32_t x, int32_t y) {
    Hit& hit = hits_[wrapped(x, y, kHitCells)];
    if (hit.when == Utime{}) return;
    const std::size_t i = beam_towards(beams, hit.point_m);
    if (i == 0 || i + 1 == beams.size()) return;  // the neighbour is unknown
    // A neighbour without an answer says neither yes nor no.
    const double free_m = std::min(
        {free_to_m(beams[i], 0.0), free_to_m(beams[i - 1], kAny), free_to_m(beams[i + 1], kAny)});
    const Eigen::Vector3d to_hit = hit.point_m - beams[i].from_m;
    const double along_m = to_hit.dot(beams[i].along);
    const Eigen::Vector3d beside = to_hit - along_m * beams[i].along;
    if (along_m + kBeyondM > free_m || beside.head<2>().norm() > kBesideM ||
        std::abs(beside.z()) > kSameHeightM) {
      return;
    }
    if (++hit.passes == kPasses) hit = {};
  });
}

void LocalMap::insert(const SeenBeam& beam, const Heights& counted, Utime now) {
  if (beam.end != SeenBeam::End::hit) return;
  const Eigen::Vector3d point = beam.tip_m();
  const bool is_near = (point - beam.from_m).head<2>().cwiseAbs().maxCoeff() < kReachM - 0.5;
  if (!is_near || !counted.contain(point.z())) return;
  Hit& hit =
      hits_[wrapped(cell_of(point.x(), kHitCellM), cell_of(point.y(), kHitCellM), kHitCells)];
  // Of one scan's hits the nearest.
  if (hit.when == now && (hit.point_m - beam.from_m).norm() < beam.range_m) return;
  hit = {point, now};
}

void LocalMap::on_ray(const Eigen::Vector2d& from_m, const Eigen::Vector2d& to_m, Utime now) {
  const Eigen::Vector2d way = to_m - from_m;
  const double length_m = std::min(way.norm(), kMattersToM);
  for (double at_m = 0.0; at_m < length_m; at_m += kPlaceM) {
    const Eigen::Vector2d point = from_m + at_m / way.norm() * way;
    place_at(point.x(), point.y()).seen = now;
  }
}

std::vector<Eigen::Vector2d> LocalMap::points_about(const Pose2& odom_from_robot,
                                                    double reach_m,
                                                    Utime now) const {
  std::vector<Eigen::Vector2d> points;
  const double r = std::min(reach_m, kReachM - kHitCellM);
  const Pose2 robot_from_odom = odom_from_robot.inverse();
  const Eigen::Matrix2d turn = robot_from_odom.rotation();
  const Eigen::Vector2d shift = robot_from_odom.translation_m(),
                        here = odom_from_robot.translation_m();
  for_cells_about(here, r, kHitCellM, [&](int32_t x, int32_t y) {
    const Hit& hit = hits_[wrapped(x, y, kHitCells)];
    if (!is_within(kRememberedS, hit.when, now)) return;
    const Eigen::Vector2d point = hit.point_m.head<2>();
    // An entry may hold a point of eight metres away.
    if ((point - here).cwiseAbs().maxCoeff() <= r + kHitCellM)
      points.push_back(turn * point + shift);
  });
  return points;
}

LocalMap::Ground LocalMap::ground_at(const Eigen::Vector2d& point_m, Utime now) const {
  const int32_t x0 = cell_of(point_m.x(), kPlaceM), y0 = cell_of(point_m.y(), kPlaceM);
  Ground ground = Ground::unknown;
  for_cells_about(point_m, kPlaceM, kPlaceM, [&](int32_t x, int32_t y) {
    const Place& place = places_[wrapped(x, y, kPlaces)];
    if (place.x != x || place.y != y) return;
    const bool covered = x == x0 && y == y0 && is_within(kRememberedS, place.covered, now);
    if (is_within(kSeenNowS, place.seen, now)) ground = Ground::seen;
    if (is_within(kRememberedS, place.seen, now) || covered)
      ground = std::max(ground, Ground::remembered);
  });
  return ground;
}

}  // namespace marco::drivers
