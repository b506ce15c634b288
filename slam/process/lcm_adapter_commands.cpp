// What a SlamAdapter does beside scans: orders, and its own survival.
#include <chrono>
#include <cmath>
#include <utility>

#include "common/process/config.hpp"
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

std::string SlamAdapter::obey(const slam_command_t& command) {
  switch (command.command) {
    case slam_command_t::SAVE: {
      const auto folder = folder_below(options_.maps_folder, command.folder);
      require(session_.mode() != MappingSession::Mode::localizing,
              "SAVE: a map that is localized in is not changed");
      save_map_folder(folder, session_, process::print_options(options_.slam));
      return "SAVE " + folder.string() + ": saved " + std::to_string(slam().key_count()) +
             " key scans";
    }
    case slam_command_t::RESET:
      session_.reset();
      return "RESET: maps anew";
    case slam_command_t::SET_POSE: {
      const Pose2 pose{command.x_m, command.y_m, normalize_angle(command.theta_rad)};
      require(is_finite(pose), "SET_POSE: pose is not finite");
      session_.set_pose(pose);
      return session_.localizer() != nullptr ? "SET_POSE: tracks from there"
                                             : "SET_POSE: maps anew from there";
    }
    case slam_command_t::LOCALIZE: {
      const auto folder = folder_below(options_.maps_folder, command.folder);
      session_.localize(load_map_folder(folder));
      return "LOCALIZE " + folder.string() + ": looks for itself in " +
             std::to_string(session_.keys().size()) + " key scans";
    }
    case slam_command_t::PAUSE:
      paused_ = true;
      return "PAUSE: scans are passed by";
    case slam_command_t::RESUME:
      paused_ = false;
      return "RESUME: goes on";
    default:
      throw std::invalid_argument("slam_command_t: not a command");
  }
}

void SlamAdapter::hear_lasers_anew() {
  if (!one_source_) return;
  for (auto& [channel, source] : *one_source_) {
    for (LaserScan& scan : source.rest()) let_wait(std::move(scan));
  }
  one_source_->clear();
}

void SlamAdapter::on_command(const slam_command_t& command) {
  try {
    // Meanwhile the robot may have been carried: its next scan need not look like the last one.
    if (command.command != slam_command_t::SAVE) hear_lasers_anew();
    answer_ = obey(command);
  } catch (const std::invalid_argument& refused) {
    answer_ = std::string("refused: ") + refused.what();
    drops_.count("slam_command_t: refused");
  } catch (const std::exception& failed) {  // a full disk must not end the mapping
    answer_ = std::string("failed: ") + failed.what();
    drops_.count("slam_command_t: failed");
  }
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
  if (checkpoint_.valid() &&
      checkpoint_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) {
    return;
  }
  if (checkpoint_.valid()) note_checkpoint(checkpoint_.get());
  checkpoint_ = std::async(std::launch::async, [path = options_.checkpoint_path, now = state()] {
    yield_to_scans();
    return save_quietly(path, now);
  });
}

void SlamAdapter::note_checkpoint(bool written) {
  if (!written) drops_.count("checkpoint: cannot be written");
}

}  // namespace marco::slam
