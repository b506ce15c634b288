#include "tools/map/judged_map.hpp"

#include <algorithm>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/process/config.hpp"
#include "live/calibration_file.hpp"
#include "recordings/recording.hpp"
#include "recordings/recording_folder.hpp"
#include "slam/process/mapper2d_adapter.hpp"
#include "slam/session/mapping_session.hpp"
#include "tools/map/beam_search.hpp"
#include "tools/map/calibration.hpp"
#include "tools/map/look_ahead.hpp"

namespace marco {
namespace {

// Of all recordings together. Of this many, none is kept open either.
constexpr std::size_t kMostKeptBytes = 500'000'000, kMostKeptOpen = 100;

std::vector<BatchInput::Recording> recordings_among(const MapArguments& arguments) {
  const auto all = recordings_of({arguments.inputs.begin(), arguments.inputs.end()});
  const auto foreign = process::load_options<ForeignTable>(arguments.foreign);
  const std::size_t most_bytes = all.size() < kMostKeptOpen ? kMostKeptBytes / all.size() : 0;
  std::vector<BatchInput::Recording> recordings;
  for (const RecordingParts& parts : all) {
    const auto open = [parts, foreign] { return open_recording(parts, foreign); };
    recordings.push_back({parts.front(), std::make_unique<KeptSamples>(open, most_bytes)});
  }
  return recordings;
}

// A recording of another building cannot extend the map: then nothing is written.
void require_extended(const MapArguments& arguments, const MapJob& job) {
  if (arguments.extend.empty()) return;
  require(!job.session()->findings().empty(),
          arguments.extend + ": the recording was not found in this map, which is unchanged");
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
  if (!job.adapter().live_trajectory().empty()) return;
  std::string why = arguments.inputs.front() + ": contains no usable laser scan";
  const auto add = [&why](const std::string& cause, int64_t count) {
    why += "\n  dropped: " + cause + " " + std::to_string(count);
  };
  for (const files::InputReport& input : job.recorded().inputs) {
    for (const auto& [cause, count] : input.dropped) {
      add(cause, count);
      why += " (first at " + input.places.at(cause) + ")";
    }
  }
  for (const auto& [cause, count] : job.adapter().drops().by_cause()) add(cause, count);
  throw std::invalid_argument(why);
}

void apply(const CalibrationFile& calibration, MapOptions& options) {
  options.slam.input.calibration = calibration;
  options.slam.input.pantilt_late_s = calibration.pantilt.late_s;
  options.mapping3d.correction = calibration.pantilt;
}

bool can_be_corrected(const MapArguments& arguments, const BatchInput& input) {
  return !arguments.no_calibration && arguments.calibration.empty() && input.recordings.size() == 1;
}

bool is_judged_as_good(const JudgedMap& again, const JudgedMap& first) {
  return !first.verdict || again.verdict->diagnosis.verdict <= first.verdict->diagnosis.verdict;
}

// As good at least by its verdict, and by the scans that were matched.
bool is_as_good(const JudgedMap& again, const JudgedMap& first) {
  constexpr double kFewer = 0.99;
  const auto matched = [](const JudgedMap& map) {
    const auto& scans = map.job->adapter().scans();
    return static_cast<double>(
        std::count_if(scans.begin(), scans.end(), [](const auto& scan) { return scan.matched; }));
  };
  return is_judged_as_good(again, first) && matched(again) >= kFewer * matched(first);
}

}  // namespace

BatchInput load_batch_input(const MapArguments& arguments) {
  BatchInput input{
      recordings_among(arguments), process::load_options<MapOptions>(arguments.config), {}};
  MapOptions& options = input.options;
  apply(load_calibration(arguments.calibration), options);
  // A batch run publishes its map once, at the end.
  options.slam.map_period_s = options.lines.map_period_s = 0.0;
  options.slam.hold_out_every = options.lines.hold_out_every = arguments.hold_out_every;
  std::vector<BodyPart>& body = options.slam.input.calibration.body;
  for (const BatchInput::Recording& recording : input.recordings) {
    const LookAhead found = look_ahead(*recording.samples, recording.name, body);
    recording.samples->rewind();
    body.insert(body.end(), found.body.begin(), found.body.end());
    if (options.odometry_fault.empty()) options.odometry_fault = found.odometry_fault;
    input.clock.end_stage("look through " + recording.name.filename().string());
  }
  return input;
}

namespace {

// Reads all inputs, makes the map and judges it. @param folder  of slam.lcm
// @param clock  keeps running
JudgedMap make_map(const MapArguments& arguments,
                   const BatchInput& input,
                   const MapOptions& options,
                   const std::filesystem::path& folder,
                   const StageClock& clock) {
  JudgedMap map{
      std::make_unique<MapJob>(options, arguments.lines ? PathMaker::lines : PathMaker::scans,
                               folder, arguments.results_log ? Logged::published : Logged::all),
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
  for (const BatchInput::Recording& recording : input.recordings) {
    job.read(*recording.samples, recording.name);
  }
  require_extended(arguments, job);
  job.finish();
  require_scans(arguments, job);
  job.clock().show_stage("judging the map");
  map.verdict = judge_map(job);
  job.clock().end_stage("verdict");
  return map;
}

// A blurred map of the same scans fills more cells; a percent is chance.
bool is_sharper(const JudgedMap& again, const JudgedMap& first) {
  constexpr double kSharper = 0.98;
  const auto cells = [](const JudgedMap& map) {
    return static_cast<double>(slam::cells_of_walls(map.job->mapper().keys()));
  };
  return cells(again) < kSharper * cells(first);
}

/// Makes a map again with other calibrations, and keeps the better one.
class Remapping {
 public:
  Remapping(const MapArguments& arguments,
            const BatchInput& input,
            const std::filesystem::path& out,
            JudgedMap& map)
      : arguments_(arguments), input_(input), options_(input.options), out_(out), map_(map) {}

  bool was_taken() const { return taken_; }
  const SensorCalibration& calibration() const { return options_.slam.input.calibration; }

  template <class IsBetter>
  bool try_with(const SensorCalibration& calibration, IsBetter is_better) {
    MapOptions options = options_;
    options.slam.input.calibration = calibration;
    const std::filesystem::path folder = out_ / "corrected.part";
    std::filesystem::create_directory(folder);
    input_.recordings.front().samples->rewind();
    JudgedMap again = make_map(arguments_, input_, options, folder, map_.job->clock());
    const bool taken = is_better(again, map_);
    if (taken) {
      std::filesystem::rename(folder / "slam.lcm", out_ / "slam.lcm");
      map_ = std::move(again);
      options_ = std::move(options);
      taken_ = true;
    } else {
      map_.job->clock() = again.job->clock();
    }
    std::filesystem::remove_all(folder);
    return taken;
  }

 private:
  const MapArguments& arguments_;
  const BatchInput& input_;
  MapOptions options_;
  std::filesystem::path out_;
  JudgedMap& map_;
  bool taken_ = false;
};

// First, for whatever else is looked for is asked of walls.
void correct_floor(Remapping& remapping, JudgedMap& map) {
  const auto floor = search_floor(*map.job);
  if (!floor) return;
  SensorCalibration calibration = remapping.calibration();
  calibration.floor = {*floor};
  if (!remapping.try_with(calibration, is_judged_as_good) && map.verdict) {
    map.verdict->diagnosis.ask(describe(*floor) +
                               ", but a map without these returns is worse: is it level?");
  }
}

// Before odometry, for a map with bent rooms says wrong things of it.
void correct_beams(Remapping& remapping, JudgedMap& map, slam::SelfCalibration& found) {
  const auto beams = search_beams(*map.job);
  if (!beams) return;
  bool better = false;
  if (beams->is_off()) {
    SensorCalibration calibration = remapping.calibration();
    calibration.beams = {beams->corrected()};
    better = remapping.try_with(calibration, [](const JudgedMap& again, const JudgedMap& first) {
      return is_as_good(again, first) && is_sharper(again, first);
    });
  }
  beams->add_to(found, better);
}

// @returns what was found of the set-up; nothing where it was not looked for.
std::optional<SelfCorrection> correct(const MapArguments& arguments,
                                      const BatchInput& input,
                                      const std::filesystem::path& out,
                                      JudgedMap& map) {
  if (!can_be_corrected(arguments, input)) return std::nullopt;
  Remapping remapping(arguments, input, out, map);
  SelfCorrection correction;
  slam::SelfCalibration beams;
  map.job->clock().show_stage("calibrating");
  // A saved map's walls are not this recording's.
  if (arguments.extend.empty() && arguments.localize.empty()) {
    correct_floor(remapping, map);
    correct_beams(remapping, map, beams);
  }
  auto found = self_calibration_of(*map.job);
  if (!found && beams.parameters.empty()) return std::nullopt;
  if (found) correction.found = std::move(*found);
  std::vector<slam::CalibratedParameter>& parameters = correction.found.parameters;
  parameters.insert(parameters.end(), beams.parameters.begin(), beams.parameters.end());
  map.job->clock().end_stage("calibration");
  const SensorCalibration needed = needed_correction(
      correction.found, map.verdict ? distance_by_odometry_m(map.verdict->evidence.edges) : 0.0);
  const bool is_needed = needed != SensorCalibration{};
  if (is_needed) {
    SensorCalibration calibration = needed;
    calibration.beams = remapping.calibration().beams;
    calibration.body = remapping.calibration().body;
    calibration.floor = remapping.calibration().floor;
    remapping.try_with(calibration, is_as_good);
  }
  if (remapping.calibration().laser == LaserCalibration{}) {
    correction.assumed_from_found_robot = assumed_from_found_robot(correction.found);
  }
  if (map.verdict) {
    std::vector<std::string> questions{correction.found.open_question};
    if (correction.assumed_from_found_robot) questions.push_back(doubt_of_laser(correction.found));
    for (const std::string& question : questions) {
      if (!question.empty()) map.verdict->diagnosis.ask(question);
    }
  }
  // A failed trial of floor or beams prints its own message.
  if (remapping.was_taken()) {
    correction.use = SelfCorrection::Use::in_force;
  } else if (is_needed) {
    correction.use = SelfCorrection::Use::rejected;
  }
  return correction;
}

}  // namespace

CorrectedMap make_corrected_map(const MapArguments& arguments,
                                BatchInput input,
                                const std::filesystem::path& folder) {
  if (!can_be_corrected(arguments, input)) {
    for (const BatchInput::Recording& recording : input.recordings) {
      recording.samples->rewind_for_the_last_time();
    }
  }
  CorrectedMap made{make_map(arguments, input, input.options, folder, input.clock), {}};
  made.correction = correct(arguments, input, folder, made.map);
  return made;
}

}  // namespace marco
