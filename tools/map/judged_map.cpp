#include "tools/map/judged_map.hpp"

#include <algorithm>

#include "common/input/process/calibration_file.hpp"
#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/process/config.hpp"
#include "recordings/recording_folder.hpp"
#include "tools/map/calibration.hpp"
#include "tools/map/own_body_search.hpp"

namespace marco {
namespace {

std::vector<RecordingParts> recordings_among(const MapArguments& arguments) {
  return recordings_of({arguments.inputs.begin(), arguments.inputs.end()});
}

// A recording of another building cannot extend the map: then nothing is written.
void require_extended(const MapArguments& arguments, const MapJob& job) {
  if (arguments.extend.empty()) return;
  require(!job.session()->findings().empty(),
          arguments.extend + ": the recording was not found in this map, which stays unchanged");
}

void load_edits(const MapArguments& arguments, MapJob& job) {
  if (arguments.edits.empty()) return;
  try {
    job.set_edits(slam::parse_map_edits(files::read_whole_file(arguments.edits)));
  } catch (const std::invalid_argument& wrong) {
    throw std::invalid_argument(arguments.edits + ", " + wrong.what());
  }
}

void require_scans(const MapArguments& arguments, const MapJob& job) {
  require(!job.live_trajectory().empty(),
          arguments.inputs.front() + ": holds no usable laser scan");
}

void apply(const CalibrationFile& calibration, MapOptions& options) {
  options.slam.input.calibration = calibration;
  options.mapping3d.correction = calibration.pantilt;
}

bool can_be_corrected(const MapArguments& arguments) {
  return !arguments.no_calibration && arguments.calibration.empty() &&
         recordings_among(arguments).size() == 1 && arguments.extend.empty() &&
         arguments.localize.empty();
}

// As good at least by its verdict, and by the scans that were matched.
bool is_as_good(const JudgedMap& again, const JudgedMap& first) {
  constexpr double kFewer = 0.99;
  const auto matched = [](const JudgedMap& map) {
    const auto& scans = map.job->scans();
    return static_cast<double>(
        std::count_if(scans.begin(), scans.end(), [](const auto& scan) { return scan.matched; }));
  };
  return again.verdict->diagnosis.verdict <= first.verdict->diagnosis.verdict &&
         matched(again) >= kFewer * matched(first);
}

}  // namespace

MapOptions load_batch_options(const MapArguments& arguments, const ForeignTable& foreign) {
  MapOptions options = process::load_options<MapOptions>(arguments.config);
  apply(load_calibration(arguments.calibration), options);
  // A batch run publishes its map once, at the end.
  options.slam.map_period_s = options.lines.map_period_s = 0.0;
  options.slam.hold_out_every = options.lines.hold_out_every = arguments.hold_out_every;
  std::vector<BodyPart>& body = options.slam.input.calibration.body;
  for (const RecordingParts& parts : recordings_among(arguments)) {
    const std::vector<BodyPart> found = find_own_body(parts, foreign, body);
    body.insert(body.end(), found.begin(), found.end());
  }
  return options;
}

JudgedMap make_map(const MapArguments& arguments,
                   const MapOptions& options,
                   const ForeignTable& foreign,
                   const std::filesystem::path& folder,
                   const StageClock& clock) {
  JudgedMap map{std::make_unique<MapJob>(
                    options, arguments.lines ? PathMaker::lines : PathMaker::scans, folder),
                {}};
  MapJob& job = *map.job;
  job.clock() = clock;
  load_edits(arguments, job);
  if (!arguments.extend.empty()) job.extend(arguments.extend);
  if (!arguments.localize.empty()) {
    const std::vector<double>& start = arguments.start;
    job.localize(arguments.localize,
                 start.empty() ? std::nullopt
                               : std::optional<Pose2>({start[0], start[1], deg_to_rad(start[2])}));
  }
  for (const RecordingParts& parts : recordings_among(arguments)) job.read(parts, foreign);
  require_extended(arguments, job);
  job.finish();
  require_scans(arguments, job);
  map.verdict = judge_map(job);
  job.clock().end_stage("verdict");
  return map;
}

// Makes the map again where the recording's own set-up was not as it said.
std::optional<SelfCorrection> correct(const MapArguments& arguments,
                                      MapOptions options,
                                      const ForeignTable& foreign,
                                      const std::filesystem::path& out,
                                      JudgedMap& map) {
  if (!can_be_corrected(arguments)) return std::nullopt;
  auto found = self_calibration_of(*map.job);
  if (!found) return std::nullopt;
  map.job->clock().end_stage("calibration");
  SelfCorrection correction{std::move(*found)};
  const auto ask = [&correction](JudgedMap& judged) {
    const std::string& question = correction.found.open_question;
    if (!question.empty() && judged.verdict) judged.verdict->diagnosis.ask(question);
  };
  ask(map);
  const SensorCalibration needed = needed_correction(
      correction.found, map.verdict ? distance_by_odometry_m(map.verdict->evidence.edges) : 0.0);
  if (needed == SensorCalibration{}) return correction;
  CalibrationFile file;
  static_cast<SensorCalibration&>(file) = needed;
  file.body = options.slam.input.calibration.body;
  apply(file, options);
  const std::filesystem::path folder = out / "corrected.part";
  std::filesystem::create_directory(folder);
  JudgedMap again = make_map(arguments, options, foreign, folder, map.job->clock());
  ask(again);
  const bool taken = is_as_good(again, map);
  correction.use = taken ? SelfCorrection::Use::in_force : SelfCorrection::Use::rejected;
  if (taken) {
    std::filesystem::rename(folder / "slam.lcm", out / "slam.lcm");
    map = std::move(again);
  } else {
    map.job->clock() = again.job->clock();
  }
  std::filesystem::remove_all(folder);
  return correction;
}

}  // namespace marco
