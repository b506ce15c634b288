#include "slam/localization/place_finder.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <unordered_set>

#include "common/linear_algebra.hpp"
#include "slam/localization/place_search.hpp"

namespace marco::slam {
namespace {

constexpr double kLeaveOut = 0.30;  // what is worse than the best by so much evidence is forgotten
constexpr int kRefinements = 8;

}  // namespace

PlaceFinder::PlaceFinder(const PlaceMap& map, const PlaceFinderOptions& options)
    : map_(&map), options_(options) {
  validate(options, "place_finder");
}

void PlaceFinder::restart() {
  earlier_.clear();
  leader_.reset();
  leader_times_ = 0;
}

PlaceFinder::SessionPoints PlaceFinder::points_of(const std::vector<Keyframe>& session) const {
  std::size_t first = session.size() - 1;
  const double path_m = session.back().path_m;
  while (first > 0 && path_m - session[first - 1].path_m <= options_.memory_m) --first;
  SessionPoints result;
  std::vector<Eigen::Vector2d> points, sensors;
  std::unordered_set<uint64_t> taken;
  for (std::size_t key = session.size(); key-- > first;) {
    const Keyframe& scan = session[key];
    const Points2 placed = scan.world_from_robot * scan.points_in_robot.points;
    const Eigen::Vector2d sensor = scan.world_from_robot * scan.sensor_in_robot;
    for (Eigen::Index i = 0; i < placed.cols(); ++i) {
      const auto x = static_cast<int32_t>(std::floor(placed(0, i) / options_.thin_m));
      const auto y = static_cast<int32_t>(std::floor(placed(1, i) / options_.thin_m));
      const auto cell =
          static_cast<uint64_t>(static_cast<uint32_t>(x)) << 32U | static_cast<uint32_t>(y);
      if (!taken.insert(cell).second) continue;
      points.emplace_back(placed.col(i));
      sensors.push_back(sensor);
      result.beams.clear_m.push_back(
          clear_length_m(scan.points_in_robot.points.col(i) - scan.sensor_in_robot,
                         scan.points_in_robot.normals.col(i)));
    }
  }
  const auto count = static_cast<Eigen::Index>(points.size());
  Points2& ends = result.beams.ends;
  ends.resize(2, count);
  result.beams.sensors.resize(2, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    ends.col(i) = points[static_cast<std::size_t>(i)];
    result.beams.sensors.col(i) = sensors[static_cast<std::size_t>(i)];
  }
  if (count == 0) return result;
  const Eigen::Vector2d mean = ends.rowwise().mean();
  result.session_from_middle = {mean.x(), mean.y(), 0.0};
  ends.colwise() -= mean;
  result.beams.sensors.colwise() -= mean;
  return result;
}

std::vector<Pose2> PlaceFinder::search(const SessionPoints& points) const {
  const Eigen::Index count = points.beams.ends.cols();
  const Eigen::Index used = std::min<Eigen::Index>(count, options_.search_points);
  Points2 few(2, used);
  for (Eigen::Index i = 0; i < used; ++i) few.col(i) = points.beams.ends.col(i * count / used);
  PlaceSearch search(map_->walls(), map_->blocks(), few,
                     {options_.min_score, options_.keep_within});
  return search.run(static_cast<std::size_t>(options_.max_candidates));
}

Pose2 PlaceFinder::refine(const SessionPoints& points, const Pose2& map_from_middle) const {
  const Eigen::Index count = points.beams.ends.cols();
  const Eigen::Index stride = std::max<Eigen::Index>(1, count / 200);
  Pose2 pose = map_from_middle;
  for (int i = 0; i < kRefinements; ++i) {
    NormalEquations<3> sum;
    sum.information.diagonal().setConstant(1e-3);
    const Eigen::Matrix2d rotation = pose.rotation();
    for (Eigen::Index at = 0; at < count; at += stride) {
      const Eigen::Vector2d turned = rotation * points.beams.ends.col(at);
      const PlaceMap::Likelihood found = map_->likelihood(turned + pose.translation_m());
      const Eigen::Vector2d& slope = found.gradient;
      const Eigen::Vector3d row(slope.x(), slope.y(),
                                slope.y() * turned.x() - slope.x() * turned.y());
      sum.add(row, 1.0 - found.value, 1.0);
    }
    const Eigen::Vector3d step = sum.information.inverse() * sum.gradient;
    constexpr double kMaxStepM = 0.1;  // the likelihood is linear over a cell or two
    const double scale = std::min(1.0, kMaxStepM / std::max(1e-9, step.head<2>().norm()));
    pose.x_m += scale * step.x();
    pose.y_m += scale * step.y();
    pose.theta_rad = normalize_angle(pose.theta_rad + scale * std::clamp(step.z(), -0.05, 0.05));
    if (step.head<2>().norm() < 1e-3 && std::abs(step.z()) < 1e-4) break;
  }
  return pose;
}

PlaceCandidate PlaceFinder::judge(const SessionPoints& points, const Pose2& map_from_middle) const {
  return {map_->agreement(points.beams, map_from_middle),
          map_from_middle * points.session_from_middle.inverse()};
}

bool PlaceFinder::near(const Pose2& a, const Pose2& b) const {
  const Pose2 apart = between(a, b);
  return apart.translation_m().norm() < options_.apart_m &&
         std::abs(apart.theta_rad) < deg_to_rad(options_.apart_deg);
}

void PlaceFinder::keep_apart(std::vector<PlaceCandidate>& candidates,
                             const Pose2& session_from_robot) const {
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const auto& a, const auto& b) { return a.evidence() > b.evidence(); });
  std::vector<PlaceCandidate> kept;
  for (const PlaceCandidate& candidate : candidates) {
    const bool known = std::any_of(kept.begin(), kept.end(), [&](const PlaceCandidate& better) {
      return near(better.map_from_session * session_from_robot,
                  candidate.map_from_session * session_from_robot);
    });
    if (!known) kept.push_back(candidate);
  }
  candidates = std::move(kept);
}

bool PlaceFinder::stands_out(const std::vector<PlaceCandidate>& found) const {
  // As many as were asked for: the right one may be among those cut off.
  if (found.empty() || static_cast<int>(found.size()) >= options_.max_candidates) return false;
  const PlaceCandidate& best = found.front();
  if (best.contradicted() > options_.sure_contradicted) return false;
  const bool fits =
      best.explained >= options_.sure_explained && best.evidence() >= options_.sure_evidence;
  const bool fits_where_known = best.explained >= options_.known_explained &&
                                best.contradicted() <= options_.known_contradicted;
  if (!fits && !fits_where_known) return false;
  const double margin =
      options_.sure_margin + options_.margin_scale_with_unexplained * (1.0 - best.evidence());
  return found.size() == 1 || best.evidence() - found[1].evidence() >= margin;
}

PlaceEstimate PlaceFinder::look(const std::vector<Keyframe>& session) {
  require(!session.empty(), "place_finder: there is no keyframe to search with");
  PlaceEstimate estimate;
  const SessionPoints points = points_of(session);
  if (points.beams.ends.cols() == 0) return estimate;
  const Pose2 session_from_robot = session.back().world_from_robot;
  std::vector<Pose2> places = search(points);
  for (const Pose2& map_from_session : earlier_) {
    places.push_back(map_from_session * points.session_from_middle);
  }
  for (const Pose2& place : places) {
    estimate.candidates.push_back(judge(points, refine(points, place)));
  }
  if (estimate.candidates.empty()) {
    restart();
    return estimate;
  }
  keep_apart(estimate.candidates, session_from_robot);
  auto& found = estimate.candidates;
  const double worth_keeping = found.front().evidence() - kLeaveOut;
  std::erase_if(found, [&](const PlaceCandidate& candidate) {
    return candidate.explained < options_.min_score || candidate.evidence() < worth_keeping;
  });
  if (static_cast<int>(found.size()) > options_.max_candidates) {
    found.resize(static_cast<std::size_t>(options_.max_candidates));
  }
  earlier_.clear();
  for (const PlaceCandidate& candidate : found) earlier_.push_back(candidate.map_from_session);
  if (!stands_out(found)) {
    leader_.reset();
    leader_times_ = 0;
  } else {
    const bool same = leader_ && near(*leader_ * session_from_robot,
                                      found.front().map_from_session * session_from_robot);
    leader_times_ = same ? leader_times_ + 1 : 1;
    leader_ = found.front().map_from_session;
  }
  if (!found.empty()) estimate.status = PlaceEstimate::Status::candidates;
  const double driven_m = session.back().path_m - session.front().path_m;
  if (leader_times_ >= options_.sure_times && driven_m >= options_.sure_path_m) {
    estimate.status = PlaceEstimate::Status::localized;
  }
  return estimate;
}

}  // namespace marco::slam
