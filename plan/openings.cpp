#include "plan/plan_steps.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace marco::plan {
namespace {

constexpr double kStepM = 0.025;          // along a wall, half a cell of FreeSpace
constexpr double kNarrowestM = 0.5;       // doors are 0.6 m and wider
constexpr double kWidestM = 3.0;          // gates and double doors; wider ones are rooms that join
constexpr double kWidestAtCornerM = 1.3;  // one leaf: a wall that ends leaves wider gaps as well
constexpr double kOneLineM = 0.06;        // how far two faces of one wall line may lie apart
constexpr double kThickestM = 0.65;       // wall
constexpr double kUnseenM = 0.3;
constexpr double kJogM = 0.25;  // ... on both sides of a door
constexpr double kParallel = 0.98;
constexpr double kParallelBent = 0.7;  // of chords of one circle, on both sides of an opening

using Vector = Eigen::Vector2d;

struct Candidate {
  PlanOpening opening;
  Vector normal;  // of the face that it continues
  bool two_jambs = false;
};

// Free stretch through `at`, both ways along `way`.
double free_width(const FreeSpace& space, const Vector& at, const Vector& way) {
  double width = 0;
  for (const double side : {1.0, -1.0}) {
    double s = 0;
    for (; s < kWidestM + 1 && space.is_free(at + way * (side * s)); s += kStepM) {
      width += kStepM;
    }
    // Where nothing was hit, it continues, only nobody looked.
    const int end = space.cell_of(at + way * (side * (s + 0.05)));
    if (end >= 0 && !space.is_hit(end)) width += kUnseenM;
  }
  return width;
}

bool is_bottleneck(const FreeSpace& space, const PlanOpening& opening) {
  const Vector way = (opening.to - opening.from).normalized();
  const Vector across(-way.y(), way.x());
  const Vector middle = (opening.from + opening.to) / 2;
  const double here = free_width(space, middle, way);
  for (const double side : {1.0, -1.0}) {
    bool wider = false;
    for (double s = 0.1; s < 0.8 && !wider; s += 0.05) {
      const Vector at = middle + across * (side * s);
      if (!space.is_free(at)) break;
      wider = free_width(space, at, way) > here + 0.15;
    }
    if (!wider) return false;
  }
  return true;
}

class OpeningSearch {
 public:
  OpeningSearch(const FloorPlan& plan, const FreeSpace& space)
      : faces_(plan.faces), arcs_(plan.arcs), space_(space) {}

  std::optional<Candidate> beyond(const WallFace& face, bool high_end) const {
    const Vector jamb = face.at(high_end ? face.high_m : face.low_m);
    double s = 0;
    while (s < 0.25 && !space_.is_free(continued(face, high_end, s))) s += kStepM;
    if (s >= 0.25) return {};
    while (s < kWidestM + 0.2 && space_.is_free(continued(face, high_end, s))) s += kStepM;
    if (s < kNarrowestM - 0.2 || s >= kWidestM + 0.2) return {};
    const Vector way = (continued(face, high_end, s) - jamb).normalized();
    Candidate candidate;
    candidate.normal = face.normal;
    candidate.opening.from = jamb;
    const double far = far_jamb(face, jamb, way, s, candidate);
    if (far < kNarrowestM || far > kWidestM) return {};
    if (!candidate.two_jambs && far > kWidestAtCornerM) return {};
    // How well an end is known: the beams' spacing there, by far most of the error.
    candidate.opening.sigma_m = candidate.two_jambs ? 0.014 : 0.01;
    if (!is_bottleneck(space_, candidate.opening)) return {};
    return candidate;
  }

 private:
  // Where the face would be beyond its end.
  Vector continued(const WallFace& face, bool high_end, double beyond_m) const {
    const Vector jamb = face.at(high_end ? face.high_m : face.low_m);
    const Vector way = high_end ? face.along() : Vector(-face.along());
    if (face.circle == 0) return jamb + way * beyond_m;
    const auto arc = std::find_if(arcs_.begin(), arcs_.end(),
                                  [&](const RoundWall& one) { return one.id == face.circle; });
    const Vector out = jamb - arc->centre_m;
    const double side = out.x() * way.y() - out.y() * way.x() > 0 ? 1.0 : -1.0;
    return arc->centre_m + Pose2{0, 0, side * beyond_m / arc->radius_m} * out;
  }

  double far_jamb(const WallFace& face,
                  const Vector& jamb,
                  const Vector& way,
                  double s,
                  Candidate& candidate) const {
    double best = -1, corner = -1;
    for (const WallFace& other : faces_) {
      const double turn = other.normal.dot(face.normal);
      const bool bends = face.circle != 0 && face.circle == other.circle;
      if (std::abs(turn) > (bends ? kParallelBent : kParallel)) {
        const bool low_first = other.along().dot(way) > 0;
        const Vector end = other.at(low_first ? other.low_m : other.high_m);
        const double at = way.dot(end - jamb);
        const Vector to_end = end - jamb;
        const double off = std::abs(way.x() * to_end.y() - way.y() * to_end.x());
        const double most = at < kWidestAtCornerM ? kJogM : kOneLineM;
        if (off > most || at < s - 0.15 || at > s + 0.25) continue;
        if (best < 0 || at + off < best) {
          best = at + off;
          // A face that looks the other way is the wall's back: its end tells how far, not how
          // deep.
          candidate.opening.to = turn > 0 ? end : Vector(jamb + way * at);
        }
      } else if (std::abs(turn) < 0.5 && other.normal.dot(way) < 0) {
        const double at = -other.distance_m(jamb) / other.normal.dot(way);
        const double along = other.along().dot(jamb + way * at);
        if (at < s - 0.15 || at > s + 0.25 || along < other.low_m - 0.15 ||
            along > other.high_m + 0.15) {
          continue;
        }
        corner = at;
      }
    }
    candidate.two_jambs = best > 0;
    if (!candidate.two_jambs && corner > 0) candidate.opening.to = jamb + way * corner;
    return candidate.two_jambs ? candidate.opening.width_m() : corner;
  }

  const std::vector<WallFace>& faces_;
  const RoundWalls& arcs_;
  const FreeSpace& space_;
};

bool overlap(const PlanOpening& a, const PlanOpening& b) {
  const Vector way = (a.to - a.from).normalized();
  const double first = way.dot(b.from - a.from), last = way.dot(b.to - a.from);
  return std::min(std::max(first, last), a.width_m()) - std::max(std::min(first, last), 0.0) >
         0.3 * std::min(a.width_m(), b.width_m());
}

// The same gap, seen from the wall's other side or from its other jamb. @returns whether it is
bool join(Candidate& known, const Candidate& other) {
  PlanOpening& opening = known.opening;
  const Vector way = (opening.to - opening.from).normalized();
  if (std::abs(way.dot((other.opening.to - other.opening.from).normalized())) < kParallel) {
    return false;
  }
  const double shift = known.normal.dot(other.opening.from - opening.from);
  if (std::abs(shift) > kThickestM || !overlap(opening, other.opening)) return false;
  if (known.normal.dot(other.normal) < 0 && shift < -0.03) {
    if (opening.right().dot(known.normal) > 0) std::swap(opening.from, opening.to);
    opening.depth_m = -shift;
  }
  return true;
}

bool cross(const PlanOpening& a, const PlanOpening& b) {
  const auto side = [](const PlanOpening& line, const Vector& point) {
    const Vector way = line.to - line.from, off = point - line.from;
    return way.x() * off.y() - way.y() * off.x();
  };
  return side(a, b.from) * side(a, b.to) < 0 && side(b, a.from) * side(b, a.to) < 0;
}

}  // namespace

std::vector<PlanOpening> find_openings(const FloorPlan& plan, const FreeSpace& space) {
  const OpeningSearch search(plan, space);
  std::vector<Candidate> candidates;
  for (const WallFace& face : plan.faces) {
    for (const bool high_end : {true, false}) {
      if (const auto found = search.beyond(face, high_end)) candidates.push_back(*found);
    }
  }
  std::stable_sort(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) {
    return a.two_jambs != b.two_jambs ? a.two_jambs : a.opening.width_m() < b.opening.width_m();
  });
  std::vector<Candidate> kept;
  for (const Candidate& candidate : candidates) {
    const bool known = std::any_of(kept.begin(), kept.end(), [&](Candidate& one) {
      return join(one, candidate) || cross(one.opening, candidate.opening);
    });
    if (!known) kept.push_back(candidate);
  }
  std::vector<PlanOpening> openings;
  for (const Candidate& candidate : kept) openings.push_back(candidate.opening);
  return openings;
}

namespace {

// A stretch of a face that may be a leaf: from the wall to its tip.
struct Leaf {
  double foot_m, tip_m;  // along the face

  double length_m() const { return std::abs(tip_m - foot_m); }
};

constexpr double kHingeM = 0.2;  // of a jamb: a leaf's thickness and a wall's cap

// A leaf lies on one line with the cap of the wall at its hinge, and by chance with what stands
// beyond: where a face passes a jamb, either side may be the leaf, from that side of the wall on.
std::vector<Leaf> leaves_at(const WallFace& face, const Vector& jamb, const PlanOpening& opening) {
  std::vector<Leaf> leaves;
  const double one_m = face.along().dot(jamb);
  const double other_m = one_m + face.along().dot(opening.right()) * opening.depth_m;
  const double low_m = std::min(one_m, other_m), high_m = std::max(one_m, other_m);
  const double above_m = std::clamp(high_m, face.low_m, face.high_m);
  const double below_m = std::clamp(low_m, face.low_m, face.high_m);
  if (std::abs(above_m - high_m) <= kHingeM) leaves.push_back({above_m, face.high_m});
  if (std::abs(below_m - low_m) <= kHingeM) leaves.push_back({below_m, face.low_m});
  return leaves;
}

class LeafSearch {
 public:
  LeafSearch(std::vector<PlanOpening>& openings, const FreeSpace& space)
      : openings_(openings), space_(space) {}

  // @returns whether the face is a leaf; what else was part of it is put to `rests`
  bool take(const WallFace& face, std::vector<WallFace>& rests) {
    for (PlanOpening& opening : openings_) {
      const Vector way = (opening.to - opening.from).normalized();
      if (std::abs(face.along().dot(way)) > 0.985) continue;
      for (const Vector& jamb : {opening.from, opening.to}) {
        if (std::abs(face.distance_m(jamb)) > kHingeM) continue;
        for (const Leaf& leaf : leaves_at(face, jamb, opening)) {
          if (!is_leaf(face, leaf, opening)) continue;
          opening.has_leaf = true;
          opening.hinge = jamb;
          opening.leaf_end = face.at(leaf.tip_m);
          if (const WallFace rest = rest_of_leaf(face, leaf); is_solid(rest)) rests.push_back(rest);
          return true;
        }
      }
    }
    return false;
  }

 private:
  bool is_leaf(const WallFace& face, const Leaf& leaf, const PlanOpening& opening) const {
    const double part = leaf.length_m() / opening.width_m();
    const Vector middle = face.at((leaf.foot_m + leaf.tip_m) / 2), tip = face.at(leaf.tip_m);
    const Vector out = (tip - face.at(leaf.foot_m)).normalized();
    if (part < 0.75 || part > 1.25 || !space_.is_free(middle + face.normal * 0.2) ||
        !space_.is_free(tip + out * 0.2)) {
      return false;
    }
    // A wall that passes a jamb is solid on both sides of it, and thicker than a leaf.
    constexpr double kBehindM = 0.16;
    return !is_solid(rest_of_leaf(face, leaf)) ||
           space_.is_free(Vector(middle - face.normal * kBehindM));
  }

  static WallFace rest_of_leaf(WallFace face, const Leaf& leaf) {
    (leaf.tip_m > leaf.foot_m ? face.high_m : face.low_m) = leaf.foot_m;
    return face;
  }

  // Longer than a wall's cap, and hardly a beam went through it.
  bool is_solid(const WallFace& rest) const {
    constexpr double kLeastRestM = 0.3, kFreePart = 0.3;  // of the places along it
    int free = 0, all = 0;
    for (double s = rest.low_m; s <= rest.high_m; s += kStepM, ++all)
      free += space_.is_free(rest.at(s));
    return rest.length_m() >= kLeastRestM && free < kFreePart * all;
  }

  std::vector<PlanOpening>& openings_;
  const FreeSpace& space_;
};

}  // namespace

void take_leaves(std::vector<WallFace>& faces,
                 std::vector<PlanOpening>& openings,
                 const FreeSpace& space) {
  LeafSearch search(openings, space);
  std::vector<WallFace> rests;
  std::erase_if(faces,
                [&](const WallFace& face) { return face.circle == 0 && search.take(face, rests); });
  faces.insert(faces.end(), rests.begin(), rests.end());
}

}  // namespace marco::plan
