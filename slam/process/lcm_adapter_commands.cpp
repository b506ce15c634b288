// What a SlamAdapter does beside scans: orders, and its own survival.
#include <cmath>
#include <utility>

#include "lcm_tools/process/config.hpp"
#include "slam/process/lcm_adapter.hpp"
#include "slam/process/map_folder.hpp"

namespace marco::slam {
namespace {

/// @returns false on a full disk: the map goes on without.
bool save_quietly(const std::string& path, const AdapterState& state) {
  try {
    save_adapter_state(path, state);
    return true;
  } catch (const std::runtime_error&) {
    return false;
  }
}

}  // namespace

std::string SlamAdapter::save(const std::filesystem::path& folder) {
  require(session_.mode() != MappingSession::Mode::localizing,
          "SAVE: a map that is localized in is not changed");
  return orders_.write([folder, map = session_.saved(process::print_options(options_.slam)),
                        drawing = options_.slam.grid] {
    save_map_folder(folder, map, drawing);
    return "SAVE " + folder.string() + ": saved " + std::to_string(map.slam.keyframes.keys.size()) +
           " keyframes";
  });
}

std::string SlamAdapter::obey(const SlamOrder& order) {
  switch (order.command) {
    case slam_command_t::SAVE:
      return save(order.folder);
    case slam_command_t::RESET:
      hear_lasers_anew();
      session_.reset();
      return "RESET: a new map is begun";
    case slam_command_t::SET_POSE:
      hear_lasers_anew();
      session_.set_pose(order.world_from_robot);
      return session_.localizer() != nullptr ? "SET_POSE: tracks from there"
                                             : "SET_POSE: a new map is begun from there";
    case slam_command_t::LOCALIZE: {
      Localizer localizer = session_.localizer_in(load_map_folder(order.folder));
      hear_lasers_anew();
      session_.localize(std::move(localizer));
      return "LOCALIZE " + order.folder.string() + ": looks for itself in " +
             std::to_string(session_.keys().size()) + " keyframes";
    }
    case slam_command_t::PAUSE:
      hear_lasers_anew();
      paused_ = true;
      return "PAUSE: scans are passed by";
    default:  // RESUME: check_order() lets no other through
      hear_lasers_anew();
      paused_ = false;
      return "RESUME: goes on";
  }
}

// Meanwhile the robot may have been carried: its next scan need not look like the last one.
void SlamAdapter::hear_lasers_anew() {
  if (!one_source_) return;
  for (auto& [channel, source] : *one_source_) {
    for (LaserScan& scan : source.rest()) let_wait(std::move(scan));
  }
  one_source_->clear();
}

std::string SlamAdapter::state_line() const {
  if (paused_) return "paused";
  const std::string scans = std::to_string(scan_count_) + " scans, ";
  const PlaceEstimate* estimate = session_.estimate();
  const Localizer* localizer = session_.localizer();
  if (localizer != nullptr && localizer->is_localized()) return scans + "localized";
  if (estimate != nullptr) {
    return scans + (estimate->candidates.empty()
                        ? "not found in the map yet"
                        : std::to_string(estimate->candidates.size()) + " places fit");
  }
  return scans + std::to_string(slam().key_count()) + " kept";
}

AdapterState SlamAdapter::state() const {
  AdapterState state;
  state.map = session_.saved(process::print_options(options_.slam));
  state.motion = motion_;
  state.sensors = sensors_;
  state.waiting = waiting_;
  state.newest_scan = newest_scan_;
  state.last_grid = last_grid_;
  state.scan_count = scan_count_;
  state.live = live_;
  state.odometry_at_scans = odometry_at_scans_;
  state.scans = scans_;
  state.received = drops_.received();
  state.drops = drops_.by_cause();
  return state;
}

void SlamAdapter::restore(AdapterState state) {
  session_.restore(state.map);
  motion_ = std::move(state.motion);
  sensors_ = std::move(state.sensors);
  waiting_ = std::move(state.waiting);
  newest_scan_ = state.newest_scan;
  last_grid_ = state.last_grid;
  scan_count_ = state.scan_count;
  live_ = std::move(state.live);
  odometry_at_scans_ = std::move(state.odometry_at_scans);
  scans_ = std::move(state.scans);
  drops_.restore(state.received, std::move(state.drops));
  paused_ = false;
}

void SlamAdapter::save_checkpoint_now_and_then(Utime utime) {
  const bool mapping = session_.mode() == MappingSession::Mode::mapping || session_.joined();
  if (options_.checkpoint_path.empty() || !mapping) return;
  if (!checkpoint_saved_) checkpoint_saved_ = utime;
  if (std::abs((utime - *checkpoint_saved_).seconds()) < options_.checkpoint_every_s) return;
  checkpoint_saved_ = utime;
  if (!loop_worker_) {
    note_checkpoint(save_quietly(options_.checkpoint_path, state()));
    return;
  }
  // Live no scan waits for a disk; one that is still at work gets the next one later.
  if (checkpoint_.busy()) return;
  note_checkpoint(checkpoint_.take_answer().empty());
  checkpoint_.start([path = options_.checkpoint_path, now = state()]() -> std::string {
    return save_quietly(path, now) ? "" : "not written";
  });
}

void SlamAdapter::note_checkpoint(bool written) {
  if (!written) drops_.count("checkpoint: cannot be written");
}

}  // namespace marco::slam
