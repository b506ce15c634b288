#include "slam/plan/openings.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace marco::slam {
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
  OpeningSearch(const std::vector<WallFace>& faces, const FreeSpace& space)
      : faces_(faces), space_(space) {}

  std::optional<Candidate> beyond(const WallFace& face, bool high_end) const {
    const Vector way = high_end ? face.along() : Vector(-face.along());
    const Vector jamb = face.at(high_end ? face.high_m : face.low_m);
    double s = 0;
    while (s < 0.25 && !space_.is_free(jamb + way * s)) s += kStepM;
    if (s >= 0.25) return {};
    while (s < kWidestM + 0.2 && space_.is_free(jamb + way * s)) s += kStepM;
    if (s < kNarrowestM - 0.2 || s >= kWidestM + 0.2) return {};
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
  double far_jamb(const WallFace& face,
                  const Vector& jamb,
                  const Vector& way,
                  double s,
                  Candidate& candidate) const {
    double best = -1, corner = -1;
    for (const WallFace& other : faces_) {
      const double turn = other.normal.dot(face.normal);
      if (std::abs(turn) > kParallel) {
        const bool low_first = other.along().dot(way) > 0;
        const Vector end = other.at(low_first ? other.low_m : other.high_m);
        const double at = way.dot(end - jamb);
        const double off = std::abs(face.distance_m(end));
        const double most = at < kWidestAtCornerM ? kJogM : kOneLineM;
        if (off > most || at < s - 0.15 || at > s + 0.25) continue;
        if (best < 0 || at + off < best) {
          best = at + off;
          candidate.opening.to = end;
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

std::vector<PlanOpening> find_openings(const std::vector<WallFace>& faces, const FreeSpace& space) {
  const OpeningSearch search(faces, space);
  std::vector<Candidate> candidates;
  for (const WallFace& face : faces) {
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

void take_leaves(std::vector<WallFace>& faces,
                 std::vector<PlanOpening>& openings,
                 const FreeSpace& space) {
  const auto is_leaf = [&](const WallFace& face) {
    const Vector middle = face.at((face.low_m + face.high_m) / 2);
    if (!space.is_free(middle + face.normal * 0.2)) return false;
    for (PlanOpening& opening : openings) {
      const double part = face.length_m() / opening.width_m();
      const Vector way = (opening.to - opening.from).normalized();
      if (part < 0.75 || part > 1.25 || std::abs(face.along().dot(way)) > 0.985) continue;
      for (const Vector& jamb : {opening.from, opening.to}) {
        for (const bool high : {true, false}) {
          const Vector foot = face.at(high ? face.high_m : face.low_m);
          const Vector tip = face.at(high ? face.low_m : face.high_m);
          if ((foot - jamb).norm() > 0.2 || !space.is_free(tip + (tip - foot).normalized() * 0.2))
            continue;
          opening.has_leaf = true;
          opening.hinge = jamb;
          opening.leaf_end = tip;
          return true;
        }
      }
    }
    return false;
  };
  std::erase_if(faces, is_leaf);
}

}  // namespace marco::slam
