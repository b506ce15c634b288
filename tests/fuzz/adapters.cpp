// The processes that compute, fed with messages that contradict each other and common sense.
#include <cmath>
#include <cstring>
#include <limits>
#include <span>

#include "common/byte_archive.hpp"
#include "lcm_tools/process/batch_bus.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "mapping3d/process/mapping3d_adapter.hpp"
#include "marco/slam_command_t.hpp"
#include "marco/slam_pose_t.hpp"
#include "slam/process/checkpoint.hpp"
#include "slam/process/line_checkpoint.hpp"
#include "slam/process/line_slam_adapter.hpp"
#include "slam/process/slam_adapter.hpp"
#include "tests/fuzz/target.hpp"

namespace marco::fuzz {
namespace {

constexpr int kMessages = 40;

/// Mostly sensible numbers, now and then one that no robot says.
double number(Input& input) {
  constexpr double kOdd[] = {0.0,    -0.0, 1e-300, 1e300,     -1e300,
                             1e18,   1e9,  -1e9,   HUGE_VAL,  -HUGE_VAL,
                             NAN,    1e-9, 1e5,    3.1415927, std::numeric_limits<double>::min(),
                             -1e-320};
  const uint8_t choice = input.byte();
  if (choice < 240) return (choice - 120) / 40.0;
  return kOdd[choice - 240];
}

/// Time goes on by up to 0.25 s, or it does not.
Utime moment(Input& input, Utime& now) {
  constexpr int64_t kOdd[] = {0,
                              -1,
                              std::numeric_limits<int64_t>::min(),
                              std::numeric_limits<int64_t>::max(),
                              int64_t{1} << 62,
                              -(int64_t{1} << 62),
                              1'600'000'000'000'000,
                              1'600'003'600'000'000};
  const uint8_t choice = input.byte();
  if (choice >= 248) return Utime::from_us(kOdd[choice - 248]);
  now = now + Duration::from_us(choice * 1000);
  return now;
}

class Feed {
 public:
  explicit Feed(process::BatchBus& bus) : bus_(bus) {}

  void send(Input& input) {
    const uint8_t what = input.byte();
    if (what < 96) return scan(input);
    if (what < 144) return odometry(input);
    if (what < 168) return sensor(input);
    if (what < 188) return pantilt(input);
    if (what < 200) return imu(input);
    if (what < 212) return slam_pose(input);
    if (what < 224) return trajectory(input);
    if (what < 232) return command(input);
    foreign(input);
  }
  /// What every robot says first, so that inputs need not.
  void introduce() {
    SensorInfo info;
    info.channel = channels::kLidar;
    info.range_max_m = 30.0;
    info.scan_duration_s = 0.02;
    deliver(channels::kSensorInfo, to_message(info));
  }

 private:
  template <class Message>
  void deliver(const std::string& channel, const Message& message) {
    bus_.deliver(channel, encode_message(message), now_);
  }
  void scan(Input& input) {
    bot_core::planar_lidar_t message{};
    message.utime = moment(input, now_).us;
    const uint8_t shape = input.byte();
    const auto base = static_cast<float>(number(input));
    message.rad0 = -1.5F;
    message.radstep = 0.0087266463F;
    if (shape == 255) message.radstep = static_cast<float>(number(input));
    const int beams = shape >= 64 ? 361 : shape;
    for (int i = 0; i < beams; ++i) {
      // A room with corners; the input's bytes stand on its walls.
      const float wall = 2.0F + base + 0.5F * std::fabs(std::sin(0.05F * static_cast<float>(i)));
      message.ranges.push_back(i % 16 == 0 ? wall + static_cast<float>(number(input)) : wall);
    }
    message.nranges = static_cast<int32_t>(message.ranges.size());
    deliver(channels::kLidar, message);
  }
  void odometry(Input& input) {
    odometry_t message{};
    message.utime = moment(input, now_).us;
    message.x_m = number(input);
    message.y_m = number(input);
    message.theta_rad = number(input);
    deliver(channels::kOdometry, message);
  }
  void sensor(Input& input) {
    SensorInfo info;
    info.utime = moment(input, now_);
    info.channel = input.byte() % 2 == 0 ? channels::kLidar : channels::kPanTiltState;
    info.mount = input.byte() % 2 == 0 ? SensorInfo::Mount::robot : SensorInfo::Mount::pantilt;
    info.range_max_m = number(input);
    info.range_min_m = number(input);
    info.scan_duration_s = number(input);
    info.parent_from_sensor.translation() =
        Eigen::Vector3d(number(input), number(input), number(input));
    deliver(channels::kSensorInfo, to_message(info));
  }
  void pantilt(Input& input) {
    PanTiltState state;
    state.utime = moment(input, now_);
    state.pan_rad = number(input);
    state.tilt_rad = number(input);
    deliver(channels::kPanTiltState, to_message(state));
  }
  void imu(Input& input) {
    imu_t message{};
    message.utime = moment(input, now_).us;
    for (double& rate : message.angular_velocity_rad_per_s) rate = number(input);
    deliver(channels::kImu, message);
  }
  void slam_pose(Input& input) {
    slam_pose_t message{};
    message.utime = moment(input, now_).us;
    message.x_m = number(input);
    message.y_m = number(input);
    message.theta_rad = number(input);
    deliver(channels::kSlamPose, message);
  }
  void trajectory(Input& input) {
    Trajectory poses;
    const int count = input.byte() % 5;
    for (int i = 0; i < count; ++i) {
      poses.push_back({moment(input, now_), {number(input), number(input), number(input)}});
    }
    deliver(channels::kTrajectory, to_message(poses, now_, input.byte()));
  }
  void command(Input& input) {
    slam_command_t message{};
    message.utime = moment(input, now_).us;
    message.command = static_cast<int8_t>(input.byte());
    message.x_m = number(input);
    message.y_m = number(input);
    message.theta_rad = number(input);
    message.folder = "/proc/no/such/folder";
    deliver(channels::kSlamCommand, message);
  }
  /// Any bytes, or another type's message, on a channel that is listened to.
  void foreign(Input& input) {
    constexpr const char* kChannels[] = {"LIDAR",         "ODOMETRY",  "SENSOR_INFO", "IMU",
                                         "PANTILT_STATE", "LIDAR_RAW", "MAP_REQUEST", "SLAM_POSE"};
    const auto piece = input.piece();
    bus_.deliver(kChannels[input.byte() % 8], {piece.data(), piece.size()}, now_);
  }

  process::BatchBus& bus_;
  Utime now_ = Utime::from_us(1'600'000'000'000'000);
};

template <class Adapter, class Options>
void run(std::span<const uint8_t> bytes, const Options& options) {
  Input input(bytes);
  process::BatchBus bus;
  Feed feed(bus);
  Adapter adapter(bus, options);
  feed.introduce();
  for (int i = 0; i < kMessages && !input.empty(); ++i) feed.send(input);
  adapter.finish();
}

MARCO_FUZZ(slam_adapter) { run<slam::SlamAdapter>(bytes, slam::SlamAdapterOptions{}); }

MARCO_FUZZ(mapping3d_adapter) {
  run<mapping3d::Mapping3dAdapter>(bytes, mapping3d::Mapping3dAdapterOptions{});
}

struct LineSlam : slam::LineSlamAdapter {
  LineSlam(process::Bus& bus, const slam::LineProcessOptions& options)
      : LineSlamAdapter(options, bus) {}
};
MARCO_FUZZ(line_slam_adapter) { run<LineSlam>(bytes, slam::LineProcessOptions{}); }

/// The bytes in the envelope of `sample`, with a checksum that fits: none would be read otherwise.
std::string sealed_like(const std::string& sample, std::span<const uint8_t> bytes) {
  constexpr std::size_t kNameBytes = 8;
  uint32_t version = 0;
  std::memcpy(&version, sample.data() + kNameBytes, sizeof version);
  return seal(sample.substr(0, kNameBytes), version,
              {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

/// What was read is good enough to go on from.
void restore(const slam::SlamState& state) {
  slam::Slam slam;
  slam.restore(state);
  promise(slam.trajectory().size() == state.path.scans.size(), "each scan has a pose");
}

MARCO_FUZZ(saved_map) {
  try {
    restore(slam::decode_saved_map(sealed_like(slam::encode_saved_map({}), bytes)).slam);
  } catch (const std::invalid_argument&) {
  }
}

MARCO_FUZZ(slam_checkpoint) {
  try {
    const std::string sealed = sealed_like(slam::encode_adapter_state({}), bytes);
    restore(slam::decode_adapter_state(sealed).map.slam);
  } catch (const std::invalid_argument&) {
  }
}

MARCO_FUZZ(checkpoint) {
  const std::vector<uint8_t> sample = slam::encode_checkpoint({});
  const std::string sealed = sealed_like({sample.begin(), sample.end()}, bytes);
  for (const std::vector<uint8_t>& read : {std::vector<uint8_t>(bytes.begin(), bytes.end()),
                                           std::vector<uint8_t>(sealed.begin(), sealed.end())}) {
    try {
      slam::decode_checkpoint(read);
    } catch (const std::invalid_argument&) {
    }
  }
}

}  // namespace
}  // namespace marco::fuzz
