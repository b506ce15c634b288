#include <spdlog/spdlog.h>

#include "drivers/transport/wall_clock.hpp"
#include "lcm_tools/process/arguments.hpp"
#include "lcm_tools/process/config.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "lcm_tools/process/progress.hpp"
#include "lcm_tools/process/status_publisher.hpp"
#include "lcm_tools/process/stop_signal.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "lcmtypes/convert_robot.hpp"
#include "lcmtypes/stamp.hpp"
#include "live/diagnosis/silence_watch.hpp"
#include "marco/slam_pose_t.hpp"
#include "teleop/terminal.hpp"
#include "teleop/tour_runner.hpp"

namespace {

using namespace marco;  // NOLINT(google-build-using-namespace): a main has no other names
using teleop::TourRunner;

struct Arguments {
  process::CommonArguments common;
  std::string tour;
  std::string pose = "odometry";
};

/// What the network says to the runner, and back.
class TourAdapter {
 public:
  TourAdapter(process::LcmBus& bus,
              process::DropCounter& drops,
              TourRunner& runner,
              const Pose2& start,
              const std::string& pose)
      : bus_(bus), runner_(runner) {
    bus.subscribe<base_status_t>(
        channels::kBaseStatus, drops, [this](const auto& message, const auto&) {
          runner_.on_base_status(from_message(message), drivers::wall_now());
        });
    bus.subscribe<pantilt_state_t>(channels::kPanTiltState, drops,
                                   [this](const auto& message, const auto&) {
                                     runner_.on_pantilt(from_message(message), drivers::wall_now());
                                   });
    bus.subscribe_raw(channels::kLidar,
                      [this](const process::RawMessage&) { runner_.on_scan(drivers::wall_now()); });
    // Odometry and SLAM begin where the robot stood; the tour says where that is.
    if (pose == "odometry") {
      bus.subscribe<odometry_t>(
          channels::kOdometry, drops, [this, start](const auto& message, const auto&) {
            const OdometrySample sample = from_message(message);
            runner_.on_pose(start * since_first(sample.odom_from_robot), sample.utime);
          });
    } else if (pose == "slam") {
      bus.subscribe<slam_pose_t>(
          channels::kSlamPose, drops, [this, start](const slam_pose_t& message, const auto&) {
            runner_.on_pose(start * Pose2{message.x_m, message.y_m, message.theta_rad},
                            stamp_of(message.utime));
          });
    } else {
      bus.subscribe<pose2_t>(channels::kTruePose, drops, [this](const auto& message, const auto&) {
        const TruePose truth = from_message(message);
        runner_.on_pose(truth.world_from_robot, truth.utime);
      });
    }
  }

  void send(const TourRunner::Orders& orders) {
    for (const BaseCommand& command : orders.base) {
      bus_.publish(channels::kBaseCommand, to_message(command));
    }
    for (const PanTiltCommand& command : orders.pantilt) {
      bus_.publish(channels::kPanTiltCommand, to_message(command));
    }
  }

 private:
  Pose2 since_first(const Pose2& odom_from_robot) {
    if (!odom_from_start_) odom_from_start_ = odom_from_robot;
    return between(*odom_from_start_, odom_from_robot);
  }

  process::LcmBus& bus_;
  TourRunner& runner_;
  std::optional<Pose2> odom_from_start_;
};

// A tour waits for the pose it goes by, not for less.
diagnosis::Expectation pose_expected(const std::string& pose) {
  if (pose == "slam") return diagnosis::expect(diagnosis::Awaited::slam_poses);
  diagnosis::Expectation expected = diagnosis::expect(diagnosis::Awaited::odometry);
  expected.without.clear();
  if (pose == "odometry") return expected;
  expected.what = "the true pose";
  expected.channels = expected.pattern = channels::kTruePose;
  expected.types = {"marco.pose2_t"};
  expected.meaning = "true_pose";
  expected.remedy = "The simulator sends it.";
  return expected;
}

int run(const Arguments& arguments) {
  const auto options = process::load_options<teleop::TourOptions>(arguments.common.config_path);
  if (process::prints_config(arguments.common, options)) return 0;
  const auto tour = process::load_options<sim::Tour>(arguments.tour);
  require(tour.start_m.size() == 2, "start_m: expected two numbers, x and y");
  process::start_logging("marco-tour", arguments.common.log_level);
  process::catch_stop_signals();
  process::LcmBus bus(arguments.common.lcm_url);
  process::DropCounter drops;
  TourRunner runner(tour, options);
  TourAdapter adapter(bus, drops, runner,
                      {tour.start_m[0], tour.start_m[1], deg_to_rad(tour.start_heading_deg)},
                      arguments.pose);
  process::StatusPublisher status(bus, "marco-tour", drops);
  diagnosis::SilenceWatch silence(
      bus, {"marco-tour",
            arguments.common.lcm_url,
            {diagnosis::expect(diagnosis::Awaited::base), pose_expected(arguments.pose)},
            &drops});
  process::Progress progress("touring");
  teleop::Keyboard keyboard;
  std::string told;
  bool stopped = false;
  try {
    while (runner.outcome() == TourRunner::Outcome::running && !stopped) {
      bus.handle_once(20);
      stopped = process::stop_requested() || keyboard.key().has_value();
      adapter.send(runner.step(drivers::wall_now()));
      progress.update(runner.progress());
      diagnosis::log_note(silence.step());
      status.tick(silence.state(runner.state()));
      if (runner.state() != told) {
        told = runner.state();
        spdlog::info("{:3.0f} % {}", 100.0 * runner.progress(), told);
      }
    }
  } catch (...) {
    adapter.send(runner.stop(drivers::wall_now()));
    throw;
  }
  if (runner.outcome() == TourRunner::Outcome::done) return 0;
  adapter.send(runner.stop(drivers::wall_now()));
  spdlog::warn("stopped: {}", stopped ? "by the user" : runner.state());
  if (runner.outcome() == TourRunner::Outcome::lost) diagnosis::log_note(silence.last_word());
  return stopped ? 130 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  return process::run_main("marco-tour", [&] {
    process::CommandLine app(
        "Drives a tour: moves, sweeps of the pan-tilt, waits. Any key stops it at once");
    Arguments arguments;
    process::add_common_arguments(app, arguments.common);
    app.add_option("tour", arguments.tour, "e.g. config/tours/lab.toml").required().existing_file();
    app.add_option("--pose", arguments.pose, "pose to drive by: odometry, slam or true")
        .one_of({"odometry", "slam", "true"})
        .shows_default();
    if (const auto code = app.parse(argc, argv)) return *code;
    return run(arguments);
  });
}
