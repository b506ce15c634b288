#include "slam/process/slam_order.hpp"

#include <utility>

#include "common/order_age.hpp"
#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/inside_folder.hpp"
#include "lcm_tools/process/wall_clock.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/finite_pose.hpp"
#include "lcmtypes/stamp.hpp"

namespace marco::slam {
namespace {

std::filesystem::path folder_of(const slam_command_t& command,
                                const std::filesystem::path& maps_folder,
                                const std::string& name) {
  // Anybody on the network can say this.
  require(!maps_folder.empty(), name + ": no folder for maps is configured");
  require(!command.folder.empty() && !std::filesystem::path(command.folder).is_absolute() &&
              files::stays_inside(command.folder),
          name + ": the folder must be below " + maps_folder.string());
  return maps_folder / std::filesystem::path(command.folder).lexically_normal();
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
    case slam_command_t::EXTEND:
      order.folder = folder_of(command, maps_folder, "EXTEND");
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
                      Utime came,
                      const std::filesystem::path& maps_folder,
                      const std::function<std::string(const SlamOrder&)>& execute) {
  taking_ = {};
  taking_.command = command.command;
  taking_.command_utime = command.utime;
  answer(taking_, [&] {
    const std::string stale = why_stale(stamp_of(command.utime), came);
    require(stale.empty(), stale);
    const SlamOrder order = check_order(command, maps_folder);
    if (!order.folder.empty()) taking_.path = std::filesystem::absolute(order.folder).string();
    return execute(order);
  });
}

std::string SlamOrders::write(std::function<std::string()> job) {
  require(!writing_.busy(), "SAVE: the previous map is still being written");
  if (!in_background_) return job();
  settle_writing(false);
  written_ = taking_;
  writing_.start(std::move(job));
  return "";
}

std::optional<slam_reply_t> SlamOrders::take_reply() {
  settle_writing(false);
  if (answers_.empty()) return std::nullopt;
  slam_reply_t oldest = std::move(answers_.front());
  answers_.pop_front();
  return oldest;
}

void SlamOrders::wait() { settle_writing(true); }

void SlamOrders::settle_writing(bool wait) {
  answer(written_, [&] { return wait ? writing_.wait() : writing_.take_reply(); });
}

void SlamOrders::answer(const slam_reply_t& order, const std::function<std::string()>& act) {
  slam_reply_t reply = {};
  try {
    std::string text = act();
    reply = order;  // its path is known by now
    reply.ok = 1;
    reply.text = std::move(text);
  } catch (const std::invalid_argument& refused) {
    reply.text = std::string("refused: ") + refused.what();
    drops_.count("slam_command_t: refused");
  } catch (const std::exception& failed) {  // a full disk must not end the mapping
    reply.text = std::string("failed: ") + failed.what();
    drops_.count("slam_command_t: failed");
  }
  if (reply.text.empty()) return;
  reply.command = order.command;
  reply.command_utime = order.command_utime;
  constexpr std::size_t kMostAnswers = 100;  // nobody may be listening
  if (answers_.size() >= kMostAnswers) answers_.pop_front();
  answers_.push_back(std::move(reply));
}

std::string publish_reply(process::Bus& bus,
                          const char* process,
                          std::optional<slam_reply_t> reply) {
  if (!reply) return "";
  reply->utime = process::wall_clock_us();
  reply->process = process;
  bus.publish(channels::kSlamReply, *reply);
  return reply->text;
}

}  // namespace marco::slam
