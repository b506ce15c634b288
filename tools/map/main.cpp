#include <cstdio>
#include <limits>

#include "common/check.hpp"
#include "common/files/lines_dxf.hpp"
#include "common/files/lines_json.hpp"
#include "common/files/lines_svg.hpp"
#include "common/files/map_yaml.hpp"
#include "common/files/ply.hpp"
#include "common/files/tum.hpp"
#include "common/files/whole_file.hpp"
#include "common/process/arguments.hpp"
#include "common/process/config.hpp"
#include "tools/map/judge.hpp"
#include "tools/map/map_job.hpp"
#include "tools/map/pictures.hpp"
#include "tools/map/report.hpp"

namespace marco {
namespace {

constexpr const char* kHelp = R"(Makes a map, a path and, from 3D sweeps, a model out of recordings.

INPUT is recognised by its content:
  an LCM log of Marco's own channels (LIDAR, ODOMETRY, SENSOR_INFO, ...), as lcm-logger writes it;
  somebody else's LCM log: bot_core planar_lidar_t on any channel, mbot's lidar_t, RPLIDAR_LASER, encoders, ...
    (what a channel means stands in config/foreign.toml; copy and extend it for your robot: --foreign FILE);
  a CARMEN log (FLASER, ROBOTLASER1); a text log of 'Odometry x y theta' and 'Laser n r1 .. rn' lines;
  a folder of 3D scans (*_tilt_ranges_mm.csv, uos *.3d with *.pose, scan_polar.csv).
Several INPUTs are consecutive sessions of one map.

To record your own robot: publish bot_core.planar_lidar_t on LIDAR and marco.odometry_t on ODOMETRY, one
marco.sensor_info_t a second on SENSOR_INFO saying where the laser sits, and run lcm-logger.)";

struct Arguments {
  std::vector<std::string> inputs;
  std::string out = "out";
  std::string config;
  std::string foreign;
  std::string world;
  int hold_out_every = 0;
  bool lines = false;
  bool calibrate = false;
};

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

void write_lines(const std::filesystem::path& out, const Walls& walls, const MapJob& job) {
  files::write_whole_file(out / "lines.svg", files::lines_svg(walls, job.trajectory()));
  files::write_whole_file(out / "lines.dxf", files::lines_dxf(walls));
  files::write_whole_file(out / "lines.json", files::lines_json(walls));
}

int run(const Arguments& arguments) {
  MapOptions options = process::load_options<MapOptions>(arguments.config);
  options.slam.map_period_s = 0.0;  // a batch run sends its maps once, at the end
  options.lines.map_every_s = std::numeric_limits<double>::infinity();
  options.slam.hold_out_every = options.lines.hold_out_every = arguments.hold_out_every;
  const auto foreign = process::load_options<ForeignTable>(arguments.foreign);
  const std::filesystem::path out = arguments.out;
  std::filesystem::create_directories(out);
  MapJob job(options, arguments.lines ? PathMaker::lines : PathMaker::scans, out);
  for (const std::string& input : arguments.inputs) job.read(input, foreign);
  job.finish();
  require(!job.live_trajectory().empty(),
          arguments.inputs.front() + ": holds no laser scan that could be used");
  files::write_tum(out / "trajectory.tum", job.trajectory());
  files::write_tum(out / "trajectory_live.tum", job.live_trajectory());
  if (!job.odometry_trajectory().empty()) {
    files::write_tum(out / "odometry.tum", job.odometry_trajectory());
  }
  if (!job.truth().empty()) files::write_tum(out / "truth.tum", job.truth());
  const GridMap map = job.grid();
  if (map.width_cells > 0) files::write_map(out, map);
  const TriangleMesh model = job.mapping3d().mapper().model();
  if (!model.triangles.empty()) files::write_ply(out / "model.ply", model);
  const Walls walls = job.lines() != nullptr ? job.lines()->mapper().plan() : Walls{};
  if (job.lines() != nullptr) write_lines(out, walls, job);
  const bool calibrated = !arguments.calibrate || write_calibration(out / "calibration.toml", job);
  job.clock().end_stage("write");
  if (map.width_cells > 0) draw_map_picture(out / "map.png", map, job);
  if (!model.triangles.empty()) draw_model_picture(out / "model.png", model, job);
  if (job.lines() != nullptr) draw_line_pictures(out, map, walls, job);
  job.clock().end_stage("pictures");
  ReportExtras extras{judge_path(job)};
  extras.errors.merge(judge_held_out(job, map));
  if (!arguments.world.empty()) {
    extras.errors.merge(judge_against_world(job, map, model, arguments.world));
  }
  job.clock().end_stage("judge");
  write_report(out / "report.json", job, extras);
  print_summary(job, extras, out);
  require(calibrated, "--calibrate: no two sweeps from one stop saw the same walls");
  return 0;
}

}  // namespace
}  // namespace marco

int main(int argc, char** argv) {
  return marco::process::run_main("marco map", [&] {
    CLI::App app(marco::kHelp);
    marco::Arguments arguments;
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
    app.add_flag("--calibrate", arguments.calibrate,
                 "estimate the pan-tilt's lever arms and zero angles from sweeps of one stop at "
                 "several pans; writes calibration.toml for --config");
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
    return marco::run(arguments);
  });
}
