#include "slam/plan/room_outline.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace marco::slam {
namespace {

using Vector = Eigen::Vector2d;

constexpr double kBeforeM = 0.08;       // the outline runs about this far in front of a face
constexpr double kFarthestOffM = 0.24;  // ... and at most this far
constexpr double kBeyondEndM = 0.12;
constexpr int kShortRun = 3;       // steps that are no run of their own
constexpr double kLongestM = 4.0;  // furniture along a wall
constexpr double kDeepestM = 1.0;
constexpr double kDeepestInCornerM = 1.0;
constexpr double kReachM = 3.0;  // longest stretch that two faces close behind what hides it

// Part of an outline along one line. A line's direction: the room lies on its left.
struct Run {
  EdgeKind kind = EdgeKind::unseen;
  int index = -1;
  std::vector<Vector> steps;
  bool furnished = false;  ///< furniture was taken from here

  double length_m() const { return FreeSpace::kCellM * static_cast<double>(steps.size()); }
  bool is_line() const { return kind != EdgeKind::unseen; }
  bool same(const Run& other) const { return kind == other.kind && index == other.index; }
};

struct Line {
  Vector point, way;
  double along(const Vector& at) const { return way.dot(at - point); }
  Vector foot(const Vector& at) const { return point + way * along(at); }
};

std::optional<Vector> crossing(const Line& a, const Line& b) {
  const double turn = a.way.x() * b.way.y() - a.way.y() * b.way.x();
  if (std::abs(turn) < 0.25) return {};
  const Vector off = b.point - a.point;
  return Vector(a.point + a.way * ((off.x() * b.way.y() - off.y() * b.way.x()) / turn));
}

class OutlineFit {
 public:
  OutlineFit(const std::vector<OutlineStep>& outline,
             const std::vector<WallFace>& faces,
             const std::vector<PlanOpening>& openings,
             const RoomRaster& raster,
             const FreeSpace& space,
             std::vector<PlanObject>& furniture)
      : faces_(faces), openings_(openings), raster_(raster), space_(space) {
    for (const OutlineStep& step : outline) add(label(step), step.middle);
    clean();
    // At walls first, or a corner's would swallow the wall between two pieces.
    for (const Place place : {Place::wall, Place::corner}) {
      while (take_furniture(place, furniture)) clean();
    }
  }

  std::vector<RoomEdge> run() {
    if (runs_.size() < 2) return rough();
    // Begin at a line.
    const auto first =
        std::find_if(runs_.begin(), runs_.end(), [](auto& r) { return r.is_line(); });
    if (first == runs_.end()) return rough();
    std::rotate(runs_.begin(), first, runs_.end());
    for (std::size_t i = 0; i < runs_.size();) {
      std::size_t next = i + 1;
      const Run* hidden = nullptr;
      if (!runs_[next % runs_.size()].is_line()) {
        hidden = &runs_[next % runs_.size()];
        ++next;
      }
      join(runs_[i], hidden, runs_[next % runs_.size()]);
      i = next;
    }
    return tidy();
  }

 private:
  Run label(const OutlineStep& step) const {
    Run run;
    if (step.outside >= 0 && raster_.opening[static_cast<std::size_t>(step.outside)] >= 0) {
      run.kind = EdgeKind::opening;
      run.index = raster_.opening[static_cast<std::size_t>(step.outside)];
      return run;
    }
    double best = 1e9;
    for (std::size_t i = 0; i < faces_.size(); ++i) {
      const WallFace& face = faces_[i];
      const double off = face.distance_m(step.middle);
      const double along = face.along().dot(step.middle);
      if (off < -0.06 || off > kFarthestOffM || along < face.low_m - kBeyondEndM ||
          along > face.high_m + kBeyondEndM) {
        continue;
      }
      const double turn = face.normal.dot(step.inward);
      if (turn < 0.3) continue;
      const double cost = std::abs(off - kBeforeM) + 0.2 * (1 - turn);
      if (cost < best) {
        best = cost;
        run.kind = EdgeKind::wall;
        run.index = static_cast<int>(i);
      }
    }
    return run;
  }

  void add(Run run, const Vector& at) {
    if (runs_.empty() || !runs_.back().same(run)) runs_.push_back(std::move(run));
    runs_.back().steps.push_back(at);
  }

  void merge_neighbours() {
    std::vector<Run> merged;
    for (Run& run : runs_) {
      if (!merged.empty() && merged.back().same(run)) {
        merged.back().steps.insert(merged.back().steps.end(), run.steps.begin(), run.steps.end());
      } else {
        merged.push_back(std::move(run));
      }
    }
    if (merged.size() > 1 && merged.front().same(merged.back())) {
      Run last = std::move(merged.back());
      merged.pop_back();
      last.steps.insert(last.steps.end(), merged.front().steps.begin(), merged.front().steps.end());
      merged.front() = std::move(last);
    }
    runs_ = std::move(merged);
  }

  // Short runs belong to nothing; what is the same before and after them, is one.
  void clean() {
    merge_neighbours();
    for (Run& run : runs_) {
      if (run.kind == EdgeKind::wall && run.steps.size() <= kShortRun) {
        run.kind = EdgeKind::unseen;
        run.index = -1;
      }
    }
    merge_neighbours();
    // Of a face, a door leaf's or a cupboard's bump: the face continues behind it.
    for (std::size_t i = 0; runs_.size() > 2 && i < runs_.size(); ++i) {
      Run& run = runs_[i];
      const Run& before = runs_[(i + runs_.size() - 1) % runs_.size()];
      const Run& after = runs_[(i + 1) % runs_.size()];
      if (!run.is_line() && before.is_line() && before.same(after)) {
        run.kind = before.kind;
        run.index = before.index;
      }
    }
    merge_neighbours();
  }

  // What stands at a wall or in a corner, closes as a box, and hides what is behind it: up to 1 m
  // deep and 4 m long, as kitchens are. The wall continues behind it.
  enum class Place { wall, corner };
  bool take_furniture(Place place, std::vector<PlanObject>& furniture) {
    const std::size_t count = runs_.size();
    for (std::size_t i = 0; i < count; ++i) {
      std::vector<Vector> steps;
      for (std::size_t k = 1; k < std::min<std::size_t>(count, 10); ++k) {
        const Run& next = runs_[(i + k) % count];
        const bool known = k == 2 && runs_[(i + 1) % count].furnished;
        if (k > 1 && !known && stands_at(place, runs_[i], steps, next)) {
          PlanObject object;
          object.outline = thinned(steps);
          furniture.push_back(std::move(object));
          std::rotate(runs_.begin(), runs_.begin() + static_cast<long>(i), runs_.end());
          runs_.erase(runs_.begin() + 1, runs_.begin() + static_cast<long>(k));
          runs_.insert(runs_.begin() + 1, Run{EdgeKind::unseen, -1, std::move(steps), true});
          return true;
        }
        if (next.kind == EdgeKind::opening || (place == Place::corner && next.furnished)) break;
        steps.insert(steps.end(), next.steps.begin(), next.steps.end());
      }
    }
    return false;
  }

  bool stands_at(Place place,
                 const Run& one,
                 const std::vector<Vector>& steps,
                 const Run& next) const {
    if (!one.is_line() || !next.is_line() || steps.size() < 6) return false;
    const Line a = line_of(one), b = line_of(next);
    const Vector from = a.foot(one.steps.back()), to = b.foot(next.steps.front());
    const Vector before(-a.way.y(), a.way.x()), after(-b.way.y(), b.way.x());
    double depth_a = 0, depth_b = 0;
    for (const Vector& at : steps) {
      const double off_a = before.dot(at - a.point), off_b = after.dot(at - b.point);
      if (off_a < -0.05 || off_b < -0.05) return false;
      depth_a = std::max(depth_a, off_a);
      depth_b = std::max(depth_b, off_b);
    }
    if (a.way.dot(b.way) > 0.99) {
      const double gap = a.way.dot(to - from);
      return place == Place::wall && std::abs(before.dot(to - from)) < 0.06 && gap > 0.1 &&
             gap < kLongestM && depth_a > kFarthestOffM - 0.05 && depth_a < kDeepestM &&
             hidden_between(from, to);
    }
    if (place == Place::wall || one.kind == EdgeKind::opening || next.kind == EdgeKind::opening)
      return false;
    const auto meet = crossing(a, b);
    if (!meet || before.dot(b.way) < 0.5) return false;
    const double along_a = a.way.dot(*meet - from), along_b = b.way.dot(to - *meet);
    if (along_a < -0.1 || along_b < -0.1 || std::max(along_a, along_b) > kLongestM ||
        std::min(along_a, along_b) > kDeepestInCornerM) {
      return false;
    }
    return depth_a < std::max(along_b, kDeepestInCornerM) + 0.2 &&
           depth_b < std::max(along_a, kDeepestInCornerM) + 0.2 && hidden_between(from, *meet) &&
           hidden_between(*meet, to);
  }

  Line line_of(const Run& run) const {
    if (run.kind == EdgeKind::wall) {
      const WallFace& face = faces_[static_cast<std::size_t>(run.index)];
      // Counter-clockwise round the room, its inside on the left: along() has the normal on the
      // right, turned by -90 degrees.
      return {face.at(face.low_m), Vector(face.normal.y(), -face.normal.x())};
    }
    const PlanOpening& opening = openings_[static_cast<std::size_t>(run.index)];
    const Vector middle = run.steps[run.steps.size() / 2];
    const Vector right = opening.right();
    const bool is_right = right.dot(middle - opening.from) > opening.depth_m / 2;
    // The room on the right of from -> to goes along it backwards.
    if (is_right)
      return {opening.to + right * opening.depth_m, (opening.from - opening.to).normalized()};
    return {opening.from, (opening.to - opening.from).normalized()};
  }

  bool hidden_between(const Vector& from, const Vector& to) const {
    int seen_through = 0, all = 0;
    for (double s = 0; s <= 1.0; s += 0.05, ++all)
      seen_through += space_.is_free(from + (to - from) * s);
    return seen_through <= all / 5;
  }

  void put(const Vector& at, EdgeKind kind, int index) { edges_.push_back({at, at, kind, index}); }

  // From the end of one line to the begin of the next; puts the edges that begin there.
  void join(const Run& one, const Run* hidden, const Run& next) {
    const Line a = line_of(one), b = line_of(next);
    const Vector from = a.foot(one.steps.back()), to = b.foot(next.steps.front());
    const double reach = hidden != nullptr && hidden->furnished ? kLongestM + 0.3
                         : hidden != nullptr ? std::min(kReachM, 0.4 + hidden->length_m())
                                             : 0.4;
    if (next.kind == EdgeKind::opening) return join_at_jamb(one, hidden, a, next, b.point);
    if (one.kind == EdgeKind::opening) {
      const Vector jamb =
          a.point + a.way * openings_[static_cast<std::size_t>(one.index)].width_m();
      const Vector foot = b.foot(jamb);
      if ((foot - jamb).norm() > 0.02)
        put(jamb, (foot - jamb).norm() < 0.7 ? EdgeKind::wall : EdgeKind::unseen, -1);
      if (hidden != nullptr && hidden->furnished && b.way.dot(to - foot) > 0.35) {
        put(foot, EdgeKind::unseen, next.index);
        put(to, EdgeKind::wall, next.index);
      } else {
        put(foot, EdgeKind::wall, next.index);
      }
      return;
    }
    const auto meet = crossing(a, b);
    if (meet && (*meet - from).norm() < reach && (*meet - to).norm() < reach &&
        hidden_between(from, *meet) && hidden_between(*meet, to)) {
      extend(one, a, *meet, true);
      extend(next, b, *meet, false);
      return;
    }
    const double step = (b.foot(from) - from).norm();
    if (!meet && a.way.dot(b.way) > 0.9 && step < 0.05 && hidden_between(from, to)) {
      if ((to - from).norm() > 0.35) put(from, EdgeKind::unseen, -1);
      put(to, EdgeKind::wall, next.index);
      return;
    }
    if (hidden == nullptr || hidden->length_m() < step + 0.3) {  // a step, an end cap
      put(from, step < 0.7 ? EdgeKind::wall : EdgeKind::unseen, -1);
      put(to, EdgeKind::wall, next.index);
      return;
    }
    put(from, EdgeKind::unseen, -1);
    for (const Vector& point : thinned(hidden->steps)) put(point, EdgeKind::unseen, -1);
    put(to, EdgeKind::wall, next.index);
  }

  void join_at_jamb(
      const Run& one, const Run* hidden, const Line& a, const Run& next, const Vector& jamb) {
    Vector end = a.foot(jamb);
    if (one.kind == EdgeKind::opening) {
      end = a.point + a.way * openings_[static_cast<std::size_t>(one.index)].width_m();
    }
    const Vector last = a.foot(one.steps.back());
    if (hidden != nullptr && hidden->furnished && a.way.dot(end - last) > 0.35)
      put(last, EdgeKind::unseen, one.index);
    if ((end - jamb).norm() > 0.02)
      put(end, (end - jamb).norm() < 0.7 ? EdgeKind::wall : EdgeKind::unseen, -1);
    put(jamb, EdgeKind::opening, next.index);
  }

  // Beyond what was seen of a face, its edge is unseen.
  void extend(const Run& run, const Line& line, const Vector& corner, bool is_end) {
    const WallFace& face = faces_[static_cast<std::size_t>(run.index)];
    const Vector last = is_end ? face.at(line.way.dot(face.along()) > 0 ? face.high_m : face.low_m)
                               : face.at(line.way.dot(face.along()) > 0 ? face.low_m : face.high_m);
    const double gap =
        is_end ? line.along(corner) - line.along(last) : line.along(last) - line.along(corner);
    if (is_end) {
      if (gap > 0.35) put(last, EdgeKind::unseen, run.index);
    } else if (gap > 0.35) {
      put(corner, EdgeKind::unseen, run.index);
      put(last, EdgeKind::wall, run.index);
    } else {
      put(corner, EdgeKind::wall, run.index);
    }
  }

  static void thin(const std::vector<Vector>& points,
                   std::size_t first,
                   std::size_t last,
                   std::vector<Vector>& out) {
    double most = 0.12;
    std::size_t at = first;
    const Vector way = points[last] - points[first];
    for (std::size_t i = first + 1; i < last; ++i) {
      const Vector off = points[i] - points[first];
      const double distance = way.norm() < 1e-9
                                  ? off.norm()
                                  : std::abs(way.x() * off.y() - way.y() * off.x()) / way.norm();
      if (distance > most) most = distance, at = i;
    }
    if (at == first) return;
    thin(points, first, at, out);
    out.push_back(points[at]);
    thin(points, at, last, out);
  }

  // Douglas and Peucker.
  static std::vector<Vector> thinned(const std::vector<Vector>& points) {
    std::vector<Vector> out{points.front()};
    thin(points, 0, points.size() - 1, out);
    if (points.size() > 1) out.push_back(points.back());
    return out;
  }

  std::vector<RoomEdge> rough() const {
    std::vector<Vector> all;
    for (const Run& run : runs_) all.insert(all.end(), run.steps.begin(), run.steps.end());
    std::vector<RoomEdge> edges;
    for (const Vector& point : thinned(all)) edges.push_back({point, point, EdgeKind::unseen, -1});
    return edges;
  }

  // Without edges of no length.
  std::vector<RoomEdge> tidy() const {
    std::vector<RoomEdge> edges;
    for (std::size_t i = 0; i < edges_.size(); ++i) {
      if ((edges_[(i + 1) % edges_.size()].from - edges_[i].from).norm() > 0.005)
        edges.push_back(edges_[i]);
    }
    return edges;
  }

  const std::vector<WallFace>& faces_;
  const std::vector<PlanOpening>& openings_;
  const RoomRaster& raster_;
  const FreeSpace& space_;
  std::vector<Run> runs_;
  std::vector<RoomEdge> edges_;
};

}  // namespace

std::vector<RoomEdge> edges_of(const std::vector<OutlineStep>& outline,
                               const std::vector<WallFace>& faces,
                               const std::vector<PlanOpening>& openings,
                               const RoomRaster& raster,
                               const FreeSpace& space,
                               std::vector<PlanObject>& furniture) {
  std::vector<RoomEdge> edges =
      OutlineFit(outline, faces, openings, raster, space, furniture).run();
  for (std::size_t i = 0; i < edges.size(); ++i) edges[i].to = edges[(i + 1) % edges.size()].from;
  return edges;
}

}  // namespace marco::slam
