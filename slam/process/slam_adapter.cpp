#include "slam/process/slam_adapter.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/input/beam_times.hpp"
#include "lcm_tools/process/config.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "slam/process/map_folder.hpp"

namespace marco::slam {
namespace {

constexpr int kDrawnAtOnce = 4;  // keyframes

}  // namespace

SlamAdapter::SlamAdapter(process::Bus& bus,
                         const SlamAdapterOptions& options,
                         const std::function<void(const std::string&)>& warn)
    : Mapper2dAdapter(bus, options, channels::kGridMap, warn),
      options_(options),
      session_(options.slam, options.localizer),
      grid_(options.slam.grid) {
  validate(options, "slam_process");
  if (options_.checkpoint_path.empty()) return;
  auto state = load_adapter_state(options_.checkpoint_path, warn);
  if (!state) {
    put_checkpoint_aside(options_.checkpoint_path, warn);
  } else {
    resume(std::move(*state));
    resumed_ = true;
  }
}

void SlamAdapter::close_loops_in_background() {
  session_.defer_loop_work();
  if (!loop_worker_) loop_worker_ = std::make_unique<LoopWorker>();
  write_in_background();
  keep_short_path();
}

void SlamAdapter::keep_short_path() {
  session_.keep_short_path(options_.path_every_m);
  keep_no_path();
}

void SlamAdapter::set_edits(const MapEdits& edits) {
  edits_ = edits;
  session_.set_edits(edits);
}

bool SlamAdapter::exchange_loop_work(Utime utime) {
  if (!loop_worker_) return false;
  bool changed = false;
  if (loop_worker_->busy()) {
    const Duration since = utime - loop_work_asked_;
    if (std::abs(since.seconds()) < options_.loop_delay_s) return false;
    const std::optional<LoopWork> done = loop_worker_->take_done();
    if (!done) {
      // Counted at once: a run may end before it comes.
      if (!std::exchange(loop_work_is_late_, true)) ++late_loop_work_;
      return false;
    }
    loop_work_is_late_ = false;
    changed = session_.accept(*done);
  }
  if (auto work = session_.take_loop_work()) {
    loop_worker_->start(std::move(*work));
    loop_work_asked_ = utime;
  }
  return changed;
}

MappedScan SlamAdapter::map_scan(const SynchronizedScan& scan, bool may_draw) {
  const Utime utime = scan.scan.utime;
  const bool distrusted = is_covered(edits_, MapEdit::Kind::distrust_odometry, utime);
  const auto odometry_step = distrusted ? std::nullopt : scan.odometry_step;
  const ScanVelocity velocity = session_.velocity_during(odometry_step, scan.duration_s);
  SlamInput input = slam_input(scan, velocity);
  if (distrusted) input.motion.odom_from_robot.reset();
  input.may_draw = may_draw;
  scan_is_level_ = scan.level;
  note_doubtful(scan, may_draw);
  give_up_resuming();
  const bool loop_closed = exchange_loop_work(utime);
  const SlamUpdate update = session_.process(input);
  if (update.covered) drops_.count("laser was covered");
  const auto order = input_.note_misfits(scan, update.misfits_m2);
  if (order && !doubtful_.empty()) return map_again(*order);
  // In parts: redrawing all keyframes takes seconds.
  if (loop_worker_ && options_.map_period_s > 0.0) grid_.advance(session_.keys(), kDrawnAtOnce);
  MappedScan mapped;
  mapped.estimate = {utime, update.world_from_robot, update.covariance, update.status,
                     update.overlap};
  mapped.trajectory_changed = update.trajectory_changed || loop_closed;
  mapped.used = used_scan(std::move(input), update.status == SlamUpdate::Status::matched);
  return mapped;
}

void SlamAdapter::note_doubtful(const SynchronizedScan& scan, bool may_draw) {
  // Scans, five minutes: without turns by then the order of beams stays unknown.
  constexpr int64_t kMost = 3000;
  const bool sure = scan.beam_order.order && scan.beam_order.rivals.empty();
  const bool from_the_start = progress_.scan_count == static_cast<int64_t>(doubtful_.size()) + 1 &&
                              session_.mode() == MappingSession::Mode::mapping;
  if (!sure && from_the_start && progress_.scan_count < kMost && sees_all_round(scan.scan)) {
    doubtful_.push_back({scan, may_draw});
  } else {
    doubtful_.clear();
  }
}

MappedScan SlamAdapter::map_again(BeamOrder order) {
  std::vector<DoubtfulScan> scans = std::exchange(doubtful_, {});
  const SynchronizedScan newest = scans.back().scan;
  session_.reset();
  MappedScan mapped;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    SynchronizedScan& scan = scans[i].scan;
    // The first ones came before the period was known.
    const BeamOrder now = scan.beam_order.order.value_or(*newest.beam_order.order);
    scan.scan.time_offsets_s =
        reordered_times_s(scan.scan, newest.motion.scan_period_s, now, order);
    scan.duration_s = duration_of(scan.scan, scan.info);
    scan.odometry_step.reset();
    scan.beam_order = {};
    mapped = map_scan(scan, scans[i].may_draw);
    if (i < progress_.scans.size()) progress_.scans[i] = mapped.used;
    scan.beam_order.order = order;
  }
  doubtful_ = std::move(scans);
  mapped.trajectory_changed = true;
  return mapped;
}

void SlamAdapter::publish_map(Utime utime) {
  const OccupancyGrid& grid = loop_worker_ ? grid_.grid() : grid_.update(session_.keys());
  note_size(grid);
  const GridMap map = grid.to_map();
  for (const grid_map_t& tile : to_messages(map, utime, session_.revision())) {
    bus_.publish(channels::kGridMap, tile);
  }
}

void SlamAdapter::note_size(const OccupancyGrid& grid) {
  if (!grid.too_large_m() || std::exchange(too_large_, true)) return;
  char text[120];
  std::snprintf(text, sizeof text, "the map would be %.0f x %.0f m: distant parts are not drawn",
                grid.too_large_m()->x(), grid.too_large_m()->y());
  drops_.count(text);
}

void SlamAdapter::finish_mapping() {
  if (loop_worker_) {
    if (const auto done = loop_worker_->wait()) session_.accept(*done);
  }
  loop_worker_.reset();
  session_.finish();
}

std::string SlamAdapter::save(const std::filesystem::path& folder) {
  require(session_.mode() != MappingSession::Mode::localizing,
          "SAVE: the map does not change while localizing");
  // Alone, what was driven since would take the place of the map that it is to extend.
  const SavedMap* waiting = session_.waiting_map();
  require(
      waiting != nullptr || session_.mode() != MappingSession::Mode::extending || session_.joined(),
      "SAVE: the robot has not yet been found in the map that it extends");
  require(waiting != nullptr || !session_.keys().empty(),
          "SAVE: there is no map yet: " + mapping_line());
  return orders_.write([folder,
                        map = waiting != nullptr ? *waiting
                                                 : session_.saved(process::print_options(
                                                       options_.slam, process::Printed::changed)),
                        drawing = options_.slam.grid] {
    save_map_folder(folder, map, drawing);
    return "SAVE " + folder.string() + ": saved " + std::to_string(map.slam.keyframes.keys.size()) +
           " keyframes";
  });
}

std::string SlamAdapter::execute_on_map(const SlamOrder& order) {
  switch (order.command) {
    case slam_command_t::SAVE:
      return save(order.folder);
    case slam_command_t::LOCALIZE:
      session_.localize(session_.localizer_in(load_map_folder(order.folder)));
      return "LOCALIZE " + order.folder.string() + ": relocalizing in " +
             std::to_string(session_.keys().size()) + " keyframes";
    case slam_command_t::EXTEND: {
      SavedMap map = load_map_folder(order.folder);
      const std::size_t keyframes = map.slam.keyframes.keys.size();
      session_.extend(std::move(map));
      return "EXTEND " + order.folder.string() + ": looking for the robot in " +
             std::to_string(keyframes) + " keyframes; new keyframes will be added";
    }
    case slam_command_t::RESET:
      session_.reset();
      return "RESET: starting a new map";
    default:  // SET_POSE
      session_.set_pose(order.world_from_robot);
      return session_.localizer() != nullptr ? "SET_POSE: tracking from there"
                                             : "SET_POSE: starting a new map from there";
  }
}

std::string SlamAdapter::mapping_line() const {
  const PlaceEstimate* estimate = session_.estimate();
  const Localizer* localizer = session_.localizer();
  if (localizer != nullptr && localizer->is_localized()) return "localized";
  if (session_.waiting_map() != nullptr) {
    return "looking for the robot in the map of " +
           std::to_string(session_.waiting_map()->slam.keyframes.keys.size()) +
           " keyframes that is to be resumed";
  }
  if (session_.keys().empty() && !scan_is_level_) return "no map: the laser is not level";
  if (estimate == nullptr) return std::to_string(slam().key_count()) + " keyframes";
  return estimate->candidates.empty() ? "not found in the map yet"
                                      : std::to_string(estimate->candidates.size()) + " places fit";
}

AdapterState SlamAdapter::state() const {
  return {session_.saved(process::print_options(options_.slam, process::Printed::changed)),
          input_.state(), progress_, drops_.received(), drops_.by_cause()};
}

void SlamAdapter::restore(AdapterState state) {
  session_.restore(state.map);
  restore_input(state);
}

void SlamAdapter::resume(AdapterState state) {
  if (state.map.slam.keyframes.keys.empty()) return restore(std::move(state));
  session_.resume(std::move(state.map));
  restore_input(state);
}

void SlamAdapter::give_up_resuming() {
  constexpr double kLongestM = 20.0;  // the finder looks closely over the first 15 m
  const auto old = session_.give_up_after(kLongestM);
  if (!old) return;
  const std::filesystem::path checkpoint = options_.checkpoint_path;
  const std::filesystem::path home = options_.maps_folder.empty()
                                         ? checkpoint.parent_path()
                                         : std::filesystem::path(options_.maps_folder);
  const std::filesystem::path folder = home / ("before_" + time_of(checkpoint));
  try {
    save_map_folder(folder, *old, options_.slam.grid);
    drops_.count(
        "the robot was not found in the previous map: starting a new one; the old one is " +
        folder.string());
  } catch (const std::runtime_error& full) {
    put_checkpoint_aside(checkpoint, [this](const std::string& line) { drops_.count(line); });
  }
}

void SlamAdapter::end_checkpoint() {
  if (options_.checkpoint_path.empty()) return;
  checkpoints_.write_in_foreground();
  auto job = checkpoint_job();
  checkpoints_.write([&] {
    if (job) job();
    mark_ended(options_.checkpoint_path);
  });
}

void SlamAdapter::restore_input(AdapterState& state) {
  input_.restore(std::move(state.input));
  progress_ = std::move(state.progress);
  drops_.restore(state.received, std::move(state.drops));
  paused_ = false;
}

std::function<void()> SlamAdapter::checkpoint_job() {
  if (session_.mode() != MappingSession::Mode::mapping && !session_.joined()) return {};
  return [path = options_.checkpoint_path, now = state()] { save_adapter_state(path, now); };
}

}  // namespace marco::slam
