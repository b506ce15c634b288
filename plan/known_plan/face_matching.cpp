#include "plan/known_plan/face_matching.hpp"

#include <algorithm>
#include <cmath>

#include "common/median.hpp"

namespace marco::plan {
namespace {

using Vector = Eigen::Vector2d;

double overlap_m(const WallFace& drawn, const WallFace& face) {
  const double a = drawn.along().dot(face.at(face.low_m));
  const double b = drawn.along().dot(face.at(face.high_m));
  return std::min(std::max(a, b), drawn.high_m) - std::max(std::min(a, b), drawn.low_m);
}

bool is_same_wall(const WallFace& drawn, const WallFace& face) {
  constexpr double kFacing = 0.985;  // cosine of 10 degrees
  const double overlap = overlap_m(drawn, face);
  return face.normal.dot(drawn.normal) > kFacing && overlap > 0.1 &&
         overlap > 0.4 * std::min(face.length_m(), drawn.length_m()) &&
         std::abs(drawn.distance_m(face.at((face.low_m + face.high_m) / 2))) < kSameWallM;
}

}  // namespace

bool is_one_line(const WallFace& front, const WallFace& back) {
  constexpr double kSameLineM = 0.005;    // a plan is drawn more exactly
  constexpr double kLeastOverlapM = 0.3;  // two lines that only touch are two walls
  return back.normal.dot(front.normal) < -0.9999 &&
         std::abs(back.offset_m + front.offset_m) < kSameLineM &&
         overlap_m(front, back) > kLeastOverlapM;
}

// How far the nearest drawn face is that it can belong to: what another wall explains is none of
// this one's.
double FaceMatching::nearest_drawn_m(const WallFace& face) const {
  // The end of a wall that meets another one explains none of that.
  constexpr double kLeastM = 0.3;
  const Vector middle = face.at((face.low_m + face.high_m) / 2);
  double nearest = kSameWallM;
  for (const DrawnFace& drawn : drawn_) {
    if (drawn.curved || drawn.face.length_m() < kLeastM || !is_same_wall(drawn.face, face))
      continue;
    nearest = std::min(nearest, std::abs(drawn.face.distance_m(middle)));
  }
  return nearest;
}

std::vector<std::size_t> FaceMatching::faces_on(const WallFace& drawn) const {
  std::vector<std::size_t> near;
  for (std::size_t i = 0; i < measured_.size(); ++i) {
    if (is_same_wall(drawn, measured_[i])) near.push_back(i);
  }
  constexpr double kOneLineM = 0.04;  // beyond the nearest face: panels, doors and their frames
  std::erase_if(near, [&](std::size_t i) {
    const WallFace& face = measured_[i];
    return std::abs(drawn.distance_m(face.at((face.low_m + face.high_m) / 2))) >
           nearest_drawn_m(face) + kOneLineM;
  });
  const auto off = [&](std::size_t i) {
    const WallFace& face = measured_[i];
    return drawn.distance_m(face.at((face.low_m + face.high_m) / 2));
  };
  std::vector<std::size_t> best;
  double most_m = 0.0;
  for (const std::size_t centre : near) {
    std::vector<std::size_t> line;
    double length = 0.0;
    for (const std::size_t i : near) {
      if (std::abs(off(i) - off(centre)) > kOneLineM) continue;
      line.push_back(i);
      length += overlap_m(drawn, measured_[i]);
    }
    if (length > most_m) most_m = length, best = line;
  }
  return best;
}

std::optional<std::size_t> FaceMatching::back_of(const WallFace& front) const {
  for (std::size_t i = 0; i < drawn_.size(); ++i) {
    if (!drawn_[i].curved && is_one_line(front, drawn_[i].face)) return i;
  }
  return std::nullopt;
}

std::optional<double> FaceMatching::measured_off(const WallFace& drawn) const {
  const std::vector<std::size_t> faces = faces_on(drawn);
  if (faces.empty()) return std::nullopt;
  const WallFace& face = measured_[faces.front()];
  return drawn.distance_m(face.at((face.low_m + face.high_m) / 2));
}

double FaceMatching::draw_faces_of_axes(std::vector<DrawnFace>& drawn) const {
  constexpr double kThinM = 0.03;    // no wall is thinner
  constexpr double kMiddle = 0.3;    // of the thickness: half of it is off where a face is drawn
  constexpr std::size_t kLeast = 4;  // walls: one or two may be drawn by chance so
  std::vector<double> thick, half(drawn_.size(), 0.0);
  std::size_t in_middle = 0;
  for (std::size_t i = 0; i < drawn_.size(); ++i) {
    if (drawn_[i].curved) continue;
    const auto off = measured_off(drawn_[i].face);
    const auto back = back_of(drawn_[i].face);
    if (!off || !back) continue;
    const double thickness = *off + measured_off(drawn_[*back].face).value_or(-1e9);
    if (thickness < kThinM) continue;
    thick.push_back(thickness);
    half[i] = thickness / 2;
    in_middle += std::abs(*off - half[i]) < kMiddle * thickness ? 1 : 0;
  }
  if (thick.size() < kLeast || in_middle * 2 < thick.size()) return 0.0;
  const double median_m = median(std::move(thick));
  for (std::size_t i = 0; i < drawn.size(); ++i) {
    if (!drawn[i].curved) drawn[i].face.offset_m += half[i] > 0 ? half[i] : median_m / 2;
  }
  return median_m;
}

}  // namespace marco::plan
