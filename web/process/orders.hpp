#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "common/pose2.hpp"
#include "lcm_tools/process/bus.hpp"
#include "lcm_tools/process/drop_counter.hpp"
#include "lcm_tools/process/emergency_stop_sender.hpp"
#include "teleop/goal_drive.hpp"
#include "teleop/map_frame.hpp"
#include "web/hub.hpp"
#include "web/process/procman_channels.hpp"
#include "web/process/slam_calls.hpp"
#include "web/process/source.hpp"
#include "web/steering.hpp"

namespace marco::web {

/// The services slam, go, head, stop, procman, record and keep, what clients publish (/cmd_vel
/// /goal_pose /initialpose), page/stop and page/goal. Orders need the right to steer; a stop is
/// anybody's, its release is not. One thread.
class Orders {
 public:
  /// All outlive it. A recording takes no orders.
  Orders(Hub& hub,
         const Source& source,
         ProcmanChannels& procman,
         const teleop::MapFrame& map,
         const SteeringOptions& options);

  /// Call often. @param now_us  monotonic
  void step(int64_t now_us);
  void send_known(Hub::ClientId client, uint32_t channel);
  void forget(Hub::ClientId client);

 private:
  /// @returns what to answer at once; nothing: it is answered later.
  /// @throws std::invalid_argument  that is the answer.
  using Act = std::function<std::optional<std::string>(const Hub::Call&, std::string_view json)>;
  /// To who may steer.
  void serve(const std::string& name, const std::string& request_schema, Act act);
  void serve_anybody(const std::string& name, const std::string& request_schema, Act act);
  void add_services();
  std::string go(const Hub::Call& call, std::string_view json);
  std::string stop(const Hub::Call& call, std::string_view json);
  void take_published(const Hub::Published& message);
  void begin_goal(Hub::ClientId client, const FramedPose& pose);
  void step_goal(int64_t now_us);
  /// Stops the robot. @param why  "" = it is there
  void end_goal(const std::string& why);
  /// Leaves the robot to who drives it now.
  void drop_goal(const std::string& why);
  Eigen::Vector2d in_robot(const FramedPose& place, Utime now) const;
  void tell_goal(bool active, const std::string& text);
  void send_stop(const process::EmergencyStopSender::Message& stop);
  void tell_stop();
  std::string stop_json() const;
  void answer(const Hub::Call& call,
              bool ok,
              const std::string& text,
              const std::string& path = "");

  Hub& hub_;
  process::DropCounter& drops_;
  process::Bus* bus_;
  ProcmanChannels& procman_;
  const teleop::MapFrame& map_;
  Steering steering_;
  teleop::GoalDrive::Speeds speeds_;
  SlamCalls slam_;
  /// It lasts no longer than its client gives a sign of life.
  struct Goal {
    Hub::ClientId client = 0;
    FramedPose pose;
    teleop::GoalDrive drive;
    int64_t sent_us = 0, pinged_us = 0;
  };
  std::optional<Goal> goal_;
  std::string goal_told_ = R"({"active":false})";
  uint32_t stop_channel_, goal_channel_;
  process::EmergencyStopSender emergency_{"marco page"};
  std::string stop_told_;
  int64_t stop_sent_us_ = 0;
};

}  // namespace marco::web
