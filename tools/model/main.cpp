#include <algorithm>
#include <cstdio>
#include <map>
#include <memory>
#include <ranges>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/process/arguments.hpp"
#include "lcm_tools/process/config.hpp"
#include "lcm_tools/process/exit_code.hpp"
#include "lcm_tools/process/stop_signal.hpp"
#include "tools/map/joined_surface.hpp"
#include "tools/map/picture_order.hpp"
#include "tools/map/results.hpp"
#include "tools/model/cloud_model.hpp"
#include "tools/model/start_poses.hpp"

namespace marco {
namespace {

const std::map<std::string, files::PointFormat> kPointFormats{{"pcd", files::PointFormat::pcd},
                                                              {"ply", files::PointFormat::ply},
                                                              {"xyz", files::PointFormat::xyz},
                                                              {"pts", files::PointFormat::pts},
                                                              {"uos", files::PointFormat::uos}};

struct Arguments {
  std::vector<std::string> inputs;
  std::string out = "out";
  std::string config;
  std::string points;
  files::GlbNumbers glb_numbers = files::GlbNumbers::plain;
};

// Those without a pose that are not found in the others are left out.
std::vector<std::string> place(std::vector<CloudScan>& scans) {
  std::vector<std::string> left_out;
  std::vector<CloudScan> placed;
  const std::vector<std::size_t> lost = find_start_poses(scans);
  for (std::size_t i = 0; i < scans.size(); ++i) {
    if (std::find(lost.begin(), lost.end(), i) == lost.end()) {
      placed.push_back(std::move(scans[i]));
      continue;
    }
    left_out.push_back(scans[i].name());
    std::fprintf(stderr,
                 "%s: left out: it has no pose, and shares too little with the others, or matches "
                 "in several places; write its pose into %s.pose\n",
                 scans[i].path.c_str(), scans[i].path.stem().c_str());
  }
  scans = std::move(placed);
  return left_out;
}

int run(const Arguments& arguments) {
  process::catch_interrupts(arguments.out + " is unchanged");
  const auto options = process::load_options<CloudModelOptions>(arguments.config);
  StageClock clock;
  clock.show_stage("reading");
  std::vector<CloudScan> scans;
  for (const auto& path : list_point_files(arguments.inputs)) {
    scans.push_back(read_cloud_scan(path));
  }
  clock.end_stage("read");
  clock.show_stage("placing the scans");
  const auto results = open_results(arguments.out, arguments.inputs);
  const std::filesystem::path out = results->path();
  const std::vector<std::string> left_out = place(scans);
  clock.end_stage("place");
  clock.show_stage("joining the surface");
  const CloudModel model = make_cloud_model(scans, options);
  require(!model.mesh.triangles.empty(), arguments.inputs.front() + ": no surface in these points");
  clock.end_stage("model");
  clock.show_stage("writing");
  write_joined_surface(out, model.mesh, model.joined, arguments.glb_numbers);
  write_poses(out / "poses.txt", scans);
  if (!arguments.points.empty()) {
    write_all_points(out, kPointFormats.at(arguments.points), arguments.points, scans);
  }
  clock.end_stage("write");
  clock.show_stage("drawing");
  PictureOrder picture{out / "model.png", false, "", {}};
  picture.scene.meshes.push_back({std::make_shared<const TriangleMesh>(model.mesh)});
  draw_elsewhere({picture}, (out / "pictures.part").string());
  clock.end_stage("pictures");
  write_model_report(out / "report.json", model, scans, left_out, clock);
  process::end_if_interrupted();
  results->commit();
  print_model_summary(model, scans, left_out, clock, arguments.out);
  return left_out.empty() ? process::kExitDone : 1;
}

std::optional<int> parse(int argc, char** argv, Arguments& arguments) {
  process::CommandLine app(
      "Builds one surface model from 3D scans of any scanner that stood still.\n"
      "\n"
      "Each SCAN is a file, or a folder of files: PCD, PLY, XYZ, PTS, PTX, or .3d of uos, "
      "optionally with\nintensities or colours. Points are in the scanner's frame, x forward, y "
      "left, z up. The scanner's pose is "
      "the file's own (PCD's\n"
      "VIEWPOINT, PTX), or in NAME.pose next to it: 6 numbers as 3DTK writes them, 7 (x y z "
      "in metres, quaternion x y z w),\n"
      "or the 12 or 16 of a matrix. It may be off by 0.3 m and 3 degrees. Scans without a pose are "
      "registered by what they share with\n"
      "the others: about half of what they see; the scanner must then be upright.\n"
      "\n"
      "Writes model.ply, model.glb, model.obj, model.png, planes.json, poses.txt (where each scan "
      "was taken) and report.json.");
  auto inputs = app.add_option("SCAN", arguments.inputs, "files or folders of 3D scans");
  app.add_option("--out", arguments.out, "folder for the results").shows_default();
  app.add_option("--config", arguments.config, "TOML file; unknown keys are refused")
      .existing_file();
  const auto formats = kPointFormats | std::views::keys;
  app.add_option(
         "--points", arguments.points,
         "also write the points of all scans in one frame, points.FORMAT; of uos a file for "
         "each scan, with its pose: pcd, ply, xyz, pts or uos")
      .one_of({formats.begin(), formats.end()});
  app.add_flag(
      "--compressed-glb", [&] { arguments.glb_numbers = files::GlbNumbers::compressed; },
      "write model.glb as `marco map --compressed-glb` does");
  return process::parse_inputs<CloudModelOptions>(app, inputs, arguments.config, argc, argv);
}

}  // namespace
}  // namespace marco

int main(int argc, char** argv) {
  return marco::process::run_main("marco model", [&] {
    marco::Arguments arguments;
    if (const auto code = marco::parse(argc, argv, arguments)) return *code;
    return marco::run(arguments);
  });
}
