#include "slam/process/slam_order.hpp"

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/inside_folder.hpp"
#include "lcmtypes/finite_pose.hpp"

namespace marco::slam {
namespace {

std::filesystem::path folder_of(const slam_command_t& command,
                                const std::filesystem::path& maps_folder,
                                const std::string& name) {
  // Anybody on the network can say this.
  require(!maps_folder.empty(), name + ": no folder for maps is configured");
  require(!command.folder.empty() && !std::filesystem::path(command.folder).is_absolute() &&
              files::stays_inside(command.folder),
          name + ": the folder must lie below " + maps_folder.string());
  return files::inside_folder(maps_folder, command.folder);
}

}  // namespace

SlamOrder check_order(const slam_command_t& command, const std::filesystem::path& maps_folder) {
  SlamOrder order{command.command, {}, {}};
  switch (command.command) {
    case slam_command_t::SAVE:
      order.folder = folder_of(command, maps_folder, "SAVE");
      return order;
    case slam_command_t::LOCALIZE:
      order.folder = folder_of(command, maps_folder, "LOCALIZE");
      return order;
    case slam_command_t::SET_POSE:
      order.world_from_robot =
          finite_pose(command.x_m, command.y_m, command.theta_rad,
                      "SET_POSE: the pose must be finite and nearer than 100 km");
      return order;
    case slam_command_t::RESET:
    case slam_command_t::PAUSE:
    case slam_command_t::RESUME:
      return order;
    default:
      throw std::invalid_argument("slam_command_t: " + std::to_string(command.command) +
                                  " is not a command");
  }
}

void SlamOrders::take(const slam_command_t& command,
                      const std::filesystem::path& maps_folder,
                      const std::function<std::string(const SlamOrder&)>& execute) {
  answer([&] { return execute(check_order(command, maps_folder)); });
}

std::string SlamOrders::write(std::function<std::string()> job) {
  require(!writing_.busy(), "SAVE: the map before is still being written");
  if (!in_background_) return job();
  answer([this] { return writing_.take_reply(); });
  writing_.start(std::move(job));
  return "";
}

std::string SlamOrders::take_reply() {
  answer([this] { return writing_.take_reply(); });
  if (answers_.empty()) return "";
  std::string oldest = std::move(answers_.front());
  answers_.pop_front();
  return oldest;
}

void SlamOrders::wait() {
  answer([this] { return writing_.wait(); });
}

void SlamOrders::answer(const std::function<std::string()>& act) {
  std::string reply;
  try {
    reply = act();
  } catch (const std::invalid_argument& refused) {
    reply = std::string("refused: ") + refused.what();
    drops_.count("slam_command_t: refused");
  } catch (const std::exception& failed) {  // a full disk must not end the mapping
    reply = std::string("failed: ") + failed.what();
    drops_.count("slam_command_t: failed");
  }
  if (reply.empty()) return;
  constexpr std::size_t kMostAnswers = 100;  // nobody may be listening
  if (answers_.size() >= kMostAnswers) answers_.pop_front();
  answers_.push_back(std::move(reply));
}

}  // namespace marco::slam
