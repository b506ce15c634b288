// How many revisits become loops, and whether the loops are true: loops LOG... (recordings with
// TRUE_POSE, as marco-simulate writes them).
//
// A keyframe is a revisit when an older one, more than 20 m of path back, lies within 3 m and
// 60 deg by the truth and sees at least 40 % of its points. It is recalled when a loop in force
// ends within half a metre of path from it (loops are searched so often). A loop is true when its
// measured pose is within 20 cm and 3 deg of the truth. Untrue ones that are off by no more than 3
// sigma of their own covariance, as along a bare hall where nothing can be measured, are counted as
// admitted. Exit code 1 when less than 95 % are
// recalled or a loop in force is not true.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>

#include "recordings/foreign.hpp"
#include "slam/matching/point_index.hpp"
#include "slam/process/mapper2d_adapter.hpp"
#include "slam/session/mapping_session.hpp"
#include "tools/map/judge.hpp"
#include "tools/map/map_job.hpp"

namespace marco {
namespace {

constexpr double kMinPathM = 20.0, kNearM = 3.0, kNearDeg = 60.0, kCommon = 0.40;
constexpr double kSearchEveryM = 0.5;
constexpr double kTrueM = 0.20, kTrueDeg = 3.0, kAdmittedSigmas = 3.0;

struct Key {
  Pose2 truth;
  double path_m = 0.0;
  const slam::OrientedPoints* points = nullptr;
};

// Both in the frame of `older`; a wall's two faces are not one surface.
double common_part(const Key& older, const slam::PointIndex& older_index, const Key& newer) {
  constexpr double kReachM = 0.10;
  constexpr double kSameWay = 0.7;
  const Pose2 older_from_newer = between(older.truth, newer.truth);
  const Points2 points = older_from_newer * newer.points->points;
  const Points2 normals = older_from_newer.rotation() * newer.points->normals;
  int common = 0;
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const auto near = older_index.nearest(points.col(i), kReachM);
    if (!near) continue;
    const bool oriented = newer.points->has_normal(i) && older.points->has_normal(near.index);
    if (!oriented || normals.col(i).dot(older.points->normals.col(near.index)) > kSameWay) ++common;
  }
  return points.cols() == 0 ? 0.0
                            : static_cast<double>(common) / static_cast<double>(points.cols());
}

bool lies_near(const Key& a, const Key& b) {
  const Pose2 apart = between(a.truth, b.truth);
  return apart.translation_m().norm() < kNearM && std::abs(apart.theta_rad) < deg_to_rad(kNearDeg);
}

std::vector<Key> keys_of(const MapJob& job) {
  std::map<int64_t, Pose2> truth;
  for (const StampedPose2& pose : job.recorded().truth.poses)
    truth[pose.utime.us] = pose.world_from_robot;
  std::vector<Key> keys;
  for (const slam::Keyframe& key : job.keyframes()) {
    keys.push_back({truth.at(key.utime.us), key.path_m, &key.points_in_robot});
  }
  return keys;
}

std::vector<int> revisits(const std::vector<Key>& keys) {
  std::vector<slam::PointIndex> indices;
  indices.reserve(keys.size());
  for (const Key& key : keys) indices.emplace_back(key.points->points, 0.1);
  std::vector<int> result;
  for (std::size_t newer = 0; newer < keys.size(); ++newer) {
    for (std::size_t older = 0; older < newer; ++older) {
      if (keys[newer].path_m - keys[older].path_m <= kMinPathM) break;
      if (!lies_near(keys[older], keys[newer]) ||
          common_part(keys[older], indices[older], keys[newer]) < kCommon) {
        continue;
      }
      result.push_back(static_cast<int>(newer));
      break;
    }
  }
  return result;
}

struct LoopErrors {
  int in_force = 0, left_out = 0, untrue = 0, untrue_left_out = 0, admitted = 0;
  double worst_m = 0.0, worst_deg = 0.0;
};

LoopErrors judge_loops(const MapJob& job, const std::vector<Key>& keys) {
  LoopErrors errors;
  for (const slam::Loop& loop : job.mapper().loops()) {
    const Pose2 truth = between(keys[static_cast<std::size_t>(loop.from)].truth,
                                keys[static_cast<std::size_t>(loop.to)].truth);
    const Pose2 off = between(truth, loop.from_from_to);
    const double off_m = off.translation_m().norm();
    const double off_deg = std::abs(rad_to_deg(off.theta_rad));
    // In sigmas of its own covariance, 3 degrees of freedom.
    const Eigen::Vector3d error(off.x_m, off.y_m, off.theta_rad);
    const double sigmas = std::sqrt(error.dot(loop.information * error));
    const bool untrue = off_m > kTrueM || off_deg > kTrueDeg;
    if (untrue && loop.is_inlier && sigmas <= kAdmittedSigmas) ++errors.admitted;
    (loop.is_inlier ? errors.in_force : errors.left_out) += 1;
    if (untrue) {
      (loop.is_inlier ? errors.untrue : errors.untrue_left_out) += 1;
      std::printf(
          "  untrue%s: key %d to %d, off by %.2f m %.1f deg (%.1f of its own sigmas), score %.2f, "
          "overlap %.2f\n",
          loop.is_inlier ? "" : " (left out)", loop.from, loop.to, off_m, off_deg, sigmas,
          loop.score, loop.overlap);
    }
    if (!loop.is_inlier) continue;
    errors.worst_m = std::max(errors.worst_m, off_m);
    errors.worst_deg = std::max(errors.worst_deg, off_deg);
  }
  return errors;
}

bool run(const std::filesystem::path& log) {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "marco_loops";
  std::filesystem::create_directories(folder);
  MapJob job(folder);
  job.read({log}, ForeignTable{});
  job.finish();
  const std::vector<Key> keys = keys_of(job);
  const std::vector<int> again = revisits(keys);
  int recalled = 0;
  for (const int key : again) {
    const double path_m = keys[static_cast<std::size_t>(key)].path_m;
    const bool found = std::any_of(
        job.mapper().loops().begin(), job.mapper().loops().end(), [&](const slam::Loop& loop) {
          const double to_path_m = keys[static_cast<std::size_t>(loop.to)].path_m;
          return loop.is_inlier && std::abs(to_path_m - path_m) <= kSearchEveryM;
        });
    recalled += found ? 1 : 0;
    if (!found) std::printf("  missed: key %d at %.1f m\n", key, path_m);
  }
  const LoopErrors loops = judge_loops(job, keys);
  const Errors errors = judge_path(job);
  const double recall =
      again.empty() ? 1.0 : static_cast<double>(recalled) / static_cast<double>(again.size());
  std::printf(
      "%s: %zu keyframes, %.0f m; %zu revisits, %.1f %% recalled; %d loops, %d untrue (%d "
      "of them admitted), at most %.3f m %.2f deg off; left out %d, of them untrue %d; path rms "
      "%.4f m, max "
      "%.3f m; CPU %.1f s\n",
      log.filename().c_str(), keys.size(), keys.back().path_m, again.size(), 100.0 * recall,
      loops.in_force, loops.untrue, loops.admitted, loops.worst_m, loops.worst_deg, loops.left_out,
      loops.untrue_left_out, errors.at("path error rms_m"), errors.at("path error max_m"),
      job.clock().total_cpu_s());
  std::fflush(stdout);
  return recall >= 0.95 && loops.untrue == 0;
}

}  // namespace
}  // namespace marco

int main(int argc, char** argv) {
  bool good = argc > 1;
  for (int i = 1; i < argc; ++i) good = marco::run(argv[i]) && good;
  return good ? 0 : 1;
}
