#include "posts/posts_results.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "common/files/metre_svg.hpp"
#include "common/files/tum.hpp"
#include "common/trajectory_fit.hpp"
#include "lcm_tools/files/whole_file.hpp"

namespace marco {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kGapS = 1.5;              // between fixes of one stretch
constexpr std::size_t kShortest = 5;       // fixes of a stretch that counts
constexpr double kFasterThanWheels = 1.5;  // a jump: this much faster than the car ever drove ...
constexpr double kSlackMPerS = 2.0;        // ... and this

double top_speed(const PostsInput& input) {
  double most = 0.0;
  for (const auto& sample : input.drive.wheels) {
    most = std::max(most, std::abs(sample.speed_m_per_s));
  }
  return most;
}

// Stretches of fixes without gaps and jumps; short ones are dropped.
Trajectory steady_fixes(const Trajectory& fixes, double top_m_per_s) {
  Trajectory kept, stretch;
  const auto close = [&] {
    if (stretch.size() >= kShortest) kept.insert(kept.end(), stretch.begin(), stretch.end());
    stretch.clear();
  };
  for (const StampedPose2& fix : fixes) {
    if (!stretch.empty()) {
      const double seconds = (fix.utime - stretch.back().utime).seconds();
      const double way_m =
          (fix.world_from_robot.translation_m() - stretch.back().world_from_robot.translation_m())
              .norm();
      if (seconds > kGapS || way_m > (kFasterThanWheels * top_m_per_s + kSlackMPerS) * seconds) {
        close();
      }
    }
    stretch.push_back(fix);
  }
  close();
  return kept;
}

Json pose_json(const Pose2& pose) {
  return {{"x_m", pose.x_m}, {"y_m", pose.y_m}, {"heading_rad", pose.theta_rad}};
}

std::string landmarks_json(const PostsRun& run) {
  Json root;
  root["unit"] = "m";
  root["frame"] = "the robot's pose at its first sample";
  root["landmarks"] = Json::array();
  for (const slam::MapLandmark& landmark : run.landmarks) {
    Json entry;
    entry["id"] = landmark.id;
    entry["position_m"] = {landmark.in_world_m.x(), landmark.in_world_m.y()};
    const Eigen::Matrix2d& c = landmark.covariance;
    entry["covariance_m2"] = {{c(0, 0), c(0, 1)}, {c(1, 0), c(1, 1)}};
    if (landmark.diameter_m > 0.0) entry["diameter_m"] = landmark.diameter_m;
    entry["existence"] = landmark.existence;
    entry["times_seen"] = landmark.times_seen;
    root["landmarks"].push_back(std::move(entry));
  }
  return root.dump(1) + "\n";
}

std::string report_json(const PostsRun& run, const PostsInput& input) {
  Json root;
  root["landmarks"] = run.landmarks.size();
  root["scans"] = run.scans;
  root["sightings"] = {
      {"all", run.sightings}, {"paired", run.sums.paired}, {"unclear", run.sums.unclear}};
  root["landmarks_over_time"] = {
      {"added", run.sums.added}, {"joined", run.sums.joined}, {"removed", run.sums.removed}};
  root["refused_wheel_samples"] = run.refused_samples;
  root["ms_per_scan"] = run.scans > 0 ? 1e3 * run.seconds / static_cast<double>(run.scans) : 0.0;
  root["bearings"] = {{"zero_rad", run.bearings.zero_rad},
                      {"sense", run.bearings.sign > 0 ? "counter-clockwise" : "clockwise"}};
  root["noise"] = {{"range_sigma_m", run.noise.range_sigma_m},
                   {"bearing_sigma_rad", run.noise.bearing_sigma_rad},
                   {"move_sigma_m", run.noise.move_sigma_m},
                   {"turn_sigma_rad", run.noise.turn_sigma_rad},
                   {"sighting_factor", run.noise_factor}};
  const char* const names[slam::kSetUpSize] = {"speed_scale",         "turn_scale",
                                               "turn_bias_rad_per_s", "sensor_ahead_m",
                                               "sensor_left_m",       "sensor_yaw_rad"};
  for (int i = 0; i < slam::kSetUpSize; ++i) {
    root["set_up"][names[i]] = {{"value", run.set_up[i]}, {"sigma", run.set_up_sigma[i]}};
  }
  const auto errors = path_errors(run.path, input);
  if (!errors) return root.dump(1) + "\n";
  const auto wheels = path_errors(run.dead_reckoning, input);
  root["truth"] = {{"file", input.truth_file},
                   {"positions", errors->known},
                   {"used", errors->used},
                   {"rms_m", errors->rms_m},
                   {"median_m", errors->median_m},
                   {"largest_m", errors->most_m},
                   {"dead_reckoning_rms_m", wheels->rms_m},
                   {"truth_from_world", pose_json(errors->truth_from_world)}};
  return root.dump(1) + "\n";
}

files::MetreSvg::Points points_of(const Trajectory& path, const Pose2& frame_from_path) {
  files::MetreSvg::Points points;
  for (const StampedPose2& pose : path) {
    const Eigen::Vector2d at = frame_from_path * pose.world_from_robot.translation_m();
    if (points.empty() || (points.back() - at).norm() > 0.02) points.push_back(at);
  }
  return points;
}

std::string picture(const PostsRun& run, const PostsInput& input) {
  const auto errors = path_errors(run.path, input);
  const auto driven = points_of(run.path, {});
  auto in_view = driven;
  for (const auto& landmark : run.landmarks) in_view.push_back(landmark.in_world_m);
  files::MetreSvg svg(in_view,
                      ".path{fill:none;stroke:#c0281c;stroke-width:0.03}"
                      ".truth{fill:none;stroke:#2458b0;stroke-width:0.03}"
                      ".landmark{fill:#0a7d24}.sigma{fill:none;stroke:#0a7d24;stroke-width:0.02}");
  if (errors) {
    const Pose2 world_from_truth = errors->truth_from_world.inverse();
    const Trajectory truth =
        input.truth_is_gps ? steady_fixes(input.truth, top_speed(input)) : input.truth;
    files::MetreSvg::Points stretch;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      if (i > 0 && (truth[i].utime - truth[i - 1].utime).seconds() > kGapS) {
        svg.polyline(stretch, "class=\"truth\"");
        stretch.clear();
      }
      stretch.push_back(world_from_truth * truth[i].world_from_robot.translation_m());
    }
    svg.polyline(stretch, "class=\"truth\"");
  }
  svg.polyline(driven, "class=\"path\"");
  for (const auto& landmark : run.landmarks) {
    svg.circle("class=\"landmark\"", landmark.in_world_m,
               std::max(0.5 * landmark.diameter_m, 0.05));
    svg.circle("class=\"sigma\"", landmark.in_world_m,
               3.0 * std::sqrt(0.5 * landmark.covariance.trace()));
  }
  return svg.finish();
}

}  // namespace

std::optional<PathErrors> path_errors(const Trajectory& path, const PostsInput& input) {
  if (input.truth.empty()) return std::nullopt;
  const Trajectory truth =
      input.truth_is_gps ? steady_fixes(input.truth, top_speed(input)) : input.truth;
  // At each true position the path is interpolated; the fit is of the truth to the path.
  const TrajectoryFit fit = fit_to_truth(truth, path, Duration::from_seconds(kGapS));
  if (fit.count < 2) return std::nullopt;
  PathErrors errors;
  errors.known = input.truth.size();
  errors.used = fit.count;
  errors.rms_m = fit.rms_m;
  errors.most_m = fit.max_m;
  errors.truth_from_world = fit.truth_from_estimate.inverse();
  std::vector<double> distances;
  std::size_t after = 0;
  for (const StampedPose2& one : truth) {
    while (after < path.size() && path[after].utime < one.utime) ++after;
    if (after == path.size()) break;
    distances.push_back((fit.truth_from_estimate * one.world_from_robot.translation_m() -
                         path[after].world_from_robot.translation_m())
                            .norm());
  }
  std::sort(distances.begin(), distances.end());
  errors.median_m = distances.empty() ? 0.0 : distances[distances.size() / 2];
  return errors;
}

void write_posts(const std::filesystem::path& folder,
                 const PostsRun& run,
                 const PostsInput& input) {
  files::write_tum(folder / "path.tum", run.path);
  files::write_whole_file(folder / "landmarks.json", landmarks_json(run));
  files::write_whole_file(folder / "landmarks.svg", picture(run, input));
  files::write_whole_file(folder / "report.json", report_json(run, input));
}

}  // namespace marco
