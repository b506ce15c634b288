#include <algorithm>
#include <cstdio>
#include <limits>

#include "common/files/map_yaml.hpp"
#include "common/files/ply.hpp"
#include "common/files/tum.hpp"
#include "lcm_tools/base/check.hpp"
#include "lcm_tools/base/printable.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/process/arguments.hpp"
#include "lcm_tools/process/config.hpp"
#include "lcm_tools/process/exit_code.hpp"
#include "lcm_tools/process/stop_signal.hpp"
#include "slam/process/map_folder.hpp"
#include "slam/session/merge_maps.hpp"
#include "tools/map/calibration.hpp"
#include "tools/map/judge.hpp"
#include "tools/map/judged_map.hpp"
#include "tools/map/map_arguments.hpp"
#include "tools/map/map_job.hpp"
#include "tools/map/pictures.hpp"
#include "tools/map/point_scans.hpp"
#include "tools/map/report.hpp"
#include "tools/map/results.hpp"
#include "tools/map/scratch_folder.hpp"
#include "tools/map/self_correction.hpp"
#include "tools/map/verdict.hpp"

namespace marco {
namespace {

void save(const std::filesystem::path& out, const slam::SavedMap& map) {
  slam::save_map_file(out, map);
  if (map.session_starts.size() > 1) write_sessions(out, map);
}

int merge(const MapArguments& arguments) {
  const auto options = process::load_options<MapOptions>(arguments.config);
  std::vector<slam::SavedMap> maps;
  for (const std::string& folder : arguments.inputs) maps.push_back(slam::load_map_folder(folder));
  std::vector<std::size_t> not_found;
  const slam::SavedMap merged =
      slam::merge_maps(std::move(maps), options.slam.slam, options.slam.localizer, not_found);
  const auto results = open_results(arguments.out, arguments.inputs);
  slam::write_map_files(results->path(), merged, options.slam.slam.grid);
  write_sessions(results->path(), merged);
  for (const std::size_t index : not_found) {
    print(stderr, "%s: left out; not found in the previous maps\n",
          arguments.inputs[index].c_str());
    require(!same_folder(arguments.inputs[index], arguments.out),
            arguments.out + ": unchanged, because its map would be lost; choose another --out");
  }
  results->commit();
  print(stdout, "%zu maps, %zu keyframes, %zu loops; the results are in %s\n",
        arguments.inputs.size() - not_found.size(), merged.slam.keyframes.keys.size(),
        merged.slam.back_end.loops.size(), arguments.out.c_str());
  return not_found.empty() ? 0 : 1;
}

// Reports sessions that were not found in the map. @returns the exit code
int report_unfound(const MapArguments& arguments, const MapJob& job) {
  if (job.session() == nullptr) return 0;
  if (!arguments.localize.empty() && arguments.start.empty() && job.session()->findings().empty()) {
    const std::string fault = arguments.localize + ": the recording was not found in this map";
    require(!same_folder(arguments.localize, arguments.out),
            fault + "; " + arguments.out + " is unchanged");
    print(stderr, "%s\n", fault.c_str());
    return 1;
  }
  for (const KeptApart& apart : kept_apart(job)) {
    print(stderr, "%s: not found in the map of the others; its own map is in %s\n",
          apart.inputs.c_str(), (std::filesystem::path(arguments.out) / apart.folder).c_str());
  }
  return job.session()->apart().empty() ? 0 : 1;
}

// Everything the command line names: an earlier result may be among it.
std::vector<std::string> named_inputs(const MapArguments& arguments) {
  std::vector<std::string> named = arguments.inputs;
  named.insert(named.end(), {arguments.config, arguments.foreign, arguments.world, arguments.extend,
                             arguments.localize, arguments.edits, arguments.calibration});
  std::erase(named, "");
  return named;
}

// Nothing to do for a model without triangles, or a recording without pictures.
PhotographCounts paint(const std::filesystem::path& out,
                       const TriangleMesh& mesh,
                       MapJob& job,
                       const PhotographOptions& options,
                       files::GlbNumbers glb_numbers) {
  if (mesh.triangles.empty()) return {};
  std::vector<std::string> logs;
  for (const files::InputReport& input : job.inputs()) {
    if (input.pictures > 0) logs.insert(logs.end(), input.paths.begin(), input.paths.end());
  }
  PhotographCounts counts = write_photographs(out, logs, job.trajectory(), job.sensors(), options);
  if (counts.chosen > 0) counts.painted = paint_elsewhere(out, mesh, glb_numbers);
  if (counts.recorded > 0) job.clock().end_stage("photographs");
  return counts;
}

void order_loop_pictures(std::vector<PictureOrder>& pictures,
                         const std::filesystem::path& folder,
                         const MapJob& job) {
  std::filesystem::create_directories(folder);
  for (PictureOrder& order : loop_pictures(folder, job)) pictures.push_back(std::move(order));
}

// The map that the session continues, and those of inputs that were not found in it.
void write_session(const std::filesystem::path& out,
                   const MapJob& job,
                   const slam::SlamOptions& options) {
  if (job.session() == nullptr || job.session()->localizer() != nullptr) return;
  save(out, job.session()->saved(process::print_options(options, process::Printed::changed)));
  for (const KeptApart& apart : kept_apart(job)) {
    std::filesystem::create_directories(out / apart.folder);
    slam::write_map_files(out / apart.folder, *apart.map, options.grid);
  }
}

void draw(const std::filesystem::path& out,
          const GridMap& map,
          const LineMap& lines,
          const MapJob& job,
          const std::optional<MapVerdict>& verdict,
          bool with_loops) {
  const TriangleMesh& model = job.mapping3d().mapper().model();
  std::vector<PictureOrder> pictures;
  if (map.width_cells > 0) {
    pictures.push_back(map_picture(out / "map.png", map, job));
    if (verdict) mark_picture(pictures.back(), *verdict);
  }
  if (!model.triangles.empty()) pictures.push_back(model_picture(out / "model.png", model, job));
  if (job.lines() != nullptr) {
    for (PictureOrder& order : line_pictures(out, map, lines, job)) {
      pictures.push_back(std::move(order));
    }
  }
  if (verdict) {
    for (PictureOrder& order : doctor_pictures(out, *verdict)) {
      pictures.push_back(std::move(order));
    }
  }
  if (with_loops) order_loop_pictures(pictures, out / "loops", job);
  draw_elsewhere(std::move(pictures), (out / "pictures.part").string());
}

int exit_code_of(const std::optional<MapVerdict>& verdict) {
  return verdict && verdict->is_wrong() ? process::kExitWrongMap : process::kExitDone;
}

void print_left_out(const MapJob& job) {
  if (!job.own_body().empty()) {
    print(stdout, "set-up: %s: these returns are ignored\n", describe(job.own_body()).c_str());
  }
  for (const FloorLine& floor : job.floor()) {
    print(stdout, "set-up: %s: returns beyond are ignored\n", describe(floor).c_str());
  }
}

// The verdict alone: what is written on the way goes with a folder of its own.
int check(const MapArguments& arguments) {
  const ScratchFolder folder;
  const auto [map, correction] =
      make_corrected_map(arguments, load_batch_input(arguments), folder.path());
  print_left_out(*map.job);
  if (correction) print_correction(*correction);
  print_verdict(*map.verdict, *map.job, false);
  return exit_code_of(map.verdict);
}

// What is written before the surface, as far as pictures and figures need it.
struct WrittenMap {
  GridMap grid;
  LineMap lines;
  bool calibrated = true;
};

WrittenMap write_map(const std::filesystem::path& out,
                     const MapArguments& arguments,
                     const CorrectedMap& made,
                     const slam::SlamOptions& options) {
  MapJob& job = *made.map.job;
  write_paths(out, job, made.correction);
  write_session(out, job, options);
  WrittenMap map;
  map.grid = job.grid();
  if (map.grid.width_cells > 0) files::write_map(out, map.grid);
  if (made.map.verdict) mark_map(out, *made.map.verdict);
  if (arguments.sweep_meshes) {
    const TriangleMesh sweeps = job.mapping3d().mapper().scene_meshes();
    if (!sweeps.triangles.empty()) files::write_ply(out / "model_scenes.ply", sweeps);
  }
  if (job.lines() != nullptr) {
    map.lines = job.lines()->mapper().map();
    write_lines(out, map.lines, job);
  }
  if (arguments.calibrate) map.calibrated = write_calibration(out / "calibration.toml", job);
  job.clock().end_stage("write");
  return map;
}

mapping3d::JoinedSurface write_surface(const std::filesystem::path& out,
                                       MapJob& job,
                                       const mapping3d::SurfacePipelineOptions& options,
                                       files::GlbNumbers glb_numbers) {
  job.clock().show_stage("joining the surface");
  job.finish_model();  // the sweeps' ranges go: simplifying the surface needs the memory
  const TriangleMesh& model = job.mapping3d().mapper().model();
  mapping3d::JoinedSurface joined = mapping3d::join_surface(model, options);
  write_joined_surface(out, model, joined, glb_numbers);
  job.clock().end_stage("surface");
  return joined;
}

// Compares with what is known to be true, and paints the model.
ReportExtras compare_and_paint(const std::filesystem::path& out,
                               const MapArguments& arguments,
                               const CorrectedMap& made,
                               const GridMap& grid,
                               const mapping3d::JoinedSurface& joined,
                               const PhotographOptions& photographs) {
  MapJob& job = *made.map.job;
  job.clock().show_stage("comparing and painting");
  const mapping3d::Mapper3d& mapper = job.mapping3d().mapper();
  ReportExtras extras{judge_path(job),
                      figures_of(mapper.model(), joined, mapper.scenes().size()),
                      paint(out, joined.simplified.mesh, job, photographs, arguments.glb_numbers),
                      arguments.command_line,
                      process::print_options(process::load_options<MapOptions>(arguments.config),
                                             process::Printed::changed),
                      made.map.verdict ? &*made.map.verdict : nullptr,
                      made.correction ? &*made.correction : nullptr};
  extras.errors.merge(judge_held_out(job, grid));
  if (!arguments.world.empty()) {
    extras.errors.merge(judge_against_world(job, grid, mapper.model(), arguments.world));
  }
  job.clock().end_stage("judge");
  return extras;
}

void print_outcome(const MapArguments& arguments,
                   const CorrectedMap& made,
                   const ReportExtras& extras) {
  const MapJob& job = *made.map.job;
  print_summary(job, extras, arguments.out);
  print_left_out(job);
  if (made.correction) print_correction(*made.correction);
  if (made.map.verdict) print_verdict(*made.map.verdict, job, true);
}

int run(const MapArguments& arguments) {
  process::catch_interrupts(arguments.out + " is unchanged");
  BatchInput input = load_batch_input(arguments);
  const MapOptions options = input.options;
  const auto results = open_results(arguments.out, named_inputs(arguments));
  const std::filesystem::path out = results->path();
  const CorrectedMap made = make_corrected_map(arguments, std::move(input), out);
  MapJob& job = *made.map.job;
  const WrittenMap map = write_map(out, arguments, made, options.slam.slam);
  const mapping3d::JoinedSurface joined =
      write_surface(out, job, options.joined_surface, arguments.glb_numbers);
  job.clock().show_stage("drawing");
  draw(out, map.grid, map.lines, job, made.map.verdict, arguments.loop_pictures);
  job.clock().end_stage("pictures");
  const ReportExtras extras =
      compare_and_paint(out, arguments, made, map.grid, joined, options.photographs);
  write_report(out / "report.json", job, extras);
  const int unfound = report_unfound(arguments, job);
  process::end_if_interrupted();
  results->commit();
  print_outcome(arguments, made, extras);
  require(map.calibrated,
          "--calibrate: neither odometry nor a gyroscope moves in this drive, and no two sweeps at "
          "one stop saw the same walls");
  return unfound != 0 ? unfound : exit_code_of(made.map.verdict);
}

}  // namespace
}  // namespace marco

int main(int argc, char** argv) {
  return marco::process::run_main("marco map", [&] {
    marco::MapArguments arguments;
    if (const auto code = marco::parse_map_arguments(argc, argv, arguments)) return *code;
    if (arguments.merge) return marco::merge(arguments);
    if (const auto code = marco::model_point_scans(arguments)) return *code;
    return arguments.check ? marco::check(arguments) : marco::run(arguments);
  });
}
