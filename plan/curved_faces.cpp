#include "plan/curved_faces.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <span>
#include <tuple>

#include "slam/line_slam/circles/circle_sums.hpp"
#include "slam/line_slam/lines/fitted_line.hpp"

namespace marco::plan {
namespace {

using Vector = Eigen::Vector2d;

// Below it a column's; above it no chord of a building rises enough to be told from a wall.
constexpr double kLeastRadiusM = 0.5, kLargestRadiusM = 15.0;
constexpr double kArcBandM = 0.04;  // as of straight faces
constexpr double kArcGapM = 0.35;   // likewise
constexpr double kArcFacing = 0.9;  // cosine
constexpr double kSeedM = 0.7, kTriedM = 0.3;
constexpr double kLeastLengthM = 1.0, kLeastPieceM = 0.5, kLeastRiseM = 0.05;
constexpr double kLargestRmsM = 0.015;
constexpr double kArcPoseSigmaM = 0.003;  // of the keyframes around a place, together

double direction_of(const Vector& off) { return std::atan2(off.y(), off.x()); }

class ArcSearch {
 public:
  explicit ArcSearch(const std::vector<PlanSurfel>& surfels)
      : surfels_(surfels), tried_(surfels.size(), false) {
    found_.taken.assign(surfels.size(), false);
    means_.reserve(surfels.size());
    for (std::size_t i = 0; i < surfels.size(); ++i) {
      means_.push_back(surfels[i].mean());
      normals_.push_back(surfels[i].normal.normalized());
      cells_[cell_of(means_[i])].push_back(i);
    }
  }

  CurvedFaces run() {
    for (std::size_t i = 0; i < surfels_.size(); ++i) {
      if (!tried_[i] && !found_.taken[i]) try_from(i);
    }
    return std::move(found_);
  }

 private:
  using Members = std::vector<std::size_t>;
  /// Members in the order of their direction from the centre.
  struct Piece {
    Members members;
    double from_rad, span_rad;
  };
  struct Circle {
    Vector centre;
    double radius_m;
    bool from_inside;
  };

  static std::pair<int, int> cell_of(const Vector& at) {
    return {static_cast<int>(std::floor(at.x() / kSeedM)),
            static_cast<int>(std::floor(at.y() / kSeedM))};
  }

  Members around(std::size_t seed) const {
    Members near;
    const auto [x, y] = cell_of(means_[seed]);
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const auto cell = cells_.find({x + dx, y + dy});
        if (cell == cells_.end()) continue;
        for (const std::size_t i : cell->second) {
          const bool faces_as_well = normals_[i].dot(normals_[seed]) > 0.5;
          if (!found_.taken[i] && faces_as_well && (means_[i] - means_[seed]).norm() < kSeedM) {
            near.push_back(i);
          }
        }
      }
    }
    return near;
  }

  std::optional<Circle> circle_of(const Members& members) const {
    slam::CircleSums sums;
    const Vector origin = means_[members.front()];  // sums of far points lose digits
    for (const std::size_t i : members) sums.add_point(means_[i] - origin);
    const slam::RoughCircle rough = slam::fit_roughly(sums);
    if (!std::isfinite(rough.rms_m) || rough.radius_m < kLeastRadiusM ||
        rough.radius_m > kLargestRadiusM) {
      return {};
    }
    Circle circle{rough.centre_m + origin, rough.radius_m, false};
    double inside = 0;
    for (const std::size_t i : members) inside += normals_[i].dot(circle.centre - means_[i]);
    circle.from_inside = inside > 0;
    return circle;
  }

  Members on(const Circle& circle) const {
    Members members;
    for (std::size_t i = 0; i < surfels_.size(); ++i) {
      const Vector off = means_[i] - circle.centre;
      const double distance = off.norm();
      if (found_.taken[i] || std::abs(distance - circle.radius_m) > kArcBandM) continue;
      const double facing = normals_[i].dot(off) / distance;
      if ((circle.from_inside ? -facing : facing) > kArcFacing) members.push_back(i);
    }
    return members;
  }

  // Stretches without gaps, in order of direction.
  std::vector<Piece> pieces_of(const Circle& circle, const Members& members) const {
    std::vector<std::pair<double, std::size_t>> order;
    for (const std::size_t i : members) {
      order.emplace_back(turn_between(0, direction_of(means_[i] - circle.centre)), i);
    }
    std::sort(order.begin(), order.end());
    const double gap_rad = kArcGapM / circle.radius_m;
    // Begin behind a gap, where there is one.
    for (std::size_t i = 0; i < order.size(); ++i) {
      const double before = order[(i + order.size() - 1) % order.size()].first;
      if (order.size() > 1 && turn_between(before, order[i].first) > gap_rad) {
        std::rotate(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(i), order.end());
        break;
      }
    }
    std::vector<Piece> pieces;
    for (std::size_t i = 0; i < order.size(); ++i) {
      const auto& [angle, index] = order[i];
      if (i == 0 || turn_between(order[i - 1].first, angle) > gap_rad)
        pieces.push_back({{}, angle, 0});
      pieces.back().members.push_back(index);
      pieces.back().span_rad = turn_between(pieces.back().from_rad, angle);
    }
    const bool whole = pieces.size() == 1 && order.size() > 1 &&
                       turn_between(order.back().first, order.front().first) <= gap_rad;
    if (whole) pieces.front().span_rad = 2 * std::numbers::pi;
    return pieces;
  }

  static double length_m(const Circle& circle, const Piece& piece) {
    return circle.radius_m * piece.span_rad;
  }

  // Scattered hits are not a face.
  bool is_covered(const Circle& circle, const Piece& piece) const {
    constexpr double kStepM = 0.1, kPart = 0.7;  // of its steps
    const auto steps = static_cast<std::size_t>(std::ceil(length_m(circle, piece) / kStepM)) + 1;
    std::vector<bool> seen(steps, false);
    for (const std::size_t i : piece.members) {
      const double turn = turn_between(piece.from_rad, direction_of(means_[i] - circle.centre));
      seen[std::min(steps - 1, static_cast<std::size_t>(circle.radius_m * turn / kStepM))] = true;
    }
    return static_cast<double>(std::count(seen.begin(), seen.end(), true)) >
           kPart * static_cast<double>(steps);
  }

  void try_from(std::size_t seed) {
    Members members = around(seed);
    for (const std::size_t i : members) {
      if ((means_[i] - means_[seed]).norm() < kTriedM) tried_[i] = true;
    }
    constexpr std::size_t kLeastSeed = 10;  // three make any circle
    if (members.size() < kLeastSeed) return;
    std::optional<Circle> circle = circle_of(members);
    constexpr int kRounds = 12;  // each takes in what fits the circle before
    for (int round = 0; circle && round < kRounds; ++round) {
      const std::vector<Piece> pieces = pieces_of(*circle, on(*circle));
      const double at = direction_of(means_[seed] - circle->centre);
      const auto here = std::find_if(pieces.begin(), pieces.end(), [&](const Piece& piece) {
        return turn_between(piece.from_rad, at) <= piece.span_rad + kArcBandM / circle->radius_m;
      });
      if (here == pieces.end() || here->members.size() < kLeastSeed) return;
      const bool same = here->members == members;
      members = here->members;
      if (same) break;
      circle = circle_of(members);
    }
    if (circle) take(*circle, members);
  }

  // All that lies on the circle, if the piece that it grew from is curved.
  void take(Circle circle, const Members& grown) {
    if (!bends(circle, grown)) return;
    for (int round = 0; round < 3; ++round) {
      Members all;
      for (const Piece& piece : pieces_of(circle, on(circle))) {
        if (length_m(circle, piece) < kLeastPieceM || !is_covered(circle, piece)) continue;
        all.insert(all.end(), piece.members.begin(), piece.members.end());
      }
      if (all.empty()) return;
      const auto better = circle_of(all);
      if (!better || better->from_inside != circle.from_inside) return;
      circle = *better;
    }
    const int64_t id = found_.arcs.empty() ? 1 : found_.arcs.back().id + 1;
    double longest_m = 0;
    RoundWalls arcs;
    std::vector<Members> of_arcs;
    for (Piece& piece : pieces_of(circle, on(circle))) {
      if (length_m(circle, piece) < kLeastPieceM || !is_covered(circle, piece)) continue;
      longest_m = std::max(longest_m, length_m(circle, piece));
      RoundWall& arc = arcs.emplace_back();
      arc.id = id;
      arc.centre_m = circle.centre;
      arc.radius_m = circle.radius_m;
      arc.from_inside = circle.from_inside;
      set_ends(arc, piece);
      std::vector<int> seen;
      for (const std::size_t i : piece.members) seen.push_back(surfels_[i].keyframes);
      const auto middle = seen.begin() + static_cast<std::ptrdiff_t>(seen.size() / 2);
      std::nth_element(seen.begin(), middle, seen.end());
      arc.times_seen = *middle;
      of_arcs.push_back(std::move(piece.members));
    }
    if (longest_m < kLeastLengthM) return;
    for (const Members& members : of_arcs) {
      for (const std::size_t i : members) found_.taken[i] = true;
    }
    found_.arcs.insert(found_.arcs.end(), arcs.begin(), arcs.end());
  }

  // By points, as a straight face's: the noise along the beams reaches beyond an end.
  void set_ends(RoundWall& arc, const Piece& piece) const {
    arc.from_rad = piece.from_rad;
    arc.span_rad = piece.span_rad;
    if (arc.is_whole()) return;
    const double margin_rad = 0.1 / arc.radius_m;
    std::vector<double> turns;
    for (const std::size_t i : piece.members) {
      for (const Vector& point : surfels_[i].points) {
        turns.push_back(
            turn_between(piece.from_rad - margin_rad, direction_of(point - arc.centre_m)));
      }
    }
    std::sort(turns.begin(), turns.end());
    const double a_centimetre = 0.01 * static_cast<double>(turns.size()) /
                                (arc.radius_m * (turns.back() - turns.front()) + 0.01);
    const std::size_t cut =
        std::min(static_cast<std::size_t>(a_centimetre / 2) + 1, turns.size() / 20);
    const double first = turns[cut], last = turns[turns.size() - 1 - cut];
    arc.from_rad = normalize_angle(piece.from_rad - margin_rad + first);
    arc.span_rad = last - first;
  }

  // Whether it is round, and not straight, nor two straight walls that meet.
  bool bends(const Circle& circle, const Members& members) const {
    const std::vector<Piece> pieces = pieces_of(circle, members);
    if (pieces.size() != 1 || !is_covered(circle, pieces.front())) return false;
    const Piece& piece = pieces.front();
    const double half = std::min(piece.span_rad / 2, std::numbers::pi);
    const double rise_m = circle.radius_m * (1 - std::cos(half));
    if (length_m(circle, piece) < kLeastLengthM || rise_m < kLeastRiseM) return false;
    double squares = 0;
    std::vector<slam::LineSums> sums(1);
    for (const std::size_t i : piece.members) {
      squares += slam::square((means_[i] - circle.centre).norm() - circle.radius_m);
      sums.push_back(sums.back());
      const Vector off = means_[i] - circle.centre;
      sums.back().add_point(off.x(), off.y(), 1.0);
    }
    const std::size_t count = piece.members.size();
    if (squares > slam::square(kLargestRmsM) * static_cast<double>(count)) return false;
    const auto left = [&](std::size_t first, std::size_t last) {
      slam::LineSums of = sums[last];
      of.add(sums[first], -1.0);
      return slam::square(slam::fit_line(of).rms_m) * static_cast<double>(last - first);
    };
    double least = left(0, count);
    for (std::size_t i = 3; i + 3 <= count; ++i)
      least = std::min(least, left(0, i) + left(i, count));
    // Two straight pieces have one parameter more than an arc: half the squares is no chance.
    constexpr double kBetter = 2.0;
    return least > kBetter * squares;
  }

  const std::vector<PlanSurfel>& surfels_;
  std::vector<Vector> means_, normals_;
  std::map<std::pair<int, int>, Members> cells_;
  std::vector<bool> tried_;
  CurvedFaces found_;
};

}  // namespace

CurvedFaces find_curved_faces(const std::vector<PlanSurfel>& surfels) {
  return ArcSearch(surfels).run();
}

std::optional<slam::FittedCircle> fit_to_hits(
    const std::vector<slam::Keyframe>& keyframes,
    const Pose2& plan_from_map,
    const slam::FittedCircle& start,
    double near_m,
    const std::function<bool(const Vector& hit, const Vector& ray)>& belongs) {
  // What is left of the keyframes' errors after the joint refinement.
  constexpr double kKeyframeSigmaM = 0.005;
  constexpr double kBearingSigmaRad = 0.002;
  std::vector<slam::CircleRay> rays;
  for (const slam::Keyframe& key : keyframes) {
    const Pose2 plan_from_robot = plan_from_map * key.world_from_robot;
    const Vector origin = plan_from_robot * key.sensor_in_robot;
    const slam::OrientedPoints& points = key.points_in_robot;
    const double sigma_m = std::hypot(points.range_sigma_m, kKeyframeSigmaM);
    for (Eigen::Index i = 0; i < points.points.cols(); ++i) {
      const Vector hit = plan_from_robot * Vector(points.points.col(i));
      if (std::abs((hit - start.centre_m).norm() - start.radius_m) > near_m) continue;
      const double range_m = (hit - origin).norm();
      const Vector ray = (hit - origin) / range_m;
      if (belongs && !belongs(hit, ray)) continue;
      rays.push_back({origin, ray, range_m, sigma_m, kBearingSigmaRad});
    }
  }
  auto circle = slam::fit_circle(rays, start);
  if (!circle || (circle->centre_m - start.centre_m).norm() > near_m ||
      std::abs(circle->radius_m - start.radius_m) > near_m) {
    return {};
  }
  circle->covariance *= std::max(1.0, circle->chi2 / std::max(1, circle->hits - 3));
  return circle;
}

void measure_arcs(const std::vector<slam::Keyframe>& keyframes,
                  const Pose2& plan_from_map,
                  RoundWalls& arcs) {
  for (std::size_t first = 0, next = 0; first < arcs.size(); first = next) {
    while (next < arcs.size() && arcs[next].id == arcs[first].id) ++next;
    const std::span<RoundWall> pieces(arcs.data() + first, next - first);
    slam::FittedCircle start;
    start.centre_m = pieces[0].centre_m;
    start.radius_m = pieces[0].radius_m;
    start.from_inside = pieces[0].from_inside;
    const auto belongs = [&](const Vector& hit, const Vector& ray) {
      const Vector off = hit - start.centre_m;
      constexpr double kGrazing = 0.2;  // as of surfels
      const double facing = ray.dot(off) / off.norm();
      if ((start.from_inside ? facing : -facing) < kGrazing) return false;
      return std::any_of(pieces.begin(), pieces.end(), [&](const RoundWall& piece) {
        return turn_between(piece.from_rad, direction_of(off)) <= piece.span_rad;
      });
    };
    const auto circle = fit_to_hits(keyframes, plan_from_map, start, kArcBandM, belongs);
    for (RoundWall& piece : pieces) {
      if (circle) {
        piece.centre_m = circle->centre_m;
        piece.radius_m = circle->radius_m;
        piece.covariance = circle->covariance;
      }
      piece.covariance += kArcPoseSigmaM * kArcPoseSigmaM * Eigen::Matrix3d::Identity();
    }
  }
}

std::vector<WallFace> chords_of_arcs(const RoundWalls& arcs) {
  // Chords of 5 degrees leave their arc by a thousandth of its radius.
  constexpr double kChordM = 0.3, kChordRad = deg_to_rad(5.0);
  std::vector<WallFace> faces;
  for (const RoundWall& arc : arcs) {
    const double step_rad = std::max(kChordRad, kChordM / arc.radius_m);
    const int count = std::max(1, static_cast<int>(std::floor(arc.span_rad / step_rad)));
    for (int i = 0; i < count; ++i) {
      const auto corner = [&](int k) -> Vector {
        const double angle = arc.from_rad + arc.span_rad * k / count;
        return arc.centre_m + arc.radius_m * Vector(std::cos(angle), std::sin(angle));
      };
      const Vector from = corner(i), to = corner(i + 1);
      WallFace& face = faces.emplace_back();
      face.normal = ((from + to) / 2 - arc.centre_m).normalized() * (arc.from_inside ? -1.0 : 1.0);
      face.offset_m = face.normal.dot(from);
      std::tie(face.low_m, face.high_m) =
          std::minmax({face.along().dot(from), face.along().dot(to)});
      face.sigma_m = std::sqrt(arc.covariance(2, 2));
      face.angle_sigma_rad = face.sigma_m / arc.radius_m;
      face.keyframes = static_cast<int>(arc.times_seen);
      face.circle = arc.id;
    }
  }
  return faces;
}

void bend_edges(std::vector<RoomEdge>& loop, const FloorPlan& plan) {
  constexpr double kTinyM = 0.1;  // shorter edges are no place for a bend
  const std::size_t count = loop.size();
  const auto circle_of = [&](const RoomEdge& edge) -> int64_t {
    const bool on_face = edge.kind != EdgeKind::opening && edge.index >= 0;
    return on_face ? plan.faces[static_cast<std::size_t>(edge.index)].circle : 0;
  };
  std::vector<int64_t> circles;
  for (const RoomEdge& edge : loop) circles.push_back(circle_of(edge));
  // Steps between two chords.
  for (std::size_t i = 0; i < count; ++i) {
    const int64_t before = circles[(i + count - 1) % count];
    const RoomEdge& edge = loop[i];
    if (circles[i] == 0 && edge.kind == EdgeKind::wall && edge.length_m() < kTinyM && before != 0 &&
        before == circles[(i + 1) % count]) {
      circles[i] = before;
      loop[i].index = loop[(i + count - 1) % count].index;
    }
  }
  const auto starts = [&](std::size_t i) {
    const std::size_t before = (i + count - 1) % count;
    return circles[i] == 0 || circles[i] != circles[before] || loop[i].kind != loop[before].kind;
  };
  // All of one circle: a round room without a door.
  std::size_t first = 0;
  while (first < count && !starts(first)) ++first;
  const bool whole = first == count && count > 0;
  if (whole) first = 0;
  std::vector<RoomEdge> bent;
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t i = (first + k) % count;
    const bool half = whole && k == count / 2;
    if (bent.empty() || starts(i) || half) {
      bent.push_back(loop[i]);
    } else {
      bent.back().to = loop[i].to;
    }
  }
  for (std::size_t i = 0; i < bent.size(); ++i) {
    RoomEdge& edge = bent[i];
    const int64_t id = circle_of(edge);
    if (id == 0) continue;
    const auto arc = std::find_if(plan.arcs.begin(), plan.arcs.end(),
                                  [id](const RoundWall& one) { return one.id == id; });
    const auto onto = [&](const Vector& at) -> Vector {
      return arc->centre_m + arc->radius_m * (at - arc->centre_m).normalized();
    };
    edge.from = onto(edge.from);
    edge.to = onto(edge.to);
    const double a = direction_of(edge.from - arc->centre_m);
    const double b = direction_of(edge.to - arc->centre_m);
    const double turn = arc->from_inside ? turn_between(a, b) : -turn_between(b, a);
    edge.bulge = bulge_of(turn);
    bent[(i + bent.size() - 1) % bent.size()].to = edge.from;
    bent[(i + 1) % bent.size()].from = edge.to;
  }
  loop = std::move(bent);
}

}  // namespace marco::plan
