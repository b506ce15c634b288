#include "slam/calibration/beam_fit.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

#include "common/linear_algebra.hpp"
#include "slam/matching/point_index.hpp"

namespace marco::slam {
namespace {

// Two scans so near see the same walls, from sides that differ enough to tell bearings from ranges.
constexpr double kPairWithinM = 1.0;
// Bound the time: pairs beyond that make both values no surer, for their errors are systematic.
constexpr std::size_t kMostKeys = 1500, kMostPairs = 250;
// Of fewer pairs the spread, which says how sure the values are, is itself a guess.
constexpr int kLeastPairs = 40, kLeastPoints = 30;
constexpr std::array kReachM{0.3, 0.15, 0.1, 0.08};  // of a point's wall, each round
constexpr double kWallSigmaM = 0.02;                 // of the robust kernel
constexpr double kSameNormal = 0.9;                  // cosine
constexpr int kBlocks = 20;

// What stays on real lasers: intel, fr101 and loop5, whose bearings are right to 0.1 % by the
// sharpness of their maps, give 0.2 to 0.5 %, and offsets of 5 to 20 mm.
constexpr double kScaleFloor = 3e-3, kOffsetFloorM = 0.01;
// Of most lasers' ranges, by their makers. What refutes it is believed instead.
constexpr double kOffsetPriorM = 0.01, kRefuted = 4.0;

using Matrix2 = Eigen::Matrix2d;
using Columns2 = Eigen::Matrix2Xd;

/// A keyframe's points in its sensor's frame, for some values of the beams, and how they follow
/// them.
struct View {
  Columns2 points, normals;
  Columns2 by_scale, by_offset;
};

/// Bearing and range of each point, as said.
struct Beams {
  Eigen::ArrayXd bearing_rad, range_m;
  Columns2 normals;  // in the sensor's frame
  Pose2 world_from_sensor;

  Beams(const Keyframe& key, double least_bearing_rad);
  View view(double scale, double offset_m) const;
};

Beams::Beams(const Keyframe& key, double least_bearing_rad) {
  const Pose2 robot_from_sensor{key.sensor_in_robot.x(), key.sensor_in_robot.y(),
                                key.sensor_heading_rad};
  world_from_sensor = key.world_from_robot * robot_from_sensor;
  const Eigen::Matrix2d turned_back = robot_from_sensor.rotation().transpose();
  const OrientedPoints& seen = key.points_in_robot;
  const Columns2 points = turned_back * (seen.points.colwise() - key.sensor_in_robot);
  normals = turned_back * seen.normals;
  range_m = points.colwise().norm().transpose().array();
  bearing_rad.resize(points.cols());
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    // Rounding must not take the first beam once round.
    constexpr double kSlackRad = 1e-3;
    const double from_least =
        std::atan2(points(1, i), points(0, i)) - least_bearing_rad + kSlackRad;
    constexpr double kTurn = 2.0 * std::numbers::pi;
    bearing_rad(i) =
        from_least - kTurn * std::floor(from_least / kTurn) + least_bearing_rad - kSlackRad;
  }
}

View Beams::view(double scale, double offset_m) const {
  View result;
  const Eigen::ArrayXd bearing = scale * bearing_rad, range = range_m + offset_m;
  const Eigen::ArrayXd c = bearing.cos(), s = bearing.sin();
  const Eigen::Index n = bearing.size();
  result.by_offset.resize(2, n);
  result.by_offset << c.matrix().transpose(), s.matrix().transpose();
  result.points = result.by_offset * range.matrix().asDiagonal();
  result.by_scale.resize(2, n);
  result.by_scale << -(range * bearing_rad * s).matrix().transpose(),
      (range * bearing_rad * c).matrix().transpose();
  const Eigen::ArrayXd turned = (scale - 1.0) * bearing_rad;
  const Eigen::ArrayXd nx = normals.row(0).transpose().array();
  const Eigen::ArrayXd ny = normals.row(1).transpose().array();
  result.normals.resize(2, n);
  result.normals << (turned.cos() * nx - turned.sin() * ny).matrix().transpose(),
      (turned.sin() * nx + turned.cos() * ny).matrix().transpose();
  return result;
}

struct Pair {
  std::size_t older, newer;
  Pose2 older_from_newer;  // of the sensors
};

/// Of the two values, the pair's motion eliminated.
using PairSums = NormalEquations<2>;

// One step of the pair's motion with the beams as they are, then the two values' sums there.
std::optional<PairSums> fit_pair(const View& older, const View& newer, Pair& pair, double reach_m) {
  const PointIndex walls(older.points);
  for (int step = 0;; ++step) {
    const Eigen::Matrix2d rotation = pair.older_from_newer.rotation();
    Eigen::Matrix<double, 6, 6> sums = Eigen::Matrix<double, 6, 6>::Zero();
    int used = 0;
    for (Eigen::Index i = 0; i < newer.points.cols(); ++i) {
      const Eigen::Vector2d arm = rotation * newer.points.col(i);
      const Eigen::Vector2d point = arm + pair.older_from_newer.translation_m();
      const auto wall = walls.nearest(point, reach_m);
      if (!wall) continue;
      const Eigen::Vector2d normal = older.normals.col(wall.index);
      // Points without a normal have (0, 0).
      if (normal.dot(rotation * newer.normals.col(i)) < kSameNormal) continue;
      const double error_m = normal.dot(point - older.points.col(wall.index));
      Eigen::Matrix<double, 6, 1> row;
      row << normal, normal.dot(turned_left(arm)),
          normal.dot(rotation * newer.by_scale.col(i) - older.by_scale.col(wall.index)),
          normal.dot(rotation * newer.by_offset.col(i) - older.by_offset.col(wall.index)), error_m;
      const double weight = 1.0 / (1.0 + error_m * error_m / (2.0 * kWallSigmaM * kWallSigmaM));
      sums += weight * row * row.transpose();
      ++used;
    }
    if (used < kLeastPoints) return std::nullopt;
    const Eigen::Matrix3d motion = sums.topLeftCorner<3, 3>() + 1e-6 * Eigen::Matrix3d::Identity();
    const Eigen::Matrix3d solved = motion.llt().solve(sums.topRightCorner<3, 3>());
    if (step == 0) {
      pair.older_from_newer.x_m -= solved(0, 2);
      pair.older_from_newer.y_m -= solved(1, 2);
      pair.older_from_newer.theta_rad -= solved(2, 2);
      continue;
    }
    const Eigen::Matrix3d left =
        sums.bottomRightCorner<3, 3>() - sums.topRightCorner<3, 3>().transpose() * solved;
    return PairSums{left.topLeftCorner<2, 2>(), left.topRightCorner<2, 1>()};
  }
}

std::vector<std::size_t> evenly_taken(std::size_t count, std::size_t most) {
  std::vector<std::size_t> taken(std::min(count, most));
  for (std::size_t i = 0; i < taken.size(); ++i) taken[i] = i * count / taken.size();
  return taken;
}

std::vector<Pair> pairs_among(const std::vector<Beams>& keys) {
  std::vector<Pair> all;
  for (std::size_t older = 0; older < keys.size(); ++older) {
    for (std::size_t newer = older + 1; newer < keys.size(); ++newer) {
      const Pose2 moved = between(keys[older].world_from_sensor, keys[newer].world_from_sensor);
      if (moved.translation_m().squaredNorm() > kPairWithinM * kPairWithinM) continue;
      all.push_back({older, newer, moved});
    }
  }
  std::vector<Pair> taken;
  for (const std::size_t i : evenly_taken(all.size(), kMostPairs)) taken.push_back(all[i]);
  return taken;
}

/// Of both values together.
struct Joint {
  Eigen::Vector2d value;
  Matrix2 covariance;
};

// Pairs that follow each other share places and mistakes.
Matrix2 sandwich(const std::vector<PairSums>& pairs,
                 const Matrix2& inverse,
                 const Eigen::Vector2d& step) {
  Matrix2 middle = Matrix2::Zero();
  for (std::size_t block = 0; block < kBlocks; ++block) {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (std::size_t i = block * pairs.size() / kBlocks; i < (block + 1) * pairs.size() / kBlocks;
         ++i) {
      sum += pairs[i].gradient + pairs[i].information * step;
    }
    middle += sum * sum.transpose();
  }
  return inverse * middle * inverse;
}

// A small offset and bearings that are a little off look alike: then the ranges are taken as right.
Joint with_prior(Joint joint) {
  joint.covariance(0, 0) += kScaleFloor * kScaleFloor;
  joint.covariance(1, 1) += kOffsetFloorM * kOffsetFloorM;
  if (std::abs(joint.value(1)) > kRefuted * std::sqrt(joint.covariance(1, 1))) return joint;
  const Eigen::Vector2d gain =
      joint.covariance.col(1) / (joint.covariance(1, 1) + kOffsetPriorM * kOffsetPriorM);
  joint.value -= gain * joint.value(1);
  joint.covariance -= gain * joint.covariance.row(1).eval();
  return joint;
}

// Far from being called off: more rounds change nothing of that.
bool is_ordinary(const Joint& joint) {
  constexpr double kNear = 1.5;  // standard deviations
  return std::abs(joint.value(0) - 1.0) < kNear * std::sqrt(joint.covariance(0, 0)) &&
         std::abs(joint.value(1)) < kNear * std::sqrt(joint.covariance(1, 1));
}

}  // namespace

bool Estimate::differs_from(double assumed) const {
  return std::abs(value - assumed) > kSure * sigma;
}

std::optional<BeamFit> fit_beams(const std::vector<Keyframe>& keys, double least_bearing_rad) {
  std::vector<Beams> beams;
  for (const std::size_t i : evenly_taken(keys.size(), kMostKeys)) {
    beams.emplace_back(keys[i], least_bearing_rad);
  }
  std::vector<Pair> pairs = pairs_among(beams);
  Joint joint{{1.0, 0.0}, Matrix2::Zero()};
  Joint found = joint;
  std::vector<PairSums> sums;
  for (const double reach_m : kReachM) {
    sums.clear();
    for (Pair& pair : pairs) {
      const View older = beams[pair.older].view(joint.value(0), joint.value(1));
      const View newer = beams[pair.newer].view(joint.value(0), joint.value(1));
      if (const auto fitted = fit_pair(older, newer, pair, reach_m)) sums.push_back(*fitted);
    }
    if (static_cast<int>(sums.size()) < kLeastPairs) return std::nullopt;
    const PairSums total = std::accumulate(
        sums.begin(), sums.end(), PairSums{}, [](const PairSums& a, const PairSums& b) {
          return PairSums{a.information + b.information, a.gradient + b.gradient};
        });
    // Keeps what no pair shows as it is.
    const Matrix2 inverse = (total.information + 1e-6 * Matrix2::Identity()).inverse();
    const Eigen::Vector2d step = -inverse * total.gradient;
    joint = {joint.value + step, sandwich(sums, inverse, step)};
    found = with_prior(joint);
    if (reach_m < kReachM.front() && is_ordinary(found)) break;
  }
  return BeamFit{{found.value(0), std::sqrt(found.covariance(0, 0))},
                 {found.value(1), std::sqrt(found.covariance(1, 1))}};
}

std::size_t cells_of_walls(const std::vector<Keyframe>& keys) {
  constexpr double kCellM = 0.05;  // the map's
  constexpr double kShare = 0.9;   // of the points: the rest are clutter and mixed ranges
  std::vector<std::pair<int64_t, int64_t>> cells;
  for (const Keyframe& key : keys) {
    const Columns2 points =
        (key.world_from_robot.rotation() * key.points_in_robot.points).colwise() +
        key.world_from_robot.translation_m();
    for (Eigen::Index i = 0; i < points.cols(); ++i) {
      cells.emplace_back(std::llround(points(0, i) / kCellM), std::llround(points(1, i) / kCellM));
    }
  }
  std::sort(cells.begin(), cells.end());
  std::vector<std::size_t> counts;
  for (std::size_t first = 0, end = 0; first < cells.size(); first = end) {
    while (end < cells.size() && cells[end] == cells[first]) ++end;
    counts.push_back(end - first);
  }
  std::sort(counts.begin(), counts.end(), std::greater<>());
  auto left = static_cast<std::ptrdiff_t>(kShare * static_cast<double>(cells.size()));
  std::size_t used = 0;
  while (used < counts.size() && left > 0) left -= static_cast<std::ptrdiff_t>(counts[used++]);
  return used;
}

}  // namespace marco::slam
