#include "tools/map/map_arguments.hpp"

#include <algorithm>

#include "lcm_tools/process/arguments.hpp"
#include "lcm_tools/process/config.hpp"
#include "live/calibration_file.hpp"
#include "tools/map/map_options.hpp"

namespace marco {
namespace {

// What each makes of the same recordings.
constexpr const char* kCheckHelp =
    R"(Prints the verdict on the map of recordings, and writes nothing: good, doubtful or wrong (exit code 3).
Before it come the reasons, each with its place and, if known, a suggested fix: put that into a file for --edits.
INPUTs are those of ./marco map.)";
constexpr const char* kCalibrateHelp =
    R"(Calibrates the laser's mount (extrinsics), and scales and delays of wheels and gyroscope, from any drive with
turns; also the pan-tilt's lever arms and zero angles, from sweeps at one stop with several pan angles. Writes the map
and calibration.toml, for --calibration. INPUTs are those of ./marco map.)";
constexpr const char* kHelp =
    R"(Builds a map, a trajectory and, from 3D sweeps, a surface model from recordings.

The format of each INPUT is detected from its content:
  a recording of ROS, without ROS: a bag (.bag), an MCAP file, a database (.db3) or folder of rosbag2, each also in zstd.
    Lasers, their mounts (tf), odometry and clocks are detected and reported; put what the recording lacks into
    NAME.marco.toml next to the recording NAME, or into --foreign FILE: table `ros` of config/foreign.toml;
  an LCM log of Marco's channels (LIDAR, ODOMETRY, SENSOR_INFO, ...), as lcm-logger writes it;
  an LCM log of another system: bot_core planar_lidar_t on any channel, mbot's lidar_t, RPLIDAR_LASER, encoders, ...
    (config/foreign.toml lists what each channel means; copy and extend it for your robot: --foreign FILE);
  a CARMEN log (FLASER, ROBOTLASER1); a text log of 'Odometry x y theta' and 'Laser n r1 .. rn' lines;
  3D scans of a tilted laser, as files or in a folder (*_tilt_ranges_mm.csv, uos *.3d with *.pose, scan_polar.csv);
  3D scans of other scanners (PCD, PLY, XYZ, PTS, PTX, uos): these make a model without a map, as ./marco model does.
Several INPUTs are sessions of one map: each is localized in the map of the previous sessions. A session that is not
found there, such as one of another building, gets its own map in OUT/session_N, and the exit code is 1. Consecutive
files of 3D scans are one session, and so are the parts of a split ROS recording (NAME_0.bag, NAME_1.bag, ...).
To map many recordings separately: --many DIR (./marco map --many --help).

To record your own robot: publish bot_core.planar_lidar_t on LIDAR, marco.odometry_t on ODOMETRY and, once a second,
marco.sensor_info_t on SENSOR_INFO with the pose of the laser, and run lcm-logger. Pictures (bot_core.image_t on any
channel, with the camera's pose and focal length in SENSOR_INFO) become the texture of the 3D model.

The last line is the verdict on the map: good, doubtful or wrong (exit code 3). Before it come the reasons, each with its
place, its picture (doctor_1.png ...) and, if known, a suggested fix: put that into a file for --edits.)";

bool was_given(int argc, char** argv, const std::string& flag) {
  return std::find(argv + 1, argv + argc, flag) != argv + argc;
}

const char* help_for(int argc, char** argv) {
  if (was_given(argc, argv, "--check")) return kCheckHelp;
  return was_given(argc, argv, "--calibrate") ? kCalibrateHelp : kHelp;
}

// Help of ./marco check and ./marco calibrate leaves out what has no meaning there.
void hide_what_has_no_meaning(const process::CommandLine& app, int argc, char** argv) {
  const bool check = was_given(argc, argv, "--check");
  if (!check && !was_given(argc, argv, "--calibrate")) return;
  std::vector<std::string> names = {"--check",         "--calibrate",     "--merge",
                                    "--extend",        "--start",         "--localize",
                                    "--sweep-meshes",  "--results-log",   "--hold-out",
                                    "--loop-pictures", "--compressed-glb"};
  if (check) names.emplace_back("--out");
  if (!check) names.insert(names.end(), {"--calibration", "--no-calibration"});
  for (const std::string& name : names) app.option(name).hidden();
}

void add_inputs(process::CommandLine& app, MapArguments& arguments) {
  app.add_option("--out", arguments.out, "folder for the results").shows_default();
  app.add_option("--config", arguments.config, "TOML file; unknown keys are refused")
      .existing_file();
  app.add_option("--foreign", arguments.foreign,
                 "TOML file with the meaning of foreign channels: see config/foreign.toml")
      .existing_file();
  app.add_option("--hold-out", arguments.hold_out_every,
                 "keep every Nth scan out of the map; the report shows how well the map predicts "
                 "it")
      .between(2, 1000000);
  app.add_option("--world", arguments.world,
                 "the world of a simulated recording; map and model are compared with it")
      .existing_file();
  app.add_flag("--lines", arguments.lines,
               "use the line SLAM of thesis A; also writes lines.svg, lines.dxf and lines.json");
}

void add_saved_maps(process::CommandLine& app, MapArguments& arguments) {
  auto extend = app.add_option("--extend", arguments.extend,
                               "a folder that `marco map` wrote: localize in that map and extend "
                               "it");
  auto localize = app.add_option("--localize", arguments.localize,
                                 "a folder that `marco map` or `marco plan --import` wrote: "
                                 "write the trajectory in that map's frame; the map stays "
                                 "unchanged");
  app.add_option("--start", arguments.start,
                 "pose in the map of --localize where the recording begins: x and y in metres, "
                 "heading in degrees; without it the whole map is searched")
      .values(3)
      .needs(localize);
  extend.excludes(localize).excludes("--lines").existing_folder();
  localize.excludes("--lines").excludes("--hold-out").existing_folder();
  app.add_option("--edits", arguments.edits,
                 "fixes for a map, as its verdict suggests them: forbid_loop T1 T2, "
                 "add_loop T1 T2 x y theta, drop_scans T1 T2, distrust_odometry T1 T2")
      .excludes(localize)
      .excludes("--lines")
      .existing_file();
  app.add_flag("--check", arguments.check,
               "print the verdict on the map and write nothing (./marco check)")
      .excludes(extend)
      .excludes(localize);
  app.add_flag("--merge", arguments.merge,
               "INPUTs are folders that `marco map` wrote of one building: merge their maps")
      .excludes(extend)
      .excludes(localize);
}

void add_calibration(process::CommandLine& app, MapArguments& arguments) {
  auto calibration = add_calibration_argument(app, arguments.calibration);
  app.add_flag("--no-calibration", arguments.no_calibration,
               "use odometry and gyroscope as recorded; otherwise, if the drive shows that they "
               "are wrong, the map is made again with corrected values")
      .excludes(calibration);
  app.add_flag(
         "--calibrate", arguments.calibrate,
         "calibrate the laser's mount (extrinsics), and scales and delays of wheels and gyroscope, "
         "from any drive with turns; also the pan-tilt's lever arms and zero angles, from sweeps "
         "at one stop with several pan angles; writes calibration.toml for "
         "--calibration")
      .excludes(calibration);
}

void add_results(process::CommandLine& app, MapArguments& arguments) {
  app.add_flag("--loop-pictures", arguments.loop_pictures,
               "write a picture of each loop closure to loops/: both scans, before and after")
      .excludes("--lines")
      .excludes("--localize");
  app.add_flag("--sweep-meshes", arguments.sweep_meshes,
               "also write model_scenes.ply: a separate mesh for each sweep, overlapping; 20 MB "
               "for each stop");
  app.add_flag("--results-log", arguments.results_log,
               "slam.lcm holds the results alone, without the messages of the inputs: a third of "
               "the size where sweeps were recorded");
  app.add_flag(
      "--compressed-glb", [&] { arguments.glb_numbers = files::GlbNumbers::compressed; },
      "write model.glb and model_textured.glb with EXT_meshopt_compression and "
      "KHR_mesh_quantization: about a fifth of the size, positions to 0.5 mm, for programs that "
      "support these; `marco page` and `marco export` do not");
}

}  // namespace

std::optional<int> parse_map_arguments(int argc, char** argv, MapArguments& arguments) {
  process::CommandLine app(help_for(argc, argv));
  arguments.command_line.assign(argv, argv + argc);
  auto inputs = app.add_option("INPUT", arguments.inputs, "recordings");
  add_inputs(app, arguments);
  add_saved_maps(app, arguments);
  add_calibration(app, arguments);
  add_results(app, arguments);
  hide_what_has_no_meaning(app, argc, argv);
  return process::parse_inputs<MapOptions>(app, inputs, arguments.config, argc, argv);
}

}  // namespace marco
