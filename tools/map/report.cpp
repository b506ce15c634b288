#include "tools/map/report.hpp"

#include <toml++/toml.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <sstream>

#include "common/covariance.hpp"
#include "lcm_tools/base/printable.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/process/version.hpp"
#include "mapping3d/process/mapping3d_adapter.hpp"
#include "slam/line_slam/line_mapper.hpp"
#include "slam/process/mapper2d_adapter.hpp"
#include "slam/session/mapping_session.hpp"
#include "tools/map/calibration.hpp"

namespace marco {
namespace {

using nlohmann::json;

json input_json(const files::InputReport& input) {
  json dropped = json::array();
  for (const auto& [cause, count] : input.dropped) {
    dropped.push_back({{"cause", cause}, {"count", count}, {"first_at", input.places.at(cause)}});
  }
  return {{"format", input.format},
          {"paths", input.paths},
          {"read", input.given},
          {"dropped", dropped},
          {"notes", input.notes}};
}

// @param keys  none where the map is made of lines
json loops_json(const std::vector<slam::Loop>& loops, const std::vector<slam::Keyframe>& keys) {
  json result = json::array();
  for (const slam::Loop& loop : loops) {
    const Eigen::Vector3d variance = covariance_of(loop.information).diagonal();
    json one = {{"from_key", loop.from},
                {"to_key", loop.to},
                {"x_m", loop.from_from_to.x_m},
                {"y_m", loop.from_from_to.y_m},
                {"theta_rad", loop.from_from_to.theta_rad},
                {"score", loop.score},
                {"overlap", loop.overlap},
                {"shift_m", loop.shift_m},
                {"turn_deg", loop.turn_deg},
                {"sigma_x_m", std::sqrt(variance.x())},
                {"sigma_y_m", std::sqrt(variance.y())},
                {"sigma_theta_rad", std::sqrt(variance.z())},
                {"in_force", loop.is_inlier}};
    if (!keys.empty()) {
      const slam::Keyframe& from = keys[static_cast<std::size_t>(loop.from)];
      const slam::Keyframe& to = keys[static_cast<std::size_t>(loop.to)];
      one["from_utime"] = from.utime.us;
      one["to_utime"] = to.utime.us;
      one["path_between_m"] = to.path_m - from.path_m;
    }
    result.push_back(std::move(one));
  }
  return result;
}

json places_json(const slam::MappingSession& session) {
  json found = json::array();
  for (const slam::Finding& finding : session.findings()) {
    const Eigen::Vector3d variance = finding.place.covariance.diagonal();
    found.push_back({{"utime", finding.utime.us},
                     {"driven_until_sure_m", finding.path_m},
                     {"overlap", finding.place.overlap},
                     {"x_m", finding.place.map_from_robot.x_m},
                     {"y_m", finding.place.map_from_robot.y_m},
                     {"theta_rad", finding.place.map_from_robot.theta_rad},
                     {"sigma_x_m", std::sqrt(variance.x())},
                     {"sigma_y_m", std::sqrt(variance.y())},
                     {"sigma_theta_rad", std::sqrt(variance.z())}});
  }
  const slam::PlaceEstimate* last = session.estimate();
  return {{"found", found},
          {"times_lost", session.localizer() != nullptr ? session.localizer()->times_lost() : 0},
          {"candidates_at_the_end", last != nullptr ? last->candidates.size() : 0}};
}

json residuals_json(const mapping3d::PatchResiduals& residuals) {
  return {
      {"patches", residuals.count}, {"median_m", residuals.median_m}, {"p90_m", residuals.p90_m}};
}

json scenes_json(const mapping3d::Mapping3dAdapter& mapping3d) {
  const mapping3d::RegistrationResult& joined = mapping3d.mapper().registration();
  const mapping3d::Straightening& straight = mapping3d.mapper().straightening();
  return {{"count", mapping3d.mapper().scenes().size()},
          {"rows_without_scene", mapping3d.mapper().rows_without_scene()},
          {"dropped", mapping3d.drops().by_cause()},
          {"registration",
           {{"status", to_string(joined.status)},
            {"applied", mapping3d.mapper().refined()},
            {"joined", std::count(joined.joined.begin(), joined.joined.end(), true)},
            {"overlapping_pairs", joined.overlaps},
            {"iterations", joined.iterations},
            {"residual_before", residuals_json(joined.before)},
            {"residual_after", residuals_json(joined.after)}}},
          {"straightening",
           {{"applied", straight.bent},
            {"explained_by_rows", straight.explained},
            {"rows_turned_rms_deg", rad_to_deg(straight.turn_rms_rad)},
            {"range_m", straight.range_m},
            {"median_before_m", straight.before_m},
            {"median_after_m", straight.after_m}}}};
}

json json_of_toml(const std::string& text) {
  std::ostringstream converted;
  converted << toml::json_formatter(toml::parse(text));
  json read = json::parse(converted.str(), nullptr, false);
  return read.is_discarded() ? json(text) : read;  // JSON knows no infinite number
}

int64_t count_scans(const MapJob& job, bool slam::UsedScan::*flag) {
  const auto& scans = job.adapter().scans();
  return std::count_if(scans.begin(), scans.end(),
                       [flag](const slam::UsedScan& scan) { return scan.*flag; });
}

json own_body_json(const MapJob& job) {
  json all = json::array();
  for (const BodyPart& part : job.calibration().body) {
    all.push_back({{"channel", part.channel},
                   {"first_deg", part.first_deg},
                   {"last_deg", part.last_deg},
                   {"within_m", part.within_m}});
  }
  return all;
}

json floor_json(const MapJob& job) {
  json all = json::array();
  for (const FloorLine& floor : job.calibration().floor) {
    all.push_back(
        {{"channel", floor.channel}, {"bearing_deg", floor.bearing_deg}, {"from_m", floor.from_m}});
  }
  return all;
}

// By odometry, or by what the recording says of the laser's place.
bool is_robots_path(const MapJob& job) {
  constexpr double kMovesM = 0.1;
  const SensorInfo* mount = mount_of_laser(job);
  return path_length_m(job.recorded().odometry) > kMovesM ||
         (mount != nullptr && !flatten(mount->parent_from_sensor).vector().isZero(1e-9));
}

json apart_json(const MapJob& job) {
  json all = json::array();
  for (const KeptApart& apart : kept_apart(job)) {
    all.push_back({{"sessions", apart.inputs},
                   {"folder", apart.folder},
                   {"keyframes", apart.map->slam.keyframes.keys.size()}});
  }
  return all;
}

}  // namespace

std::vector<KeptApart> kept_apart(const MapJob& job) {
  std::vector<KeptApart> all;
  if (job.session() == nullptr) return all;
  for (const slam::MappingSession::Apart& apart : job.session()->apart()) {
    KeptApart& one = all.emplace_back();
    one.folder = "session_" + std::to_string(apart.sessions.front());
    one.map = &apart.map;
    for (const int session : apart.sessions) {
      const auto& input = job.recorded().inputs[static_cast<std::size_t>(session) - 1];
      one.inputs += (one.inputs.empty() ? "session " : ", session ") + std::to_string(session) +
                    " (" + input.paths.front() + ")";
    }
  }
  return all;
}

double path_length_m(const Trajectory& trajectory) {
  double length_m = 0.0;
  for (std::size_t i = 1; i < trajectory.size(); ++i) {
    length_m += (trajectory[i].world_from_robot.translation_m() -
                 trajectory[i - 1].world_from_robot.translation_m())
                    .norm();
  }
  return length_m;
}

namespace {

/// Of each rule that took something out, in the order of the rules.
json rules_json(const ScanRules& rules) {
  json removed = json::array();
  for (const auto& [rule, count] : rules.counts()) {
    if (count.scans + count.returns == 0) continue;
    removed.push_back({{"rule", rule}, {"scans", count.scans}, {"returns", count.returns}});
  }
  return removed;
}

}  // namespace

void write_report(const std::filesystem::path& path,
                  const MapJob& job,
                  const ReportExtras& extras) {
  json report;
  report["marco"] = process::version();
  report["command_line"] = extras.command_line;
  report["configuration"] = json_of_toml(extras.configuration);
  for (const files::InputReport& input : job.recorded().inputs)
    report["inputs"].push_back(input_json(input));
  report["scans"] = {{"posed", job.adapter().scans().size()},
                     {"level", count_scans(job, &slam::UsedScan::level)},
                     {"matched", count_scans(job, &slam::UsedScan::matched)},
                     {"held_out", count_scans(job, &slam::UsedScan::held_out)},
                     {"keyframes", job.mapper().keys().size()},
                     {"dropped", job.adapter().drops().by_cause()},
                     {"removed_by", rules_json(job.adapter().input().rules())}};
  if (extras.verdict != nullptr) add_verdict(report, *extras.verdict, job);
  if (extras.correction != nullptr) add_calibration(report, *extras.correction);
  if (!job.calibration().body.empty()) report["own_body"] = own_body_json(job);
  if (!job.calibration().floor.empty()) report["floor"] = floor_json(job);
  report["path_of"] = is_robots_path(job) ? "robot" : "laser";
  report["distance_m"] = path_length_m(job.trajectory());
  report["recorded_s"] = job.recorded_s();
  report["loops"] = loops_json(job.mapper().loops(), job.keyframes());
  if (job.session() != nullptr && job.session()->mode() != slam::MappingSession::Mode::mapping) {
    report["place_in_saved_map"] = places_json(*job.session());
  }
  if (json apart = apart_json(job); !apart.empty()) report["kept_apart"] = std::move(apart);
  if (!job.mapping3d().mapper().scenes().empty()) {
    report["scenes"] = scenes_json(job.mapping3d());
  }
  if (job.lines() != nullptr) {
    report["path_by"] = "lines";
    report["walls"] = job.lines()->filter().num_walls();
    report["filter_restarts"] = job.lines()->replays();
  }
  for (const StageClock::Stage& stage : job.clock().stages()) {
    report["stages"].push_back(
        {{"name", stage.name}, {"wall_s", stage.wall_s}, {"cpu_s", stage.cpu_s}});
  }
  report["wall_s"] = job.clock().total_wall_s();
  report["cpu_s"] = job.clock().total_cpu_s();
  report["real_time_factor"] = job.recorded_s() / std::max(1e-9, job.clock().total_wall_s());
  report["peak_memory_mb"] = StageClock::peak_memory_mb();
  if (!extras.surface.empty()) report["surface"] = extras.surface;
  if (extras.photographs.recorded > 0) {
    report["photographs"] = {{"recorded", extras.photographs.recorded},
                             {"chosen", extras.photographs.chosen},
                             {"dropped", extras.photographs.dropped},
                             {"painted", extras.photographs.painted}};
  }
  if (!extras.errors.empty()) report["errors"] = extras.errors;
  files::write_whole_file(path, report.dump(2, ' ', false, json::error_handler_t::replace) + "\n");
}

namespace {

void print_inputs(const MapJob& job) {
  for (const files::InputReport& input : job.recorded().inputs) {
    print(stdout, "%s: %s\n", input.paths.front().c_str(), input.format.c_str());
    for (const auto& [cause, count] : input.dropped) {
      print(stdout, "  dropped: %s %lld (first at %s)\n", cause.c_str(),
            static_cast<long long>(count), input.places.at(cause).c_str());
    }
    for (const std::string& note : input.notes) print(stdout, "  note: %s\n", note.c_str());
  }
}

void print_counts(const char* what, const std::map<std::string, int64_t>& counts) {
  for (const auto& [name, count] : counts) {
    print(stdout, "  %s: %s %lld\n", what, name.c_str(), static_cast<long long>(count));
  }
}

void print_scenes(const mapping3d::Mapper3d& mapper) {
  if (mapper.scenes().empty()) return;
  const mapping3d::RegistrationResult& joined = mapper.registration();
  print(
      stdout,
      "%zu scenes, registered in 3D: %s, %zu overlapping pairs, patches %.1f -> %.1f mm apart%s\n",
      mapper.scenes().size(), to_string(joined.status).c_str(), joined.overlaps,
      1e3 * joined.before.median_m, 1e3 * joined.after.median_m,
      mapper.refined() ? "" : "; the path is unchanged");
  const mapping3d::Straightening& straight = mapper.straightening();
  if (!straight.bent) return;
  print(stdout,
        "sweeps straightened: rows turned by %.2f deg rms, ranges longer by %.1f mm, patches %.1f "
        "-> %.1f mm apart\n",
        rad_to_deg(straight.turn_rms_rad), 1e3 * straight.range_m, 1e3 * straight.before_m,
        1e3 * straight.after_m);
}

}  // namespace

void print_summary(const MapJob& job,
                   const ReportExtras& extras,
                   const std::filesystem::path& folder) {
  print_inputs(job);
  print_counts("dropped", job.adapter().drops().by_cause());
  for (const auto& [rule, count] : job.adapter().input().rules().counts()) {
    if (count.returns == 0) continue;
    print(stdout, "  %s: %lld returns left out\n", rule.c_str(),
          static_cast<long long>(count.returns));
  }
  const auto loops = std::count_if(job.mapper().loops().begin(), job.mapper().loops().end(),
                                   [](const slam::Loop& loop) { return loop.is_inlier; });
  print(stdout,
        "%zu scans with a pose, %lld of %lld level ones matched, %zu keyframes; %.1f m driven in "
        "%.0f s; %zu loops closed\n",
        job.adapter().scans().size(),
        static_cast<long long>(count_scans(job, &slam::UsedScan::matched)),
        static_cast<long long>(count_scans(job, &slam::UsedScan::level)),
        job.mapper().keys().size(), path_length_m(job.trajectory()), job.recorded_s(),
        static_cast<std::size_t>(loops));
  for (const auto& [name, value] : extras.surface) {
    print(stdout, value == std::floor(value) ? "%s: %.0f\n" : "%s: %.6g\n", name.c_str(), value);
  }
  print_scenes(job.mapping3d().mapper());
  if (extras.photographs.recorded > 0) {
    print(stdout, "%lld pictures recorded, %lld chosen\n",
          static_cast<long long>(extras.photographs.recorded),
          static_cast<long long>(extras.photographs.chosen));
  }
  print_counts("pictures dropped", extras.photographs.dropped);
  for (const auto& [name, value] : extras.errors) print(stdout, "%s: %.4f\n", name.c_str(), value);
  print(stdout,
        "%.2f s (%.0f times real time), peak memory %.0f MB; the results are in %s; view them with "
        "`marco page %s`\n",
        job.clock().total_wall_s(), job.recorded_s() / std::max(1e-9, job.clock().total_wall_s()),
        StageClock::peak_memory_mb(), folder.c_str(), folder.c_str());
}

}  // namespace marco
