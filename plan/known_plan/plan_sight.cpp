#include "plan/known_plan/plan_sight.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

namespace marco::plan {
namespace {

using Vector = Eigen::Vector2d;

// Casts rays against the lines of a plan, which lie in a raster. Const: safe from several threads.
class PlanRays {
 public:
  // @param lines  at least one; outlive the object
  explicit PlanRays(const std::vector<KnownPlan::Line>& lines);

  struct Hit {
    int line = 0;
    double range_m = 0.0;
  };
  // @param way  unit
  std::optional<Hit> cast(const Eigen::Vector2d& from,
                          const Eigen::Vector2d& way,
                          double reach_m) const;
  // Whether any line passes within `radius_m`, at most the cell's size.
  bool is_near(const Eigen::Vector2d& point, double radius_m) const;

  static constexpr double kCellM = 0.5;  // of the raster that finds lines: speed alone

 private:
  const std::vector<int>* cell(int x, int y) const;

  const std::vector<KnownPlan::Line>& lines_;
  Eigen::Vector2d low_ = {0, 0};
  int width_ = 0, height_ = 0;
  std::vector<std::vector<int>> cells_;
};

double cross(const Vector& a, const Vector& b) { return a.x() * b.y() - a.y() * b.x(); }

double distance_m(const KnownPlan::Line& line, const Vector& point) {
  const Vector along = line.to - line.from;
  const double part = along.dot(point - line.from) / along.squaredNorm();
  return (line.from + std::clamp(part, 0.0, 1.0) * along - point).norm();
}

PlanRays::PlanRays(const std::vector<KnownPlan::Line>& lines) : lines_(lines) {
  Vector high = lines.front().from;
  low_ = high;
  for (const KnownPlan::Line& line : lines) {
    low_ = low_.cwiseMin(line.from).cwiseMin(line.to);
    high = high.cwiseMax(line.from).cwiseMax(line.to);
  }
  low_ -= Vector(kCellM, kCellM);
  width_ = static_cast<int>((high.x() - low_.x()) / kCellM) + 2;
  height_ = static_cast<int>((high.y() - low_.y()) / kCellM) + 2;
  cells_.resize(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const KnownPlan::Line& line = lines[i];
    const int steps = std::max(1, static_cast<int>(std::ceil(line.length_m() / (kCellM / 2))));
    for (int step = 0; step <= steps; ++step) {
      const Vector at = (line.from + (line.to - line.from) * step / steps - low_) / kCellM;
      // With its neighbours, for steps that cut a corner.
      for (int y = static_cast<int>(at.y()) - 1; y <= static_cast<int>(at.y()) + 1; ++y) {
        for (int x = static_cast<int>(at.x()) - 1; x <= static_cast<int>(at.x()) + 1; ++x) {
          if (x < 0 || y < 0 || x >= width_ || y >= height_) continue;
          auto& list = cells_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                              static_cast<std::size_t>(x)];
          if (list.empty() || list.back() != static_cast<int>(i)) {
            list.push_back(static_cast<int>(i));
          }
        }
      }
    }
  }
}

const std::vector<int>* PlanRays::cell(int x, int y) const {
  if (x < 0 || y < 0 || x >= width_ || y >= height_) return nullptr;
  return &cells_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                 static_cast<std::size_t>(x)];
}

std::optional<PlanRays::Hit> PlanRays::cast(const Vector& from,
                                            const Vector& way,
                                            double reach_m) const {
  // Lines lie in the cells about them, too: steps of a cell pass none by.
  std::optional<Hit> nearest;
  for (double gone = 0.0; gone <= reach_m; gone += kCellM) {
    if (nearest && nearest->range_m < gone - kCellM) break;
    const Vector at = (from + way * gone - low_) / kCellM;
    const auto* list =
        cell(static_cast<int>(std::floor(at.x())), static_cast<int>(std::floor(at.y())));
    if (list == nullptr) continue;
    for (const int i : *list) {
      const KnownPlan::Line& line = lines_[static_cast<std::size_t>(i)];
      const Vector along = line.to - line.from;
      const double turn = cross(way, along);
      if (std::abs(turn) < 1e-12) continue;
      const double range = cross(line.from - from, along) / turn;
      const double part = cross(line.from - from, way) / turn;
      if (range > 0 && range <= reach_m && part >= -1e-9 && part <= 1 + 1e-9 &&
          (!nearest || range < nearest->range_m)) {
        nearest = Hit{i, range};
      }
    }
  }
  return nearest;
}

bool PlanRays::is_near(const Vector& point, double radius_m) const {
  const Vector at = (point - low_) / kCellM;
  const auto* list =
      cell(static_cast<int>(std::floor(at.x())), static_cast<int>(std::floor(at.y())));
  return list != nullptr && std::any_of(list->begin(), list->end(), [&](int i) {
           return distance_m(lines_[static_cast<std::size_t>(i)], point) < radius_m;
         });
}

constexpr int kRays = 480;        // from each spot: 20 cm apart at kReachM
constexpr double kReachM = 15.0;  // rooms are smaller, and halls have many spots
constexpr double kClearM = 0.25;  // walls thicker than twice this would be looked at from inside
constexpr double kBinM = 0.05;    // of a line, seen or not

Vector way_of(int ray) {
  const double angle = 2 * std::numbers::pi * ray / kRays;
  return {std::cos(angle), std::sin(angle)};
}

// What was seen of a line, from each of its sides.
struct Seen {
  std::array<double, 2> low, high;
  std::array<std::vector<bool>, 2> bins;
};

class LookAbout {
 public:
  explicit LookAbout(const KnownPlan& plan) : plan_(plan), rays_(plan.lines) {
    for (const KnownPlan::Line& line : plan.lines) {
      const auto bins = static_cast<std::size_t>(line.length_m() / kBinM) + 1;
      seen_.push_back({{}, {}, {std::vector<bool>(bins), std::vector<bool>(bins)}});
    }
  }

  PlanSight run() {
    for (const Vector& spot : spots()) look(spot);
    for (std::size_t i = 0; i < plan_.lines.size(); ++i) {
      for (std::size_t side = 0; side < 2; ++side) face_of(i, side);
    }
    require(!sight_.faces.empty(), "leaves no free space between its lines");
    make_keyframes();
    join();
    return std::move(sight_);
  }

 private:
  // On a lattice; where a spot of it is not clear, the nearest clear one of its cell.
  std::vector<Vector> spots() const {
    constexpr double kMostSpots = 6000;  // bounds the time: a metre apart up to 6000 m2
    constexpr int kTries = 4;            // along each side of a cell
    const Vector low = plan_.low_m(), size = plan_.high_m() - low;
    const double apart = std::max(1.0, std::sqrt(size.x() * size.y() / kMostSpots));
    std::vector<Vector> found;
    for (double y = 0; y < size.y() + apart; y += apart) {
      for (double x = 0; x < size.x() + apart; x += apart) {
        std::optional<Vector> best;
        const Vector middle = low + Vector(x, y);
        for (int i = 0; i < kTries * kTries; ++i) {
          const Vector at =
              middle + apart / kTries *
                           Vector(i % kTries - kTries / 2 + 0.01, i / kTries - kTries / 2 + 0.01);
          if (rays_.is_near(at, kClearM)) continue;
          if (!best || (at - middle).norm() < (*best - middle).norm()) best = at;
        }
        if (best) found.push_back(*best);
      }
    }
    return found;
  }

  void look(const Vector& spot) {
    for (int ray = 0; ray < kRays; ++ray) {
      const Vector way = way_of(ray);
      const auto hit = rays_.cast(spot, way, kReachM);
      if (!hit) continue;
      const KnownPlan::Line& line = plan_.lines[static_cast<std::size_t>(hit->line)];
      const Vector along = (line.to - line.from).normalized();
      const std::size_t side = Vector(-along.y(), along.x()).dot(way) < 0 ? 0 : 1;
      auto& bins = seen_[static_cast<std::size_t>(hit->line)].bins[side];
      const double at = along.dot(spot + way * hit->range_m - line.from);
      bins[std::min(bins.size() - 1, static_cast<std::size_t>(std::max(0.0, at) / kBinM))] = true;
    }
  }

  void face_of(std::size_t index, std::size_t side) {
    const KnownPlan::Line& line = plan_.lines[index];
    const std::vector<bool>& bins = seen_[index].bins[side];
    const auto first = std::find(bins.begin(), bins.end(), true);
    if (first == bins.end()) return;
    const auto last = std::find(bins.rbegin(), bins.rend(), true).base();
    const auto count = std::count(first, last, true);
    // A line of which scattered spots show is seen through gaps.
    if (count * 3 < last - first && last - first > 3) return;
    const double begin = kBinM * static_cast<double>(first - bins.begin());
    const double end = std::min(line.length_m(), kBinM * static_cast<double>(last - bins.begin()));
    const Vector along = (line.to - line.from).normalized();
    DrawnFace drawn;
    drawn.curved = line.curved;
    drawn.shape = 2 * line.shape + static_cast<int>(side);
    const Vector left(-along.y(), along.x());
    drawn.face.normal = side == 0 ? left : Vector(-left);
    drawn.face.offset_m = drawn.face.normal.dot(line.from);
    const double a = drawn.face.along().dot(line.from + along * begin);
    const double b = drawn.face.along().dot(line.from + along * end);
    drawn.face.low_m = std::min(a, b);
    drawn.face.high_m = std::max(a, b);
    sight_.faces.push_back(drawn);
  }

  // A keyframe a stretch, from right before it: a plan knows walls, and not what stands in a room.
  void make_keyframes() {
    constexpr double kStretchM = 1.6;  // of wall to a keyframe, as a robot sees near by
    constexpr double kBeforeM = 0.3;   // the wall
    constexpr double kPointM = 0.04;   // between points: below a cell of the map
    constexpr double kFacing = 0.5;    // cosine: what a beam grazes is seen badly
    std::vector<Vector> points, normals;
    const auto finish = [&] {
      if (points.empty()) return;
      slam::Keyframe& key = sight_.keyframes.emplace_back();
      Vector middle = Vector::Zero();
      for (const Vector& point : points) middle += point / static_cast<double>(points.size());
      const Vector sensor = middle + kBeforeM * normals[normals.size() / 2];
      key.world_from_robot = {sensor.x(), sensor.y(), 0.0};
      key.points_in_robot.points.resize(2, static_cast<Eigen::Index>(points.size()));
      key.points_in_robot.normals = key.points_in_robot.points;
      for (std::size_t i = 0; i < points.size(); ++i) {
        key.points_in_robot.points.col(static_cast<Eigen::Index>(i)) = points[i] - sensor;
        key.points_in_robot.normals.col(static_cast<Eigen::Index>(i)) = normals[i];
      }
      points.clear();
      normals.clear();
    };
    for (const DrawnFace& drawn : sight_.faces) {
      const WallFace& face = drawn.face;
      const int count = std::max(1, static_cast<int>(face.length_m() / kPointM));
      for (int i = 0; i < count; ++i) {
        const Vector point = face.at(face.low_m + face.length_m() * (i + 0.5) / count);
        if (!points.empty() && ((point - points.front()).norm() > kStretchM ||
                                normals.front().dot(face.normal) < kFacing)) {
          finish();
        }
        points.push_back(point);
        normals.push_back(face.normal);
      }
    }
    finish();
  }

  // Pieces of one wall, such as draughtsmen leave behind.
  void join() {
    constexpr double kTurnCos = 0.99996;           // half a degree
    constexpr double kOffM = 0.003, kGapM = 0.06;  // less than a door's frame
    std::vector<DrawnFace>& faces = sight_.faces;
    std::sort(faces.begin(), faces.end(),
              [](const DrawnFace& a, const DrawnFace& b) { return a.face.low_m < b.face.low_m; });
    std::vector<DrawnFace> joined;
    // By rounded direction and offset, so that a large plan does not compare all with all.
    std::map<std::pair<int, int>, std::vector<std::size_t>> like;
    const auto place = [](const WallFace& face) {
      const double turn =
          std::remainder(std::atan2(face.normal.y(), face.normal.x()) - 0.1, 2 * std::numbers::pi);
      return std::pair(static_cast<int>(std::lround(turn * 50)),
                       static_cast<int>(std::floor(face.offset_m / 0.1)));
    };
    for (const DrawnFace& next : faces) {
      DrawnFace* same = nullptr;
      const auto [turn, offset] = place(next.face);
      for (int i = 0; i < 9 && same == nullptr && !next.curved; ++i) {
        const auto found = like.find({turn + i % 3 - 1, offset + i / 3 - 1});
        if (found == like.end()) continue;
        for (const std::size_t k : found->second) {
          WallFace& face = joined[k].face;
          const Vector begin = next.face.at(next.face.low_m), end = next.face.at(next.face.high_m);
          if (face.normal.dot(next.face.normal) > kTurnCos &&
              std::abs(face.distance_m(begin)) < kOffM && std::abs(face.distance_m(end)) < kOffM &&
              face.along().dot(begin) < face.high_m + kGapM) {
            same = &joined[k];
            face.high_m = std::max(face.high_m, face.along().dot(end));
            break;
          }
        }
      }
      if (same != nullptr) continue;
      if (!next.curved) like[{turn, offset}].push_back(joined.size());
      joined.push_back(next);
    }
    faces = std::move(joined);
  }

  const KnownPlan& plan_;
  PlanRays rays_;
  std::vector<Seen> seen_;
  PlanSight sight_;
};

}  // namespace

PlanSight look_about(const KnownPlan& plan) { return LookAbout(plan).run(); }

slam::SavedMap map_of_plan(const PlanSight& sight) {
  slam::SavedMap map;
  map.session_starts = {0};
  map.slam.keyframes.keys = sight.keyframes;
  int32_t index = 0;
  for (const slam::Keyframe& key : sight.keyframes) {
    const slam::ScanPose pose{key.utime, index++, {}};
    map.slam.path.scans.push_back(pose);
    map.slam.path.keyframe_poses.push_back(pose);
  }
  check(map);
  return map;
}

}  // namespace marco::plan
