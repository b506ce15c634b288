#include <cstdio>
#include <optional>
#include <string>
#include <utility>

#include "drivers/transport/wall_clock.hpp"
#include "lcm_tools/base/format.hpp"
#include "lcm_tools/base/printable.hpp"
#include "lcm_tools/process/arguments.hpp"
#include "lcm_tools/process/exit_code.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "lcm_tools/process/stop_signal.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "lcmtypes/convert_robot.hpp"
#include "lcmtypes/finite_pose.hpp"
#include "marco/slam_pose_t.hpp"
#include "teleop/goal_drive.hpp"
#include "teleop/map_frame.hpp"

namespace {

using namespace marco;  // NOLINT(google-build-using-namespace): a main has no other names
using drivers::wall_now;

constexpr double kFindPlaceS = 3.0;  ///< for SLAM_POSE and ODOMETRY to arrive

/// What the network says: where the robot is, and what the base makes of the order.
struct Ear {
  process::DropCounter drops;
  teleop::MapFrame frame;
  std::optional<BaseStatus> base;

  explicit Ear(process::LcmBus& bus) {
    bus.subscribe<odometry_t>(channels::kOdometry, drops, [this](const auto& message, const auto&) {
      frame.on_odometry(from_message(message));
    });
    bus.subscribe<slam_pose_t>(
        channels::kSlamPose, drops, [this](const slam_pose_t& message, const auto&) {
          std::optional<Pose2> pose;
          if (message.status != slam_pose_t::STATUS_LOST) {
            pose = finite_pose(message.x_m, message.y_m, message.theta_rad,
                               "slam_pose_t: the pose is not finite or too far away");
          }
          frame.on_slam_pose(Utime::from_us(message.utime), pose, wall_now());
        });
    bus.subscribe<base_status_t>(
        channels::kBaseStatus, drops,
        [this](const auto& message, const auto&) { base = from_message(message); });
  }
};

void send(process::LcmBus& bus, BaseCommand command) {
  command.utime = wall_now();
  bus.publish(channels::kBaseCommand, to_message(command));
}

/// @throws std::invalid_argument that says what is missing.
void wait_for_frame(process::LcmBus& bus, const Ear& ear) {
  const Utime begin = wall_now();
  while (true) {
    bus.handle_once(50);
    try {
      ear.frame.odom_from_map(wall_now());
      return;
    } catch (const std::invalid_argument&) {
      if (process::stop_requested() || (wall_now() - begin).seconds() > kFindPlaceS) throw;
    }
  }
}

int fail(const std::string& why) {
  print(stderr, "marco go: %s\n", why.c_str());
  return process::kExitFailed;
}

// What the base's guard lacks, each time that it is something else. @param said  the last time
void say_of_guard(const BaseStatus& status, std::string& said) {
  const std::string guard = BaseNote(status.note).guard;
  if (!guard.empty() && guard != said) {
    print(stderr, "marco go: the base's obstacle guard: %s\n", guard.c_str());
  }
  said = guard;
}

int drive(process::LcmBus& bus, const Eigen::Vector2d& goal_m) {
  Ear ear(bus);
  wait_for_frame(bus, ear);
  teleop::GoalDrive drive(wall_now().us, {}, wall_now());
  Eigen::Vector2d left_m;
  Utime next = wall_now();
  std::string guard;
  while (!process::stop_requested()) {
    const Utime now = wall_now();
    if (now < next) {
      bus.handle_once(static_cast<int>((next - now).us / 1000) + 1);
      if (const auto status = std::exchange(ear.base, std::nullopt)) {
        drive.on_status(*status);
        say_of_guard(*status, guard);
      }
      continue;
    }
    next = now + Duration::from_seconds(teleop::GoalDrive::kSendEveryS);
    left_m = ear.frame.in_robot(ear.frame.odom_from_map(now) * goal_m, now);
    const auto order = drive.next(left_m, now);
    if (!order) break;
    send(bus, *order);
  }
  if (!drive.is_taken_over()) send(bus, {});  // a stop
  if (process::stop_requested()) {
    fail("stopped");
    return process::kExitSignal + process::stopped_by();
  }
  const std::string left = format("%.2f m from the goal", left_m.norm());
  if (!drive.why_ended().empty()) return fail("ended " + left + ": " + drive.why_ended());
  print(stdout, "there: %s\n", left.c_str());
  return process::kExitDone;
}

}  // namespace

int main(int argc, char** argv) {
  return process::run_main("marco-go", [&] {
    process::CommandLine app(
        "Drives the robot to a point of the map: it turns, then drives straight. The base's "
        "obstacle guard stops it before obstacles; there is no path planning. Ctrl-C stops it.");
    std::string lcm_url;
    Eigen::Vector2d goal_m = Eigen::Vector2d::Zero();
    app.add_option("X", goal_m.x(), "[m] in the map's frame").required();
    app.add_option("Y", goal_m.y(), "[m]").required();
    process::add_lcm_url(app, lcm_url);
    if (const auto code = app.parse(argc, argv)) return *code;
    process::catch_stop_signals();
    process::LcmBus bus(lcm_url);
    return drive(bus, goal_m);
  });
}
