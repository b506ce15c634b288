#include "slam/line_slam/ekf/wall_plan.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "slam/line_slam/ekf/circle_evidence.hpp"

namespace marco::slam {
namespace {

using Vector = Eigen::Vector2d;

double cross_of(const Vector& a, const Vector& b) { return a.x() * b.y() - a.y() * b.x(); }

// Where two lines through pairs of points cross, and how that moves with these points.
struct Crossing {
  Vector at;
  Eigen::Matrix<double, 2, 8> jacobian;
};

std::optional<Crossing> cross_lines(const Eigen::Vector4d& a, const Eigen::Vector4d& b) {
  constexpr double kLeastSine = 0.34;  // 20 degrees
  const Vector way_a = a.tail<2>() - a.head<2>(), way_b = b.tail<2>() - b.head<2>();
  const double turn = cross_of(way_a, way_b);
  if (std::abs(turn) < kLeastSine * way_a.norm() * way_b.norm()) return {};
  const Vector off = b.head<2>() - a.head<2>();
  const double part_a = cross_of(off, way_b) / turn, part_b = cross_of(off, way_a) / turn;
  Crossing crossing;
  crossing.at = a.head<2>() + part_a * way_a;
  // The crossing lies on both lines: n_a . (at - a) = 0, and so for b. An end moves its line there
  // by its part.
  Eigen::Matrix2d normals;
  normals.row(0) = turned_left(way_a).transpose();
  normals.row(1) = turned_left(way_b).transpose();
  Eigen::Matrix<double, 2, 8> by_ends = Eigen::Matrix<double, 2, 8>::Zero();
  by_ends.block<1, 2>(0, 0) = (1.0 - part_a) * normals.row(0);
  by_ends.block<1, 2>(0, 2) = part_a * normals.row(0);
  by_ends.block<1, 2>(1, 4) = (1.0 - part_b) * normals.row(1);
  by_ends.block<1, 2>(1, 6) = part_b * normals.row(1);
  crossing.jacobian = normals.inverse() * by_ends;
  return crossing;
}

// Free space lies on the left of a wall: round a room one ends where the next begins.
struct Meeting {
  const Wall* ends;
  const Wall* begins;
  double apart_m;
};

std::optional<Meeting> meet(const Wall& one, const Wall& next) {
  // Ends lie up to a beam's step before the corner, far away some decimetres.
  constexpr double kSureSigmas = 3.0, kApartM = 0.05, kMostM = 0.40;
  Eigen::Vector4d a, b;
  a << one.start_m, one.end_m;
  b << next.start_m, next.end_m;
  const auto crossing = cross_lines(a, b);
  if (!crossing) return {};
  const auto apart = [&](const Wall& wall, const Vector& end, const Eigen::Matrix2d& covariance) {
    const Vector along = (wall.end_m - wall.start_m).normalized();
    const double sigma_m = std::sqrt(along.dot(covariance * along));
    const double off_m = std::abs(along.dot(crossing->at - end));
    return off_m <= std::min(kMostM, kApartM + kSureSigmas * sigma_m) ? off_m : -1.0;
  };
  const double of_one = apart(one, one.end_m, one.covariance.bottomRightCorner<2, 2>());
  const double of_next = apart(next, next.start_m, next.covariance.topLeftCorner<2, 2>());
  if (of_one < 0.0 || of_next < 0.0) return {};
  return Meeting{&one, &next, of_one + of_next};
}

}  // namespace

CornerPoints corners_of(const WallMap& map, const Walls& plan) {
  std::map<int64_t, int> block_of;
  for (const MapWall& wall : map.walls()) block_of[wall.id] = wall.block;
  std::vector<Meeting> meetings;
  for (const Wall& one : plan) {
    for (const Wall& next : plan) {
      if (one.id == next.id) continue;
      if (const auto found = meet(one, next)) meetings.push_back(*found);
    }
  }
  // Each end belongs to one corner, the nearest.
  std::stable_sort(meetings.begin(), meetings.end(),
                   [](const Meeting& a, const Meeting& b) { return a.apart_m < b.apart_m; });
  CornerPoints corners;
  std::vector<const Wall*> ended, begun;
  const auto holds = [](const std::vector<const Wall*>& walls, const Wall* wall) {
    return std::find(walls.begin(), walls.end(), wall) != walls.end();
  };
  for (const Meeting& meeting : meetings) {
    if (holds(ended, meeting.ends) || holds(begun, meeting.begins)) continue;
    ended.push_back(meeting.ends);
    begun.push_back(meeting.begins);
    const std::array<int, 2> blocks{block_of.at(meeting.ends->id), block_of.at(meeting.begins->id)};
    const Eigen::Vector4d a = map.state().mean(blocks[0]), b = map.state().mean(blocks[1]);
    const auto crossing = cross_lines(a, b);  // of whole walls, whose covariance is joint
    if (!crossing) continue;
    const Eigen::MatrixXd joint = map.state().dense_covariance(blocks).bottomRightCorner(8, 8);
    CornerPoint& corner = corners.emplace_back();
    corner.at_m = crossing->at;
    corner.covariance = crossing->jacobian * joint * crossing->jacobian.transpose();
    corner.wall_ids[0] = meeting.ends->id;
    corner.wall_ids[1] = meeting.begins->id;
    corner.convex = cross_of(a.tail<2>() - a.head<2>(), b.tail<2>() - b.head<2>()) < 0.0;
  }
  return corners;
}

Walls plan_of(const WallMap& map, int64_t min_times_seen, double min_length_m) {
  Walls plan;
  for (const MapWall& wall : map.walls()) {
    if (wall.times_seen < min_times_seen) continue;
    const Eigen::Vector4d mean = map.state().mean(wall.block);
    const Eigen::Matrix4d covariance = map.state().covariance(wall.block, wall.block);
    const double length_m = (mean.tail<2>() - mean.head<2>()).norm();
    for (const WallEvidence::Run& run : wall.evidence.runs(map.options().evidence)) {
      const double to_m = std::min(run.to_m, length_m);
      if (to_m - run.from_m < min_length_m) continue;
      const double from_part = run.from_m / length_m, to_part = to_m / length_m;
      Eigen::Matrix4d cut = Eigen::Matrix4d::Zero();
      cut.topLeftCorner<2, 2>().diagonal().setConstant(1.0 - from_part);
      cut.topRightCorner<2, 2>().diagonal().setConstant(from_part);
      cut.bottomLeftCorner<2, 2>().diagonal().setConstant(1.0 - to_part);
      cut.bottomRightCorner<2, 2>().diagonal().setConstant(to_part);
      const Eigen::Vector4d ends = cut * mean;
      Wall piece;
      piece.id = wall.id;
      piece.start_m = ends.head<2>();
      piece.end_m = ends.tail<2>();
      piece.covariance = cut * covariance * cut.transpose();
      piece.existence = wall.evidence.existence();
      piece.times_seen = wall.times_seen;
      piece.start_seen = wall.start_seen || run.from_m > 0.0;
      piece.end_seen = wall.end_seen || to_m < length_m;
      plan.push_back(std::move(piece));
    }
  }
  return plan;
}

void drop_posts_on_walls(const Walls& plan, RoundWalls& posts) {
  // Part of the radius. In eight simulated drives no wall cuts a true column; of four corners that
  // were taken for posts, two are cut along 1.1 and 1.4 radii.
  constexpr double kThrough = 1.0;
  const auto runs_through = [](const Wall& wall, const RoundWall& post) {
    const double length_m = wall.length_m();
    if (!(length_m > 0.0)) return false;
    const Eigen::Vector2d along = (wall.end_m - wall.start_m) / length_m;
    const Eigen::Vector2d to_m = post.centre_m - wall.start_m;
    const double at_m = along.dot(to_m), off2 = to_m.squaredNorm() - at_m * at_m;
    const double half_m = std::sqrt(std::max(0.0, post.radius_m * post.radius_m - off2));
    const double inside_m = std::min(length_m, at_m + half_m) - std::max(0.0, at_m - half_m);
    return inside_m >= kThrough * post.radius_m;
  };
  std::erase_if(posts, [&](const RoundWall& post) {
    return post.is_whole() && post.radius_m <= kLargestPostM &&
           std::any_of(plan.begin(), plan.end(),
                       [&](const Wall& wall) { return runs_through(wall, post); });
  });
}

}  // namespace marco::slam
