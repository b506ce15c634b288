// What a LineLcmAdapter does beside scans: orders, and its own survival.
#include "slam/process/line_lcm_adapter.hpp"

namespace marco::slam {

LineCheckpoint LineLcmAdapter::checkpoint() {
  return {last_scan_.value_or(Utime{}), odom_at_last_scan_, map_revision_, mapper_.store()};
}

void LineLcmAdapter::try_to_save(const std::string& path) {
  try {
    save_checkpoint(path, checkpoint());
  } catch (const std::runtime_error& full_disk) {
    drops_.count(full_disk.what());
  }
}

void LineLcmAdapter::reset(const Pose2& world_from_robot) {
  mapper_ = LineMapper(options_.mapper, world_from_robot);
  waiting_.clear();
}

std::string LineLcmAdapter::obey(const SlamOrder& order) {
  const auto path = order.folder / "line_slam.checkpoint";
  switch (order.command) {
    case slam_command_t::SAVE:
      return orders_.write([path, now = checkpoint()] {
        save_checkpoint(path.string(), now);
        return "SAVE " + path.string() + ": saved";
      });
    case slam_command_t::LOCALIZE:
      throw std::invalid_argument("LOCALIZE: the line SLAM looks for itself in no map");
    case slam_command_t::RESET:
      hear_lasers_anew();
      reset({});
      return "RESET: a new map is begun";
    case slam_command_t::SET_POSE:
      hear_lasers_anew();
      reset(order.world_from_robot);
      return "SET_POSE: a new map is begun from there";
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

}  // namespace marco::slam
