#include "web/snapshot/snapshot.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "common/files/map_yaml.hpp"
#include "common/files/tum.hpp"
#include "common/trajectory_fit.hpp"
#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/inside_folder.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/process/config.hpp"
#include "mapping3d/surface/photograph_list.hpp"
#include "web/tiles.hpp"

namespace marco::web {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

/// The pictures that `folder`/photographs.toml lists and that lie in the folder: [{"file", "x_m",
/// "y_m", "z_m", "theta_rad"}], where each camera stood and looked. An empty list without that
/// file.
/// @throws std::invalid_argument naming the file and what is wrong with it.
json photographs_json(const fs::path& folder) {
  json found = json::array();
  const fs::path list = files::inside_folder(folder, "photographs.toml");
  if (!fs::exists(list)) return found;
  for (const auto& spec : process::load_options<PhotographList>(list.string()).photographs) {
    if (!files::stays_inside(spec.file)) continue;
    if (!fs::exists(files::inside_folder(folder, spec.file))) continue;
    require(spec.position_m.size() == 3 && spec.quaternion_xyzw.size() == 4,
            list.string() + ": expected position_m of 3 and quaternion_xyzw of 4 numbers");
    const auto& q = spec.quaternion_xyzw;
    const Eigen::Vector3d ahead =
        Eigen::Quaterniond(q[3], q[0], q[1], q[2]).normalized() * Eigen::Vector3d::UnitZ();
    found.push_back({{"file", spec.file},
                     {"x_m", spec.position_m[0]},
                     {"y_m", spec.position_m[1]},
                     {"z_m", spec.position_m[2]},
                     {"theta_rad", std::atan2(ahead.y(), ahead.x())}});
  }
  return found;
}

// Poses nearer than this to the previous one look the same on the page.
constexpr double kStepM = 0.03, kStepRad = 0.05;

double rounded(double value) { return std::round(value * 1000.0) / 1000.0; }

Trajectory path_in(const fs::path& folder, const char* name) {
  const fs::path file = files::inside_folder(folder, name);
  return fs::exists(file) ? files::read_tum(file) : Trajectory();
}

json path_json(const Trajectory& path, Utime start) {
  json poses = json::array();
  const Pose2* last = nullptr;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const Pose2& pose = path[i].world_from_robot;
    const bool seen = last == nullptr || i + 1 == path.size() ||
                      std::hypot(pose.x_m - last->x_m, pose.y_m - last->y_m) > kStepM ||
                      std::abs(normalize_angle(pose.theta_rad - last->theta_rad)) > kStepRad;
    if (!seen) continue;
    poses.push_back({rounded((path[i].utime - start).seconds()), rounded(pose.x_m),
                     rounded(pose.y_m), rounded(pose.theta_rad)});
    last = &pose;
  }
  return poses;
}

json loops_json(const json& report, const Trajectory& path) {
  std::map<int64_t, const Pose2*> pose_at;
  for (const StampedPose2& pose : path) pose_at.emplace(pose.utime.us, &pose.world_from_robot);
  json loops = json::array();
  for (const json& loop : report.value("loops", json::array())) {
    const auto from = pose_at.find(loop.value("from_utime", int64_t{0}));
    const auto to = pose_at.find(loop.value("to_utime", int64_t{0}));
    if (from == pose_at.end() || to == pose_at.end()) continue;
    loops.push_back({rounded(from->second->x_m), rounded(from->second->y_m),
                     rounded(to->second->x_m), rounded(to->second->y_m),
                     loop.value("in_force", true) ? "taken" : "refused"});
  }
  return loops;
}

json walls_json(const fs::path& file) {
  json walls = json::array();
  if (!fs::exists(file)) return walls;
  const json content = json::parse(files::read_whole_file(file));
  for (const json& wall : content.at("walls")) {
    const json &start = wall.at("start_m"), &end = wall.at("end_m");
    walls.push_back({start.at(0), start.at(1), end.at(0), end.at(1)});
  }
  return walls;
}

json reason_json(const json& reason) {
  std::string remedy;
  for (const json& edit : reason.value("edits", json::array())) {
    remedy += (remedy.empty() ? "" : "\n") + edit.get<std::string>();
  }
  const bool has_place = reason.contains("picture");
  return {{"text", reason.value("why", "")},
          {"word", reason.value("verdict", "doubtful")},
          {"remedy", remedy},
          {"from_s", reason.value("from_s", 0.0)},
          {"to_s", reason.value("to_s", 0.0)},
          {"x_m", has_place ? reason["x_m"] : json()},
          {"y_m", has_place ? reason["y_m"] : json()}};
}

json verdict_json(const json& report) {
  if (!report.contains("verdict")) return nullptr;
  const json doctor = report.value("doctor", json::object());
  json reasons = json::array();
  for (const json& reason : doctor.value("reasons", json::array())) {
    reasons.push_back(reason_json(reason));
  }
  for (const json& question : doctor.value("open_questions", json::array())) {
    reasons.push_back({{"text", question}, {"word", "doubtful"}, {"remedy", ""}});
  }
  return {{"word", report["verdict"]}, {"reasons", reasons}};
}

json report_json(const json& report) {
  json figures = json::object();
  const json scans = report.value("scans", json::object());
  for (const char* name : {"posed", "matched", "keyframes"}) {
    if (scans.contains(name)) figures[name] = scans[name];
  }
  for (const char* name : {"distance_m", "recorded_s", "errors", "marco"}) {
    if (report.contains(name)) figures[name] = report[name];
  }
  for (const json& input : report.value("inputs", json::array())) {
    for (const json& path : input.value("paths", json::array())) {
      figures["inputs"].push_back(fs::path(path.get<std::string>()).filename().string());
    }
  }
  return figures;
}

json model_json(const fs::path& folder) {
  for (const char* name : {"model_textured.glb", "model.glb"}) {
    if (fs::exists(files::inside_folder(folder, name))) return std::string("files/") + name;
  }
  return nullptr;
}

std::string name_of(const fs::path& folder) {
  const fs::path whole = fs::absolute(folder).lexically_normal();
  return (whole.has_filename() ? whole : whole.parent_path()).filename().string();
}

json read_report(const fs::path& file) {
  return fs::exists(file) ? json::parse(files::read_whole_file(file)) : json::object();
}

// Everything but the tiles.
json drawn_json(const fs::path& folder) {
  const json report = read_report(files::inside_folder(folder, "report.json"));
  const Trajectory path = path_in(folder, "trajectory.tum");
  const Trajectory odometry = odometry_on_estimate(path, path_in(folder, "odometry.tum"));
  RecordedTruth truth;
  truth.poses = path_in(folder, "truth.tum");
  const Utime start = path.empty() ? Utime{} : path.front().utime;
  return {{"name", name_of(folder)},
          {"path", path_json(path, start)},
          {"live_path", path_json(path_in(folder, "trajectory_live.tum"), start)},
          {"odometry", path_json(odometry, start)},
          {"truth", path_json(truth_on_estimate(path, truth), start)},
          {"loops", loops_json(report, path)},
          {"walls", walls_json(files::inside_folder(folder, "lines.json"))},
          {"verdict", verdict_json(report)},
          {"report", report_json(report)},
          {"model", model_json(folder)},
          {"photographs", photographs_json(folder)}};
}

}  // namespace

std::string snapshot_json(const std::filesystem::path& folder) {
  require(!fs::is_regular_file(folder),
          folder.string() + ": a file; give the map folder that contains it");
  require(fs::is_directory(folder), folder.string() + ": no such folder");
  require(fs::exists(folder / "map.yaml"),
          folder.string() +
              ": contains no map.yaml; was it written by `marco map` or `marco slam save`?");
  const GridMap map = files::read_map(files::inside_folder(folder, "map.yaml"));
  json drawn;
  try {
    drawn = drawn_json(folder);
  } catch (const json::exception& fault) {
    throw std::invalid_argument(folder.string() + ": report.json or lines.json: " + fault.what());
  }
  Tiles tiles;
  tiles.set(map);
  // Both are objects: the fields of the tiles' message follow those of the folder.
  std::string text = drawn.dump(-1, ' ', false, json::error_handler_t::replace);
  text.back() = ',';
  return text + tiles.json(tiles.places(), false).substr(1);
}

}  // namespace marco::web
