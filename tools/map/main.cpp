#include <algorithm>
#include <cstdio>
#include <limits>

#include "common/files/map_yaml.hpp"
#include "common/files/ply.hpp"
#include "common/files/tum.hpp"
#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/process/arguments.hpp"
#include "lcm_tools/process/config.hpp"
#include "lcm_tools/process/stop_signal.hpp"
#include "recordings/tilted_scans.hpp"
#include "slam/process/map_folder.hpp"
#include "tools/map/judge.hpp"
#include "tools/map/map_job.hpp"
#include "tools/map/pictures.hpp"
#include "tools/map/report.hpp"
#include "tools/map/results.hpp"

namespace marco {
namespace {

constexpr const char* kHelp = R"(Makes a map, a path and, from 3D sweeps, a model out of recordings.

INPUT is recognised by its content:
  an LCM log of Marco's own channels (LIDAR, ODOMETRY, SENSOR_INFO, ...), as lcm-logger writes it;
  somebody else's LCM log: bot_core planar_lidar_t on any channel, mbot's lidar_t, RPLIDAR_LASER, encoders, ...
    (what a channel means stands in config/foreign.toml; copy and extend it for your robot: --foreign FILE);
  a CARMEN log (FLASER, ROBOTLASER1); a text log of 'Odometry x y theta' and 'Laser n r1 .. rn' lines;
  3D scans, a folder of them or their files (*_tilt_ranges_mm.csv, uos *.3d with *.pose, scan_polar.csv).
Several INPUTs are sessions of one map: each is looked for in the map of those before it. One that is found nowhere,
as in another building, gets a map of its own in OUT/session_N, and the exit code is 1. Neighbouring files of 3D scans
are one session.

To record your own robot: publish bot_core.planar_lidar_t on LIDAR and marco.odometry_t on ODOMETRY, one
marco.sensor_info_t a second on SENSOR_INFO saying where the laser sits, and run lcm-logger. Pictures (bot_core.image_t
on any channel, its camera's place and focal length in SENSOR_INFO) are laid on the 3D model.)";

struct Arguments {
  std::vector<std::string> command_line;
  std::vector<std::string> inputs;
  std::string out = "out";
  std::string config;
  std::string foreign;
  std::string world;
  int hold_out_every = 0;
  bool lines = false;
  std::string extend;
  std::string localize;
  bool merge = false;
  bool calibrate = false;
  bool loop_pictures = false;
};

// One trajectory a session, those of the saved map first.
void write_sessions(const std::filesystem::path& out, const slam::SavedMap& map) {
  slam::Slam slam;
  slam.restore(map.slam);
  const Trajectory all = slam.trajectory();
  for (std::size_t session = 0; session < map.session_starts.size(); ++session) {
    const auto first = all.begin() + map.session_starts[session];
    const auto last = session + 1 < map.session_starts.size()
                          ? all.begin() + map.session_starts[session + 1]
                          : all.end();
    files::write_tum(out / ("trajectory_session_" + std::to_string(session + 1) + ".tum"),
                     Trajectory(first, last));
  }
}

void save(const std::filesystem::path& out, const slam::SavedMap& map) {
  slam::save_map_file(out, map);
  if (map.session_starts.size() > 1) write_sessions(out, map);
}

int merge(const Arguments& arguments, MapOptions options) {
  std::vector<slam::SavedMap> maps;
  for (const std::string& folder : arguments.inputs) maps.push_back(slam::load_map_folder(folder));
  std::vector<std::size_t> not_found;
  const slam::SavedMap merged =
      slam::merge_maps(std::move(maps), options.slam.slam, options.slam.localizer, not_found);
  const auto results = open_results(arguments.out, arguments.inputs);
  slam::write_map_files(results->path(), merged, options.slam.slam.grid);
  write_sessions(results->path(), merged);
  for (const std::size_t index : not_found) {
    std::fprintf(stderr, "%s: was found nowhere in the maps before it, and is left out\n",
                 arguments.inputs[index].c_str());
    require(!same_folder(arguments.inputs[index], arguments.out),
            arguments.out + ": is as it was, for its map would be lost; give another --out");
  }
  results->commit();
  std::printf("%zu maps, %zu keyframes, %zu loops; everything is in %s\n",
              arguments.inputs.size() - not_found.size(), merged.slam.keys.size(),
              merged.slam.loops.size(), arguments.out.c_str());
  return not_found.empty() ? 0 : 1;
}

// Another building's recording extends no map: nothing is written.
void require_extended(const Arguments& arguments, const MapJob& job) {
  if (arguments.extend.empty()) return;
  require(!job.session()->findings().empty(),
          arguments.extend + ": the recording was found nowhere in this map, which stays as it is");
}

// What was to be found in a map, and was not. @returns the exit code
int judge_finding(const Arguments& arguments, const MapJob& job) {
  if (job.session() == nullptr) return 0;
  if (!arguments.localize.empty() && job.session()->findings().empty()) {
    const std::string fault = arguments.localize + ": the recording was found nowhere in this map";
    require(!same_folder(arguments.localize, arguments.out),
            fault + "; " + arguments.out + " is as it was");
    std::fprintf(stderr, "%s\n", fault.c_str());
    return 1;
  }
  for (const KeptApart& apart : kept_apart(job)) {
    std::fprintf(stderr, "%s: found nowhere in the map of the others, and kept apart, in %s\n",
                 apart.inputs.c_str(),
                 (std::filesystem::path(arguments.out) / apart.folder).c_str());
  }
  return job.session()->apart().empty() ? 0 : 1;
}

// Whatever the command line names, for a result of before may be among it.
std::vector<std::string> named_inputs(const Arguments& arguments) {
  std::vector<std::string> named = arguments.inputs;
  named.insert(named.end(), {arguments.config, arguments.foreign, arguments.world, arguments.extend,
                             arguments.localize});
  std::erase(named, "");
  return named;
}

/// @returns whether there was something to calibrate by.
bool write_calibration(const std::filesystem::path& path, const MapJob& job) {
  const auto found = job.mapping3d().calibrate();
  if (!found) return false;
  using Status = mapping3d::CalibrationResult::Status;
  std::printf("calibration: %s, %zu patches seen twice, %.1f -> %.1f mm apart; +- one sigma:\n",
              to_string(found->status).c_str(), found->pairs, 1e3 * found->before_m,
              1e3 * found->after_m);
  std::fputs(process::print_options(found->sigma).c_str(), stdout);
  if (found->status == Status::nothing_seen_twice) return false;
  files::write_whole_file(path,
                          "# Read by ./marco map --config, added to what SENSOR_INFO says.\n"
                          "[mapping3d_process.correction]\n" +
                              process::print_options(found->correction));
  return true;
}

// Neighbouring files of 3D scans are parts of one recording, as in a folder.
void read_all(MapJob& job, const std::vector<std::string>& inputs, const ForeignTable& foreign) {
  for (auto input = inputs.begin(); input != inputs.end();) {
    const auto other = std::find_if_not(input, inputs.end(), [](const std::string& path) {
      return std::filesystem::is_regular_file(path) && files::is_tilted_scan(path);
    });
    if (other - input > 1) {
      job.read_scans({input, other});
      input = other;
    } else {
      job.read(*input++, foreign);
    }
  }
}

// A model without triangles, or a recording without pictures, stays as it is.
PhotographCounts paint(const std::filesystem::path& out,
                       const TriangleMesh& mesh,
                       MapJob& job,
                       const PhotographOptions& options) {
  if (mesh.triangles.empty()) return {};
  std::vector<std::string> logs;
  for (const files::InputReport& input : job.inputs()) {
    if (input.format == "LCM log") logs.insert(logs.end(), input.paths.begin(), input.paths.end());
  }
  PhotographCounts counts = write_photographs(out, logs, job.trajectory(), job.sensors(), options);
  if (counts.chosen > 0) counts.painted = paint_elsewhere(out, mesh);
  if (counts.recorded > 0) job.clock().end_stage("photographs");
  return counts;
}

void order_loop_pictures(std::vector<PictureOrder>& pictures,
                         const std::filesystem::path& folder,
                         const MapJob& job) {
  std::filesystem::create_directories(folder);
  for (PictureOrder& order : loop_pictures(folder, job)) pictures.push_back(std::move(order));
}

int run(const Arguments& arguments) {
  process::catch_interrupts(arguments.out + " is as it was");
  MapOptions options = process::load_options<MapOptions>(arguments.config);
  const std::string configuration = process::print_changed_options(options);
  options.slam.map_period_s = 0.0;  // a batch run sends its maps once, at the end
  options.lines.map_every_s = std::numeric_limits<double>::infinity();
  options.slam.hold_out_every = options.lines.hold_out_every = arguments.hold_out_every;
  const auto foreign = process::load_options<ForeignTable>(arguments.foreign);
  const auto results = open_results(arguments.out, named_inputs(arguments));
  const std::filesystem::path out = results->path();
  MapJob job(options, arguments.lines ? PathMaker::lines : PathMaker::scans, out);
  if (!arguments.extend.empty()) job.extend(arguments.extend);
  if (!arguments.localize.empty()) job.localize(arguments.localize);
  read_all(job, arguments.inputs, foreign);
  require_extended(arguments, job);
  job.finish();
  require(!job.live_trajectory().empty(),
          arguments.inputs.front() + ": holds no laser scan that could be used");
  write_paths(out, job);
  if (job.session() != nullptr && job.session()->localizer() == nullptr) {
    save(out, job.session()->saved(process::print_options(options.slam.slam)));
    for (const KeptApart& apart : kept_apart(job)) {
      std::filesystem::create_directories(out / apart.folder);
      slam::write_map_files(out / apart.folder, *apart.map, options.slam.slam.grid);
    }
  }
  const GridMap map = job.grid();
  if (map.width_cells > 0) files::write_map(out, map);
  const TriangleMesh scenes = job.mapping3d().mapper().scene_meshes();
  if (!scenes.triangles.empty()) files::write_ply(out / "model_scenes.ply", scenes);
  const Walls walls = job.lines() != nullptr ? job.lines()->mapper().plan() : Walls{};
  if (job.lines() != nullptr) write_lines(out, walls, job);
  const bool calibrated = !arguments.calibrate || write_calibration(out / "calibration.toml", job);
  job.clock().end_stage("write");
  const mapping3d::Mapper3d& mapper = job.mapping3d().mapper();
  const TriangleMesh& model = mapper.model();
  const mapping3d::JoinedSurface joined = mapping3d::join_surface(model, options.joined_surface);
  write_joined_surface(out, model, joined);
  job.clock().end_stage("surface");
  std::vector<PictureOrder> pictures;
  if (map.width_cells > 0) pictures.push_back(map_picture(out / "map.png", map, job));
  if (!model.triangles.empty()) pictures.push_back(model_picture(out / "model.png", model, job));
  if (job.lines() != nullptr) {
    for (PictureOrder& order : line_pictures(out, map, walls, job)) {
      pictures.push_back(std::move(order));
    }
  }
  if (arguments.loop_pictures) order_loop_pictures(pictures, out / "loops", job);
  draw_elsewhere(std::move(pictures), (out / "pictures.part").string());
  job.clock().end_stage("pictures");
  ReportExtras extras{judge_path(job), figures_of(model, joined, mapper.scenes().size()),
                      paint(out, joined.simplified.mesh, job, options.photographs),
                      arguments.command_line, configuration};
  extras.errors.merge(judge_held_out(job, map));
  if (!arguments.world.empty()) {
    extras.errors.merge(judge_against_world(job, map, model, arguments.world));
  }
  job.clock().end_stage("judge");
  write_report(out / "report.json", job, extras);
  const int code = judge_finding(arguments, job);
  process::end_if_interrupted();
  results->commit();
  print_summary(job, extras, arguments.out);
  require(calibrated, "--calibrate: no two sweeps from one stop saw the same walls");
  return code;
}

}  // namespace
}  // namespace marco

int main(int argc, char** argv) {
  return marco::process::run_main("marco map", [&] {
    CLI::App app(marco::kHelp);
    marco::Arguments arguments;
    arguments.command_line.assign(argv, argv + argc);
    app.add_option("INPUT", arguments.inputs, "recordings")->required();
    app.add_option("--out", arguments.out, "folder for the results")->capture_default_str();
    app.add_option("--config", arguments.config, "TOML; unknown keys are refused")
        ->check(CLI::ExistingFile);
    app.add_option("--foreign", arguments.foreign,
                   "what foreign channels mean: see config/foreign.toml")
        ->check(CLI::ExistingFile);
    app.add_option("--hold-out", arguments.hold_out_every,
                   "every Nth scan gets a pose but is not drawn; the report says how well the map "
                   "predicts it")
        ->check(CLI::Range(2, 1000000));
    app.add_option("--world", arguments.world,
                   "a simulated recording's world: map and model are compared with it")
        ->check(CLI::ExistingFile);
    app.add_flag("--lines", arguments.lines,
                 "walls make the path: the line SLAM of thesis A, with lines.svg, lines.dxf and "
                 "lines.json");
    auto* extend = app.add_option("--extend", arguments.extend,
                                  "a folder that `marco map` wrote: finds itself in that map and "
                                  "goes on with it");
    auto* localize = app.add_option("--localize", arguments.localize,
                                    "a folder that `marco map` wrote: the path in that map's "
                                    "frame; the map stays as it is");
    extend->excludes(localize)->excludes("--lines")->check(CLI::ExistingDirectory);
    localize->excludes("--lines")->excludes("--hold-out")->check(CLI::ExistingDirectory);
    app.add_flag("--merge", arguments.merge,
                 "INPUTs are folders that `marco map` wrote, of one building: makes them one map")
        ->excludes(extend)
        ->excludes(localize);
    app.add_flag("--calibrate", arguments.calibrate,
                 "estimate the pan-tilt's lever arms and zero angles from sweeps of one stop at "
                 "several pans; writes calibration.toml for --config");
    app.add_flag("--loop-pictures", arguments.loop_pictures,
                 "a picture of each loop in loops/: the two scans, before and after")
        ->excludes("--lines")
        ->excludes(localize);
    bool print_config = false;
    app.add_flag("--print-config", print_config, "print the config in force and exit");
    // --print-config needs no INPUT.
    for (int i = 1; i < argc; ++i) {
      if (std::string(argv[i]) == "--print-config") app.get_option("INPUT")->required(false);
    }
    if (const auto code = marco::process::parse_arguments(app, argc, argv)) return *code;
    if (print_config) {
      std::fputs(marco::process::print_options(
                     marco::process::load_options<marco::MapOptions>(arguments.config))
                     .c_str(),
                 stdout);
      return 0;
    }
    if (arguments.merge) {
      return marco::merge(arguments,
                          marco::process::load_options<marco::MapOptions>(arguments.config));
    }
    return marco::run(arguments);
  });
}
