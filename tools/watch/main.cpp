#include <spdlog/spdlog.h>

#include <cstdio>

#include "common/diagnosis/process/silence_watch.hpp"
#include "drivers/transport/wall_clock.hpp"
#include "lcm_tools/process/arguments.hpp"
#include "lcm_tools/process/config.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "lcm_tools/process/status_publisher.hpp"
#include "lcm_tools/process/stop_signal.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "lcmtypes/finite_pose.hpp"
#include "marco/map_request_t.hpp"
#include "marco/slam_pose_t.hpp"
#include "marco/trajectory_t.hpp"
#include "tools/watch/live_map.hpp"
#include "viewer/image_io.hpp"
#include "viewer/map_picture.hpp"

namespace {

using namespace marco;  // NOLINT(google-build-using-namespace): a main has no other names

struct Options {
  double period_s = 1.0;  ///< of the picture
  viewer::MapPictureOptions drawing{900.0};

  template <class Visitor>
  void visit(Visitor& v) {
    v("period_s", period_s, Limits{0.05, 3600.0});
    v("drawing", drawing);
  }
};

struct Arguments {
  process::CommonArguments common;
  std::string picture;
};

void listen(process::LcmBus& bus, process::DropCounter& drops, watch::LiveMap& map) {
  bus.subscribe<grid_map_t>(channels::kGridMap, drops,
                            [&map](const grid_map_t& message, const auto&) {
                              map.add_tile(from_message(message), message.revision);
                            });
  bus.subscribe<slam_pose_t>(
      channels::kSlamPose, drops, [&map](const slam_pose_t& message, const auto&) {
        map.add_pose(Utime::from_us(message.utime),
                     finite_pose(message.x_m, message.y_m, message.theta_rad,
                                 "slam_pose_t: the pose is not finite or too far away"));
      });
  bus.subscribe<trajectory_t>(channels::kTrajectory, drops,
                              [&map](const trajectory_t& message, const auto&) {
                                map.set_trajectory(from_message(message));
                              });
}

int run(const Arguments& arguments) {
  const auto options = process::load_options<Options>(arguments.common.config_path);
  if (arguments.common.print_config) {
    std::fputs(process::print_options(options, arguments.common.printed()).c_str(), stdout);
    return 0;
  }
  process::start_logging("marco-watch", arguments.common.log_level);
  process::catch_stop_signals();
  process::LcmBus bus(arguments.common.lcm_url);
  process::DropCounter drops;
  process::StatusPublisher status(bus, "marco-watch", drops);
  watch::LiveMap map;
  listen(bus, drops, map);
  diagnosis::SilenceWatch silence(bus, {"marco-watch",
                                        arguments.common.lcm_url,
                                        {diagnosis::expect(diagnosis::Awaited::map)},
                                        &drops});
  map_request_t request;
  request.utime = drivers::wall_now().us;
  bus.publish(channels::kMapRequest, request);  // the map so far
  int64_t pictures = 0;
  Utime next = drivers::wall_now();
  while (!process::stop_requested()) {
    bus.handle_once(50);
    while (bus.handle_once(0)) {
    }
    const Utime now = drivers::wall_now();
    diagnosis::log_note(silence.step());
    status.tick(silence.state(std::to_string(pictures) + " pictures, " +
                              std::to_string(map.poses()) + " poses"));
    if (now < next) continue;
    next = std::max(next + Duration::from_seconds(options.period_s), now);
    const auto scene = map.scene();
    if (!scene) continue;
    const viewer::MapPicture drawn = viewer::draw_map(*scene, options.drawing);
    viewer::write_png(drawn.picture, arguments.picture);
    ++pictures;
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  return process::run_main("marco-watch", [&] {
    CLI::App app("Shows the map as it grows, in a picture file that is rewritten every second");
    Arguments arguments;
    process::add_common_arguments(app, arguments.common);
    app.add_option("--picture", arguments.picture, "PNG to rewrite (atomically)")->required();
    if (const auto code = process::parse_arguments(app, argc, argv)) return *code;
    return run(arguments);
  });
}
