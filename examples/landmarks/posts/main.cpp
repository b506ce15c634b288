#include <chrono>
#include <cstdio>
#include <map>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/output_folder.hpp"
#include "lcm_tools/process/arguments.hpp"
#include "lcm_tools/process/config.hpp"
#include "lcm_tools/process/exit_code.hpp"
#include "lcm_tools/process/stop_signal.hpp"
#include "posts/posts_input.hpp"
#include "posts/posts_results.hpp"

namespace marco {
namespace {

struct PostsOptions {
  std::string bearings = "auto";
  CarOptions car;
  slam::LandmarkSlamOptions landmarks;

  template <class Visitor>
  void visit(Visitor& v) {
    v("bearings", bearings,
      "Where bearing 0 points: 'ahead', 'left', 'right', 'behind', counter-clockwise; or 'auto': "
      "found from the drive, in either sense.");
    v("car", car);
    v("landmarks", landmarks);
  }
};

struct Arguments {
  std::string folder;
  std::string out = "out/posts";
  std::string config;
};

slam::BearingConvention convention_of(const PostsOptions& options, const PostsInput& input) {
  if (options.bearings == "auto") {
    const auto found = slam::find_bearing_convention(input.drive, options.landmarks);
    if (found) return *found;
    std::fprintf(stderr,
                 "the drive does not show how bearings are counted: assuming counter-clockwise "
                 "from straight ahead\n");
    return {};
  }
  const std::map<std::string, double> zeros{{"ahead", 0.0},
                                            {"left", deg_to_rad(90)},
                                            {"right", deg_to_rad(-90)},
                                            {"behind", deg_to_rad(180)}};
  const auto zero = zeros.find(options.bearings);
  require(zero != zeros.end(),
          "bearings = '" + options.bearings + "': expected auto, ahead, left, right or behind");
  return {zero->second, 1.0};
}

void add(slam::LandmarkUpdate& sums, const slam::LandmarkUpdate& update) {
  sums.paired += update.paired;
  sums.unclear += update.unclear;
  sums.added += update.added;
  sums.joined += update.joined;
  sums.removed += update.removed;
}

// Samples and scans in the order of their times; a sample goes before a scan of its time.
PostsRun follow(const slam::LandmarkDrive& drive, const slam::LandmarkSlamOptions& options) {
  PostsRun run;
  slam::LandmarkSlam slam(options);
  slam::WheelIntegral wheels;
  const auto start = std::chrono::steady_clock::now();
  std::size_t next = 0;
  const auto drive_to = [&](Utime utime) {
    for (; next < drive.wheels.size() && drive.wheels[next].utime <= utime; ++next) {
      const slam::WheelVelocity& sample = drive.wheels[next];
      if (!slam.process(sample)) ++run.refused_samples;
      wheels.add(sample, slam::SetUpVector::Zero(), options.noise);
      run.path.push_back({sample.utime, slam.world_from_robot()});
      run.dead_reckoning.push_back({sample.utime, wheels.motion().start_from_end});
    }
  };
  for (const slam::SightingScan& scan : drive.scans) {
    process::end_if_interrupted();
    drive_to(scan.utime);
    add(run.sums, slam.process(scan));
    run.sightings += scan.sightings.size();
    if (!run.path.empty() && run.path.back().utime == scan.utime) run.path.pop_back();
    run.path.push_back({scan.utime, slam.world_from_robot()});
  }
  drive_to(drive.wheels.back().utime);
  run.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  run.scans = drive.scans.size();
  run.landmarks = slam.landmarks();
  run.noise = slam.noise();
  run.noise_factor = slam.noise_factor();
  run.set_up = slam.filter().set_up();
  run.set_up_sigma = slam.filter().set_up_sigma();
  return run;
}

int map_posts(const Arguments& arguments, const PostsOptions& options) {
  process::catch_interrupts(arguments.out + " is unchanged");
  PostsInput input = read_posts_folder(arguments.folder, options.car);
  const slam::BearingConvention bearings = convention_of(options, input);
  slam::straighten_bearings(bearings, input.drive.scans);
  PostsRun run = follow(input.drive, options.landmarks);
  run.bearings = bearings;
  files::OutputFolder results(arguments.out, "posts");
  results.keep(arguments.config);
  write_posts(results.path(), run, input);
  results.commit();
  std::printf("%zu landmarks from %zu sightings in %zu scans, %.2f ms a scan: %s\n",
              run.landmarks.size(), run.sightings, run.scans,
              1e3 * run.seconds / static_cast<double>(run.scans), arguments.out.c_str());
  if (const auto errors = path_errors(run.path, input)) {
    std::printf("path against %s: %.3f m rms, median %.3f, largest %.3f of %zu positions\n",
                input.truth_file.c_str(), errors->rms_m, errors->median_m, errors->most_m,
                errors->used);
  }
  return 0;
}

}  // namespace
}  // namespace marco

int main(int argc, char** argv) {
  return marco::process::run_main("map_posts", [&] {
    marco::process::CommandLine app(
        "Maps posts, trees and other landmarks, and the path among them, from wheel speeds and "
        "sightings (range and bearing) without landmark ids. FOLDER contains drive.csv, "
        "sightings.csv (or posts.csv, trees.csv), and optionally scans.csv, truth.csv or gps.csv, "
        "plain or .gz: README.md.");
    marco::Arguments arguments;
    marco::process::ConfigArguments config;
    app.add_option("FOLDER", arguments.folder).existing_folder();
    app.add_option("-o,--out", arguments.out, "folder for the results").shows_default();
    app.add_option("--config", arguments.config, "TOML").existing_file();
    marco::process::add_print_config(app, config);
    if (const auto code = app.parse(argc, argv)) return *code;
    const auto options = marco::process::load_options<marco::PostsOptions>(arguments.config);
    if (marco::process::prints_config(config, options)) return 0;
    marco::process::require_usage(!arguments.folder.empty(),
                                  "map_posts needs a FOLDER; --help says more");
    return marco::map_posts(arguments, options);
  });
}
