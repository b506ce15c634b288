#include "plan/plan_steps.hpp"

#include <algorithm>

#include "common/simplify_polyline.hpp"
#include "plan/curved_faces.hpp"
#include "plan/outline_runs.hpp"

namespace marco::plan {
namespace {

using Vector = Eigen::Vector2d;
using Run = OutlineRun;
using Line = OutlineLine;

constexpr double kReachM = 3.0;  // longest stretch that two faces close behind what hides it
constexpr double kReachBehindFurnitureM = 4.3;

// Joins the runs of an outline to a closed ring of edges.
class OutlineFit {
 public:
  OutlineFit(OutlineRuns& outline,
             const std::vector<WallFace>& faces,
             const std::vector<PlanOpening>& openings)
      : outline_(outline), faces_(faces), openings_(openings) {}

  std::vector<RoomEdge> run() {
    std::vector<Run>& runs = outline_.runs();
    if (runs.size() < 2) return rough();
    // Begin at a line.
    const auto first = std::find_if(runs.begin(), runs.end(), [](auto& r) { return r.is_line(); });
    if (first == runs.end()) return rough();
    std::rotate(runs.begin(), first, runs.end());
    for (std::size_t i = 0; i < runs.size();) {
      std::size_t next = i + 1;
      const Run* hidden = nullptr;
      if (!runs[next % runs.size()].is_line()) {
        hidden = &runs[next % runs.size()];
        ++next;
      }
      join(runs[i], hidden, runs[next % runs.size()]);
      i = next;
    }
    return tidy();
  }

 private:
  void put(const Vector& at, EdgeKind kind, int index) { edges_.push_back({at, at, kind, index}); }

  // From the end of one line to the begin of the next; puts the edges that begin there.
  void join(const Run& one, const Run* hidden, const Run& next) {
    const Line a = outline_.line_of(one), b = outline_.line_of(next);
    const Vector from = a.foot(one.steps.back()), to = b.foot(next.steps.front());
    const double reach = hidden != nullptr && hidden->furnished ? kReachBehindFurnitureM
                         : hidden != nullptr ? std::min(kReachM, 0.4 + hidden->length_m())
                                             : 0.4;
    if (const auto circle = outline_.common_circle(one, next)) {
      if (join_along(*circle, one, next)) return;
    }
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
        outline_.hidden_between(from, *meet) && outline_.hidden_between(*meet, to)) {
      extend(one, a, *meet, true);
      extend(next, b, *meet, false);
      return;
    }
    const double step = (b.foot(from) - from).norm();
    if (!meet && a.way.dot(b.way) > 0.9 && step < 0.05 && outline_.hidden_between(from, to)) {
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
    for (const Vector& point : simplify_polyline(hidden->steps, kOutlineToleranceM))
      put(point, EdgeKind::unseen, -1);
    put(to, EdgeKind::wall, next.index);
  }

  // @returns false where it was seen through, or the runs turn back
  bool join_along(const OutlineCircle& circle, const Run& one, const Run& next) {
    constexpr double kBackRad = 6.0;  // of a whole turn: chords overlap a little
    const Vector from = circle.foot(one.steps.back()), to = circle.foot(next.steps.front());
    const double turn = circle.turn_rad(from, to);
    if (turn < kBackRad && !outline_.hidden_along(circle, from, to)) return false;
    if (turn < kBackRad && turn * circle.radius_m > 0.35) put(from, EdgeKind::unseen, one.index);
    put(to, EdgeKind::wall, next.index);
    return true;
  }

  void join_at_jamb(
      const Run& one, const Run* hidden, const Line& a, const Run& next, const Vector& jamb) {
    Vector end = a.foot(jamb);
    if (one.kind == EdgeKind::opening) {
      end = a.point + a.way * openings_[static_cast<std::size_t>(one.index)].width_m();
    }
    const Vector last = a.foot(one.steps.back());
    if (hidden != nullptr && hidden->furnished && a.way.dot(end - last) > 0.35)
      put(last, EdgeKind::unseen, one.kind == EdgeKind::wall ? one.index : -1);
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

  std::vector<RoomEdge> rough() const {
    std::vector<Vector> all;
    for (const Run& run : outline_.runs())
      all.insert(all.end(), run.steps.begin(), run.steps.end());
    std::vector<RoomEdge> edges;
    for (const Vector& point : simplify_polyline(all, kOutlineToleranceM))
      edges.push_back({point, point, EdgeKind::unseen, -1});
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

  OutlineRuns& outline_;
  const std::vector<WallFace>& faces_;
  const std::vector<PlanOpening>& openings_;
  std::vector<RoomEdge> edges_;
};

}  // namespace

std::vector<RoomEdge> edges_of(const std::vector<OutlineStep>& outline,
                               FloorPlan& plan,
                               const RoomRaster& raster,
                               const FreeSpace& space) {
  OutlineRuns runs(outline, plan, raster, space);
  runs.take_furniture(plan.objects);
  std::vector<RoomEdge> edges = OutlineFit(runs, plan.faces, plan.openings).run();
  for (std::size_t i = 0; i < edges.size(); ++i) edges[i].to = edges[(i + 1) % edges.size()].from;
  bend_edges(edges, plan);
  return edges;
}

}  // namespace marco::plan
