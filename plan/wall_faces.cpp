#include "plan/plan_steps.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "common/median.hpp"

namespace marco::plan {
namespace {

constexpr int kAngles = 180;           // bins of 2 degrees
constexpr double kOffsetM = 0.03;      // bins
constexpr double kBandM = 0.04;        // half-width of what belongs to a face
constexpr double kFacing = 0.9;        // cosine
constexpr double kGapM = 0.35;         // longest stretch of a face without a hit
constexpr double kLeastM = 0.30;       // length of a face
constexpr double kPoseSigmaM = 0.003;  // of the keyframes around a place, together

double angle_of(int bin) { return (bin + 0.5) * 2 * std::numbers::pi / kAngles; }

class FaceSearch {
 public:
  FaceSearch(const std::vector<PlanSurfel>& surfels, bool aligned, std::vector<bool> taken)
      : surfels_(surfels), aligned_(aligned), taken_(std::move(taken)) {
    taken_.resize(surfels.size(), false);
    for (std::size_t i = 0; i < surfels.size(); ++i) {
      if (!taken_[i]) vote(i, 1);
    }
  }

  std::vector<WallFace> run() {
    std::vector<WallFace> faces;
    while (true) {
      const auto peak = std::max_element(votes_.begin(), votes_.end(),
                                         [](auto& a, auto& b) { return a.second < b.second; });
      if (peak == votes_.end() || peak->second < kLeastM / 0.05 * 0.6) return faces;
      WallFace face;
      face.normal = {std::cos(angle_of(peak->first.first)), std::sin(angle_of(peak->first.first))};
      face.offset_m = (peak->first.second + 0.5) * kOffsetM;
      const std::vector<std::size_t> members = grow(face);
      if (face.length_m() < kLeastM || members.size() < 4) {
        votes_.erase(peak);
        continue;
      }
      for (const std::size_t i : members) {
        vote(i, -1);
        taken_[i] = true;
      }
      if (finish(face, members)) faces.push_back(face);
    }
  }

 private:
  void vote(std::size_t i, int weight) {
    const Eigen::Vector2d normal = surfels_[i].normal.normalized();
    const double turn = std::atan2(normal.y(), normal.x()) / (2 * std::numbers::pi);
    const int bin = static_cast<int>(std::floor((turn - std::floor(turn)) * kAngles));
    for (int step = -3; step <= 3; ++step) {
      const int at = (bin + step + kAngles) % kAngles;
      const Eigen::Vector2d way(std::cos(angle_of(at)), std::sin(angle_of(at)));
      const int offset = static_cast<int>(std::floor(way.dot(surfels_[i].mean()) / kOffsetM));
      const auto place = votes_.find({at, offset});
      if (place != votes_.end()) {
        place->second += weight;
      } else if (weight > 0) {
        votes_[{at, offset}] = weight;
      }
    }
  }

  std::vector<std::size_t> on_line(const WallFace& face, double band_m) const {
    std::vector<std::size_t> members;
    for (std::size_t i = 0; i < surfels_.size(); ++i) {
      if (!taken_[i] && std::abs(face.distance_m(surfels_[i].mean())) < band_m &&
          surfels_[i].normal.normalized().dot(face.normal) > kFacing) {
        members.push_back(i);
      }
    }
    std::sort(members.begin(), members.end(), [&](std::size_t a, std::size_t b) {
      return face.along().dot(surfels_[a].mean()) < face.along().dot(surfels_[b].mean());
    });
    return members;
  }

  // The stretch without gaps that has most surfels; later, the one around the middle.
  std::vector<std::size_t> run_of(const WallFace& face, const std::vector<std::size_t>& all) const {
    std::vector<std::size_t> best, now;
    double last = 0;
    for (const std::size_t i : all) {
      const double at = face.along().dot(surfels_[i].mean());
      if (!now.empty() && at - last > kGapM) {
        if (now.size() > best.size()) best = now;
        now.clear();
      }
      now.push_back(i);
      last = at;
    }
    return now.size() > best.size() ? now : best;
  }

  std::vector<std::size_t> grow(WallFace& face) const {
    std::vector<std::size_t> members;
    for (int round = 0; round < 5; ++round) {
      members = run_of(face, on_line(face, round == 0 ? 0.06 : kBandM));
      if (members.size() < 3) return members;
      fit(face, members);
    }
    return members;
  }

  void fit(WallFace& face, const std::vector<std::size_t>& members) const {
    double count = 0;
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();
    for (const std::size_t i : members) {
      // A stretch that the robot stood at for long counts no more than a few passes.
      const double weight = std::min(1.0, 20.0 / surfels_[i].count);
      count += weight * surfels_[i].count;
      sum += weight * surfels_[i].sum;
      squares += weight * surfels_[i].squares;
    }
    const Eigen::Vector2d mean = sum / count;
    const Eigen::Matrix2d spread = squares / count - mean * mean.transpose();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(spread);
    Eigen::Vector2d normal = axes.eigenvectors().col(0);
    if (normal.dot(face.normal) < 0) normal = -normal;
    face.normal = normal;
    face.offset_m = normal.dot(mean);
    const double rms = std::sqrt(std::max(axes.eigenvalues()(0), 1e-8));
    std::vector<int> seen;
    for (const std::size_t i : members) seen.push_back(surfels_[i].keyframes);
    const double independent = std::max(1, median(std::move(seen)));
    face.keyframes = static_cast<int>(independent);
    face.sigma_m = std::sqrt(rms * rms / independent + kPoseSigmaM * kPoseSigmaM);
    face.low_m = face.along().dot(surfels_[members.front()].mean());
    face.high_m = face.along().dot(surfels_[members.back()].mean());
    face.angle_sigma_rad = face.sigma_m * std::sqrt(12.0) / std::max(face.length_m(), 0.1);
  }

  // Its direction where that is a main one, and its ends by points. @returns whether it is a face
  bool finish(WallFace& face, const std::vector<std::size_t>& members) const {
    const Eigen::Vector2d middle = face.at((face.low_m + face.high_m) / 2);
    if (aligned_) {
      const bool level = std::abs(face.normal.y()) > std::abs(face.normal.x());
      Eigen::Vector2d axis = level ? Eigen::Vector2d(0, 1) : Eigen::Vector2d(1, 0);
      if (axis.dot(face.normal) < 0) axis = -axis;
      const double off = std::acos(std::min(1.0, axis.dot(face.normal)));
      if (off < 3 * face.angle_sigma_rad) {
        face.normal = axis;
        face.offset_m = axis.dot(middle);
        face.aligned = true;
      }
    }
    std::vector<double> ends;
    for (const std::size_t i : members) {
      for (const Eigen::Vector2d& point : surfels_[i].points) {
        if (std::abs(face.distance_m(point)) < kBandM) ends.push_back(face.along().dot(point));
      }
    }
    if (ends.size() < 8) return false;
    std::sort(ends.begin(), ends.end());
    // The noise along the beams reaches beyond an end: about half a centimetre's points lie there.
    const double a_centimetre =
        0.01 * static_cast<double>(ends.size()) / (ends.back() - ends.front() + 0.01);
    const std::size_t cut =
        std::min(static_cast<std::size_t>(a_centimetre / 2) + 1, ends.size() / 20);
    face.low_m = ends[cut];
    face.high_m = ends[ends.size() - 1 - cut];
    // Scattered hits are not a face.
    const double covered = 0.05 * static_cast<double>(members.size());
    return face.length_m() >= kLeastM && covered > 0.5 * face.length_m();
  }

  const std::vector<PlanSurfel>& surfels_;
  bool aligned_;
  std::vector<bool> taken_;
  std::map<std::pair<int, int>, int> votes_;
};

}  // namespace

std::vector<WallFace> find_faces(const std::vector<PlanSurfel>& surfels,
                                 bool aligned,
                                 std::vector<bool> taken) {
  return FaceSearch(surfels, aligned, std::move(taken)).run();
}

}  // namespace marco::plan
