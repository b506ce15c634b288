#include "plan/outline_runs.hpp"

#include <algorithm>
#include <cmath>

#include "common/simplify_polyline.hpp"

namespace marco::plan {
namespace {

using Vector = Eigen::Vector2d;
using Run = OutlineRun;
using Line = OutlineLine;

constexpr double kBeforeM = 0.08;       // the outline runs about this far in front of a face
constexpr double kFarthestOffM = 0.24;  // ... and at most this far
constexpr double kBeyondEndM = 0.12;
constexpr int kShortRun = 3;       // steps that are no run of their own
constexpr double kLongestM = 4.0;  // furniture along a wall
constexpr double kDeepestM = 1.0;
constexpr double kDeepestInCornerM = 1.0;

}  // namespace

std::optional<Vector> crossing(const Line& a, const Line& b) {
  const double turn = a.way.x() * b.way.y() - a.way.y() * b.way.x();
  if (std::abs(turn) < 0.25) return {};
  const Vector off = b.point - a.point;
  return Vector(a.point + a.way * ((off.x() * b.way.y() - off.y() * b.way.x()) / turn));
}

// Counter-clockwise round the room, its inside on the left.
double OutlineCircle::turn_rad(const Vector& from, const Vector& to) const {
  const Vector a = from - centre, b = to - centre;
  const double first = std::atan2(a.y(), a.x()), last = std::atan2(b.y(), b.x());
  return from_inside ? turn_between(first, last) : turn_between(last, first);
}

OutlineRuns::OutlineRuns(const std::vector<OutlineStep>& outline,
                         const FloorPlan& plan,
                         const RoomRaster& raster,
                         const FreeSpace& space)
    : faces_(plan.faces),
      arcs_(plan.arcs),
      openings_(plan.openings),
      raster_(raster),
      space_(space) {
  for (const OutlineStep& step : outline) add(label(step), step.middle);
  clean();
}

void OutlineRuns::take_furniture(std::vector<PlanObject>& furniture) {
  // At walls first, or a corner's would swallow the wall between two pieces.
  for (const Place place : {Place::wall, Place::corner}) {
    while (take_one(place, furniture)) clean();
  }
}

Run OutlineRuns::label(const OutlineStep& step) const {
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

void OutlineRuns::add(Run run, const Vector& at) {
  if (runs_.empty() || !runs_.back().same(run)) runs_.push_back(std::move(run));
  runs_.back().steps.push_back(at);
}

void OutlineRuns::merge_neighbours() {
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

// Whether a run is a chord of a curved wall, and so is the next one on either side.
bool OutlineRuns::continues(std::size_t at) const {
  const std::size_t count = runs_.size();
  for (const std::size_t step : {std::size_t{1}, count - 1}) {
    std::size_t next = (at + step) % count;
    if (!runs_[next].is_line()) next = (next + step) % count;
    if (next != at && common_circle(runs_[at], runs_[next])) return true;
  }
  return false;
}

// Short runs belong to nothing; what is the same before and after them, is one.
void OutlineRuns::clean() {
  merge_neighbours();
  std::vector<std::size_t> single;
  for (std::size_t i = 0; i < runs_.size(); ++i) {
    const bool short_wall = runs_[i].kind == EdgeKind::wall && runs_[i].steps.size() <= kShortRun;
    if (short_wall && !continues(i)) single.push_back(i);
  }
  for (const std::size_t i : single) {
    runs_[i].kind = EdgeKind::unseen;
    runs_[i].index = -1;
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

bool OutlineRuns::take_one(Place place, std::vector<PlanObject>& furniture) {
  const std::size_t count = runs_.size();
  for (std::size_t i = 0; i < count; ++i) {
    std::vector<Vector> steps;
    for (std::size_t k = 1; k < std::min<std::size_t>(count, 10); ++k) {
      const Run& next = runs_[(i + k) % count];
      const bool known = k == 2 && runs_[(i + 1) % count].furnished;
      if (k > 1 && !known && stands_at(place, runs_[i], steps, next)) {
        PlanObject object;
        object.outline = simplify_polyline(steps, kOutlineToleranceM);
        furniture.push_back(std::move(object));
        std::rotate(runs_.begin(), runs_.begin() + static_cast<long>(i), runs_.end());
        runs_.erase(runs_.begin() + 1, runs_.begin() + static_cast<long>(k));
        runs_.insert(runs_.begin() + 1, Run{EdgeKind::unseen, -1, std::move(steps), true});
        return true;
      }
      const bool same_curve = common_circle(runs_[i], next).has_value();
      if (next.kind == EdgeKind::opening || (place == Place::corner && next.furnished) ||
          same_curve) {
        break;
      }
      steps.insert(steps.end(), next.steps.begin(), next.steps.end());
    }
  }
  return false;
}

bool OutlineRuns::stands_at(Place place,
                            const Run& one,
                            const std::vector<Vector>& steps,
                            const Run& next) const {
  if (!one.is_line() || !next.is_line() || steps.size() < 6) return false;
  if (const auto circle = common_circle(one, next)) {
    return place == Place::wall && stands_at_curve(*circle, one, steps, next);
  }
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

bool OutlineRuns::stands_at_curve(const OutlineCircle& circle,
                                  const Run& one,
                                  const std::vector<Vector>& steps,
                                  const Run& next) const {
  double depth = 0;
  for (const Vector& at : steps) {
    if (circle.off_m(at) < -0.05) return false;
    depth = std::max(depth, circle.off_m(at));
  }
  const Vector from = one.steps.back(), to = next.steps.front();
  const double gap = circle.radius_m * circle.turn_rad(from, to);
  return gap > 0.1 && gap < kLongestM && depth > kFarthestOffM - 0.05 && depth < kDeepestM &&
         hidden_along(circle, from, to);
}

std::optional<OutlineCircle> OutlineRuns::common_circle(const Run& one, const Run& other) const {
  if (one.kind != EdgeKind::wall || other.kind != EdgeKind::wall) return {};
  const int64_t id = faces_[static_cast<std::size_t>(one.index)].circle;
  if (id == 0 || id != faces_[static_cast<std::size_t>(other.index)].circle) return {};
  const auto arc = std::find_if(arcs_.begin(), arcs_.end(),
                                [id](const RoundWall& piece) { return piece.id == id; });
  return OutlineCircle{arc->centre_m, arc->radius_m, arc->from_inside};
}

Line OutlineRuns::line_of(const Run& run) const {
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

bool OutlineRuns::hidden_along(const OutlineCircle& circle,
                               const Vector& from,
                               const Vector& to) const {
  const double turn = circle.turn_rad(from, to) * (circle.from_inside ? 1.0 : -1.0);
  const Vector off = circle.foot(from) - circle.centre;
  int seen_through = 0, all = 0;
  for (double s = 0; s <= 1.0; s += 0.05, ++all) {
    const Pose2 turned{0, 0, s * turn};
    seen_through += space_.is_free(Vector(circle.centre + turned * off));
  }
  return seen_through <= all / 5;
}

bool OutlineRuns::hidden_between(const Vector& from, const Vector& to) const {
  int seen_through = 0, all = 0;
  for (double s = 0; s <= 1.0; s += 0.05, ++all)
    seen_through += space_.is_free(from + (to - from) * s);
  return seen_through <= all / 5;
}

}  // namespace marco::plan
