#include "tools/model/start_poses.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <set>
#include <utility>

#include "mapping3d/surfels.hpp"
#include "slam/matching/correlative_matcher.hpp"

namespace marco {
namespace {

using mapping3d::Surfel;
using mapping3d::SurfelIndex;

constexpr double kPi = std::numbers::pi;
// Scanners of one room, or of two adjacent ones; the search's time grows with the square.
constexpr double kReachM = 12.0;
constexpr int kHeadings = 8;
// Part of a scan's walls on those known from above.
constexpr double kLeastScore = 0.35;
// Part of a scan's surfels on the surfaces known, and by how much the best place must beat others.
constexpr double kLeastShared = 0.4, kLeastGain = 1.15;
// Two candidates this near are one place.
constexpr double kSamePlaceM = 0.5, kSameHeadingRad = deg_to_rad(10.0);
// A surfel lies on a surface: the start poses are right to a cell of the search.
constexpr float kNearM = 0.3F;
constexpr double kOnPlaneM = 0.08, kFacingCosine = 0.85;
constexpr std::size_t kMostAsked = 3000;  // surfels of a scan
constexpr double kUprightCosine = 0.25;   // of a wall's normal with the vertical
constexpr double kLevelCosine = 0.97;     // and of a floor's

// What a scan says against a place: its surfaces where another scanner saw through. In rooms that
// are alike the furniture decides; a wrong place of a furnished room has 0.03 to 0.1.
constexpr double kMostAgainst = 0.03, kContradiction = 5.0;

struct Found {
  Pose3 world_from_scanner;
  double score = 0.0;  ///< part that is shared, less what contradicts
};

// How far a scanner saw at least, by direction.
class SeenThrough {
 public:
  explicit SeenThrough(const mapping3d::ScenePoints& scene)
      : nearest_m_(kRows * kColumns, std::numeric_limits<float>::infinity()) {
    for (std::size_t i = 0; i < scene.points_m.size(); ++i) {
      if (scene.valid[i] == 0) continue;
      float& nearest_m = nearest_m_[cell_of(scene.points_m[i])];
      nearest_m = std::min(nearest_m, scene.points_m[i].norm());
    }
  }
  /// Whether the scanner saw clearly farther than this point of its frame.
  bool beyond(const Eigen::Vector3f& point_m) const {
    const float nearest_m = nearest_m_[cell_of(point_m)];
    return std::isfinite(nearest_m) && point_m.norm() < kPart * nearest_m - kMarginM;
  }

 private:
  static constexpr std::size_t kRows = 90, kColumns = 180;  // of 2 deg
  static constexpr float kPart = 0.95F, kMarginM = 0.15F;

  static std::size_t cell_of(const Eigen::Vector3f& p) {
    const auto part = [](float angle_rad, double from_rad, double width_rad, std::size_t count) {
      const double at = (static_cast<double>(angle_rad) - from_rad) / width_rad;
      return std::min(count - 1, static_cast<std::size_t>(at * static_cast<double>(count)));
    };
    return part(std::atan2(p.z(), p.head<2>().norm()), -0.5 * kPi, kPi, kRows) * kColumns +
           part(std::atan2(p.y(), p.x()), -kPi, 2.0 * kPi, kColumns);
  }

  std::vector<float> nearest_m_;
};

class Placing {
 public:
  explicit Placing(std::vector<CloudScan>& scans) : scans_(scans) {
    for (const CloudScan& scan : scans) {
      surfels_.push_back(mapping3d::find_surfels(scan.grid.scene));
      seen_through_.emplace_back(scan.grid.scene);
    }
    if (std::none_of(scans.begin(), scans.end(), [](const auto& scan) { return scan.has_pose; })) {
      scans.front().has_pose = true;
    }
  }

  std::vector<std::size_t> run() {
    while (place_best()) {
    }
    std::vector<std::size_t> left;
    for (std::size_t i = 0; i < scans_.size(); ++i) {
      if (!scans_[i].has_pose) left.push_back(i);
    }
    return left;
  }

 private:
  // All surfels of placed scans, world frame.
  std::vector<Surfel> known() const {
    std::vector<Surfel> all;
    for (std::size_t i = 0; i < scans_.size(); ++i) {
      if (!scans_[i].has_pose) continue;
      for (Surfel surfel : surfels_[i]) {
        surfel.center_m = scans_[i].world_from_scanner * surfel.center_m;
        surfel.normal = scans_[i].world_from_scanner.linear() * surfel.normal;
        all.push_back(surfel);
      }
    }
    return all;
  }

  bool place_best() {
    if (std::all_of(scans_.begin(), scans_.end(), [](const auto& scan) { return scan.has_pose; })) {
      return false;
    }
    const SurfelIndex world(known());
    const Points2 walls = walls_from_above(world.surfels);
    if (walls.cols() == 0) return false;
    const slam::CorrelativeMatcher matcher;
    const slam::LikelihoodPyramid likelihood(walls, matcher.options());
    std::size_t best = 0;
    std::optional<Found> best_found;
    for (std::size_t i = 0; i < scans_.size(); ++i) {
      if (scans_[i].has_pose) continue;
      const auto found = find(i, world, walls, matcher, likelihood);
      if (!found || (best_found && found->score <= best_found->score)) continue;
      best = i;
      best_found = found;
    }
    if (!best_found) return false;
    scans_[best].world_from_scanner = best_found->world_from_scanner;
    scans_[best].has_pose = true;
    return true;
  }

  std::optional<Found> find(std::size_t scan,
                            const SurfelIndex& world,
                            const Points2& walls,
                            const slam::CorrelativeMatcher& matcher,
                            const slam::LikelihoodPyramid& likelihood) const {
    const std::vector<Surfel>& surfels = surfels_[scan];
    const Points2 own = walls_from_above(surfels);
    if (own.cols() == 0) return std::nullopt;
    const double up_m = floor_m(world.surfels) - floor_m(surfels);
    const Eigen::Vector2d middle_m = walls.rowwise().mean();
    std::vector<Found> candidates;
    for (int heading = 0; heading < kHeadings; ++heading) {
      slam::SearchWindow window;
      window.map_from_robot_centre = {middle_m.x(), middle_m.y(),
                                      normalize_angle(2.0 * kPi * heading / kHeadings)};
      window.half_width_m = kReachM;
      window.half_turn_rad = kPi / kHeadings;
      const slam::CorrelativeMatch match = matcher.search(likelihood, own, window, kLeastScore);
      if (match.score < kLeastScore) continue;
      Pose3 pose = lift(match.map_from_robot);
      pose.translation().z() = up_m;
      const double against = contradicting_part(scan, pose);
      if (against > kMostAgainst) continue;
      candidates.push_back({pose, shared_part(surfels, world, pose) - kContradiction * against});
    }
    return clear_best(std::move(candidates));
  }

  static std::optional<Found> clear_best(std::vector<Found> candidates) {
    const auto best =
        std::max_element(candidates.begin(), candidates.end(),
                         [](const Found& a, const Found& b) { return a.score < b.score; });
    if (best == candidates.end() || best->score < kLeastShared) return std::nullopt;
    const auto rivals = [&](const Found& other) {
      const Pose3 apart =
          best->world_from_scanner.inverse(Eigen::Isometry) * other.world_from_scanner;
      const bool same = apart.translation().norm() < kSamePlaceM &&
                        Eigen::AngleAxisd(apart.linear()).angle() < kSameHeadingRad;
      return !same && other.score * kLeastGain > best->score;
    };
    if (std::any_of(candidates.begin(), candidates.end(), rivals)) return std::nullopt;
    return *best;
  }

  // One point a cell of the search, however high the wall.
  static Points2 walls_from_above(const std::vector<Surfel>& surfels) {
    constexpr double kCellM = 0.05;
    std::set<std::pair<int, int>> cells;
    for (const Surfel& surfel : surfels) {
      if (std::abs(surfel.normal.z()) > kUprightCosine) continue;
      cells.emplace(static_cast<int>(std::floor(surfel.center_m.x() / kCellM)),
                    static_cast<int>(std::floor(surfel.center_m.y() / kCellM)));
    }
    Points2 points(2, static_cast<Eigen::Index>(cells.size()));
    Eigen::Index next = 0;
    for (const auto& [x, y] : cells) {
      points.col(next++) = kCellM * Eigen::Vector2d(x + 0.5, y + 0.5);
    }
    return points;
  }

  // The height of the lowest level surface that is large: a tenth of what is level.
  static double floor_m(const std::vector<Surfel>& surfels) {
    std::vector<double> heights_m;
    for (const Surfel& surfel : surfels) {
      if (surfel.normal.z() > kLevelCosine) heights_m.push_back(surfel.center_m.z());
    }
    return mapping3d::quantile(heights_m, 0.1);
  }

  static double shared_part(const std::vector<Surfel>& surfels,
                            const SurfelIndex& world,
                            const Pose3& world_from_scanner) {
    const std::size_t every = 1 + surfels.size() / kMostAsked;
    std::size_t asked = 0, shared = 0;
    for (std::size_t i = 0; i < surfels.size(); i += every) {
      ++asked;
      const Eigen::Vector3d at_m = world_from_scanner * surfels[i].center_m;
      const auto nearest = world.centers.nearest(at_m.cast<float>(), kNearM);
      if (!nearest) continue;
      const Surfel& partner = world.surfels[*nearest];
      const bool faces =
          partner.normal.dot(world_from_scanner.linear() * surfels[i].normal) > kFacingCosine;
      shared += faces && std::abs(partner.normal.dot(at_m - partner.center_m)) < kOnPlaneM ? 1 : 0;
    }
    return asked == 0 ? 0.0 : static_cast<double>(shared) / static_cast<double>(asked);
  }

  // Surfels of one scan where the other saw through, of both.
  double contradicting_part(std::size_t scan, const Pose3& world_from_scanner) const {
    std::size_t asked = 0, against = 0;
    const auto ask = [&](std::size_t of, std::size_t seer, const Pose3& seer_from_of) {
      const std::size_t every = 1 + surfels_[of].size() / kMostAsked;
      for (std::size_t i = 0; i < surfels_[of].size(); i += every) {
        ++asked;
        const Eigen::Vector3d at_m = seer_from_of * surfels_[of][i].center_m;
        against += seen_through_[seer].beyond(at_m.cast<float>()) ? 1 : 0;
      }
    };
    for (std::size_t other = 0; other < scans_.size(); ++other) {
      if (!scans_[other].has_pose) continue;
      const Pose3 other_from_scan =
          scans_[other].world_from_scanner.inverse(Eigen::Isometry) * world_from_scanner;
      ask(scan, other, other_from_scan);
      ask(other, scan, other_from_scan.inverse(Eigen::Isometry));
    }
    return asked == 0 ? 0.0 : static_cast<double>(against) / static_cast<double>(asked);
  }

  std::vector<CloudScan>& scans_;
  std::vector<std::vector<Surfel>> surfels_;  ///< of each scan, its own frame
  std::vector<SeenThrough> seen_through_;
};

}  // namespace

std::vector<std::size_t> find_start_poses(std::vector<CloudScan>& scans) {
  if (scans.empty()) return {};
  return Placing(scans).run();
}

}  // namespace marco
