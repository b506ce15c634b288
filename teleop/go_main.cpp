#include <cstdio>
#include <optional>
#include <string>
#include <utility>

#include "drivers/transport/wall_clock.hpp"
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
using Next = teleop::GoalDrive::Next;

constexpr double kFindPlaceS = 3.0;  ///< for SLAM_POSE and ODOMETRY to be heard
constexpr double kTakeOrderS = 3.0;  ///< a base says twice a second what it does

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

int64_t order(process::LcmBus& bus, const Ear& ear, const Eigen::Vector2d& goal_m) {
  BaseCommand go;
  go.kind = BaseCommand::Kind::go_to;
  go.point_m = ear.frame.odom_from_map(wall_now()) * goal_m;
  go.id = wall_now().us;
  send(bus, go);
  return go.id;
}

int fail(const std::string& why) {
  std::fprintf(stderr, "marco go: %s\n", why.c_str());
  return process::kExitFailed;
}

int drive(process::LcmBus& bus, const Eigen::Vector2d& goal_m) {
  Ear ear(bus);
  wait_for_frame(bus, ear);
  teleop::GoalDrive drive(goal_m);
  drive.on_ordered(order(bus, ear, goal_m));
  Utime sent = wall_now();
  std::string told_of_guard;
  while (!process::stop_requested()) {
    bus.handle_once(50);
    if (!drive.is_taken() && (wall_now() - sent).seconds() > kTakeOrderS) {
      return fail("no base took the order. Is its driver running, and on this network?");
    }
    const auto status = std::exchange(ear.base, std::nullopt);
    if (!status) continue;
    const std::string guard = BaseNote(status->note).guard;
    if (!guard.empty() && guard != told_of_guard) {
      std::fprintf(stderr, "marco go: the base's obstacle guard: %s\n", guard.c_str());
    }
    told_of_guard = guard;
    const double distance_m = ear.frame.distance_m(goal_m, wall_now());
    switch (drive.on_status(*status, distance_m)) {
      case Next::wait:
        break;
      case Next::again:
        drive.on_ordered(order(bus, ear, goal_m));
        sent = wall_now();
        break;
      case Next::there:
        std::printf("there: %.2f m from the goal\n", distance_m);
        return process::kExitDone;
      case Next::ended: {
        char left[64];
        std::snprintf(left, sizeof left, "ended %.2f m from the goal: ", distance_m);
        return fail(left + status->note);
      }
    }
  }
  send(bus, {});  // a stop
  fail("stopped");
  return process::kExitSignal + process::stopped_by();
}

}  // namespace

int main(int argc, char** argv) {
  return process::run_main("marco-go", [&] {
    process::CommandLine app(
        "Drives the robot to a point of the map: it turns, and drives straight on. The base's own "
        "guard stops it before obstacles, and nothing plans a way round them. Ctrl-C stops it.");
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
