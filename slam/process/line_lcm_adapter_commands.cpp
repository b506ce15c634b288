// What a LineLcmAdapter does beside scans: orders, and its own survival.
#include "common/check.hpp"
#include "common/files/inside_folder.hpp"
#include "marco/slam_command_t.hpp"
#include "slam/process/line_lcm_adapter.hpp"

namespace marco::slam {

void LineLcmAdapter::save(const std::string& path) {
  save_checkpoint(
      path, {last_scan_.value_or(Utime{}), odom_at_last_scan_, map_revision_, mapper_.store()});
}

void LineLcmAdapter::try_to_save(const std::string& path) {
  try {
    save(path);
  } catch (const std::runtime_error& full_disk) {
    drops_.count(full_disk.what());
  }
}

void LineLcmAdapter::reset(const Pose2& world_from_robot) {
  mapper_ = LineMapper(options_.mapper, world_from_robot);
  waiting_.clear();
}

void LineLcmAdapter::on_command(int8_t command, const std::string& folder, const Pose2& pose) {
  // Meanwhile the robot may have been carried: its next scan need not look like the last one.
  if (command != slam_command_t::SAVE) hear_lasers_anew();
  switch (command) {
    case slam_command_t::SAVE:
      // Anybody on the network can say this.
      require(!options_.save_folder.empty(), "slam_command_t: SAVE without save_folder");
      return try_to_save(files::inside_folder(
          options_.save_folder, std::filesystem::path(folder) / "line_slam.checkpoint"));
    case slam_command_t::RESET:
      return reset({});
    case slam_command_t::SET_POSE:
      require(is_finite(pose), "slam_command_t: pose is not finite");
      return reset(pose);
    case slam_command_t::PAUSE:
      paused_ = true;
      return;
    case slam_command_t::RESUME:
      paused_ = false;
      return;
    default:
      drops_.count("slam_command_t: not a command of the line SLAM");
  }
}

}  // namespace marco::slam
