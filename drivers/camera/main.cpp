#include <spdlog/spdlog.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <thread>
#include <utility>

#include "common/pose3.hpp"
#include "drivers/camera/message.hpp"
#include "drivers/camera/source.hpp"
#include "drivers/process/driver_main.hpp"
#include "drivers/transport/port_advice.hpp"
#include "drivers/transport/wall_clock.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "lcm_tools/process/status_publisher.hpp"
#include "lcm_tools/process/stop_signal.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"

namespace {

using namespace marco;  // NOLINT(google-build-using-namespace): a main has no other names
using drivers::camera::Picture;

struct Options {
  std::string device = "/dev/video0";  ///< or a folder of pictures, or a film
  std::string channel = channels::kCamera;
  std::string mount = "robot";  ///< or "pantilt"
  std::vector<double> position_m{0.1, 0.0, 0.4};
  std::vector<double> roll_pitch_yaw_deg{0.0, 0.0, 0.0};
  double focal_length_px = 0.0;  ///< 0 = not known
  drivers::camera::SourceOptions source;

  template <class Visitor>
  void visit(Visitor& v) {
    v("device", device);
    v("channel", channel);
    v("mount", mount);
    v("position_m", position_m);
    v("roll_pitch_yaw_deg", roll_pitch_yaw_deg);
    v("focal_length_px", focal_length_px, kNotNegative);
    v("width_px", source.width_px, Limits{16, 8192});
    v("height_px", source.height_px, Limits{16, 8192});
    v("rate_hz", source.rate_hz, Limits{0.01, 120.0});
    v("jpeg_quality", source.jpeg_quality, Limits{1, 100});
  }

  SensorInfo info() const {
    require(mount == "robot" || mount == "pantilt",
            "mount '" + mount + "': expected robot or pantilt");
    require(position_m.size() == 3 && roll_pitch_yaw_deg.size() == 3,
            "position_m, roll_pitch_yaw_deg: expected three numbers each");
    SensorInfo info;
    info.channel = channel;
    info.mount = mount == "robot" ? SensorInfo::Mount::robot : SensorInfo::Mount::pantilt;
    info.parent_from_sensor =
        make_pose3(Eigen::Vector3d(position_m.data()), deg_to_rad(roll_pitch_yaw_deg[0]),
                   deg_to_rad(roll_pitch_yaw_deg[1]), deg_to_rad(roll_pitch_yaw_deg[2]));
    info.focal_length_px = focal_length_px;
    return info;
  }
};

/// Sleeps in short steps, so that a stop is noticed. @returns false once it is to stop.
bool pause_until(Utime when) {
  while (!process::stop_requested() && drivers::wall_now() < when) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return !process::stop_requested();
}

/// Why `device` could not be opened, and what to do.
std::string trouble_of(const std::string& device) {
  const std::string path = drivers::camera::path_of(device);
  if (::access(path.c_str(), R_OK) != 0) {
    return drivers::why_not_open(path, errno, drivers::DeviceKind::camera);
  }
  if (std::filesystem::is_directory(path)) return path + ": no picture in this folder";
  const std::string holder = drivers::holder_of(path);
  return path + (holder.empty() ? ": neither a camera nor a film" : ": held by " + holder);
}

/// Says what changed.
void tell(std::string& told, const std::string& trouble, const std::string& device) {
  if (std::exchange(told, trouble) == trouble) return;
  if (trouble.empty()) spdlog::info("{} is open", device);
  if (!trouble.empty()) spdlog::warn("{}", trouble);
}

int run(const process::CommonArguments& arguments, const Options& options) {
  process::start_logging("marco-camera", arguments.log_level);
  process::catch_stop_signals();
  process::LcmBus bus(arguments.lcm_url);
  bus.keep_going_without_network();
  process::DropCounter drops;
  process::StatusPublisher status(bus, "marco-camera", drops);
  SensorInfo info = options.info();
  const Duration period = Duration::from_seconds(1.0 / options.source.rate_hz);
  std::unique_ptr<drivers::camera::PictureSource> source;
  Utime next_info, next_picture = drivers::wall_now();
  std::string told = "nothing yet", trouble;  // trouble: until a picture comes
  bool gave_pictures = false;
  while (!process::stop_requested()) {
    const Utime now = drivers::wall_now();
    if (now >= next_info) {
      next_info = now + Duration::from_seconds(1.0);
      info.utime = now;
      bus.publish(channels::kSensorInfo, marco::to_message(info));
    }
    if (!source) {
      source = open_source(options.device, options.source);
      gave_pictures = false;
      if (!source) trouble = process::kNoDevice + (": " + trouble_of(options.device));
    }
    tell(told, trouble, options.device);
    status.tick(trouble.empty() ? options.device + " is open" : trouble);
    if (!source) {
      pause_until(now + Duration::from_seconds(1.0));
      continue;
    }
    if (!source->keeps_its_own_time() && !pause_until(next_picture)) break;
    const auto picture = source->next();
    if (!picture) {
      const bool film_ended = gave_pictures && !source->keeps_its_own_time();
      source.reset();
      if (film_ended) continue;
      trouble =
          process::kNoDevice + (" answers: " + options.device) + " is open, but sends no pictures";
      pause_until(now + Duration::from_seconds(1.0));
      continue;
    }
    trouble.clear();
    gave_pictures = true;
    const Utime taken = drivers::wall_now();
    if (taken < next_picture) continue;  // a camera that is faster than wanted
    next_picture = std::max(next_picture + period, taken - period);
    bus.publish(options.channel, drivers::camera::to_message(*picture, taken));
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  return drivers::driver_main<Options>(
      argc, argv,
      {"marco-camera",
       "Driver of a camera (V4L2); or a folder of pictures, or a film, in its place", run});
}
