// LCM messages of each type: decode, convert, and what converts must convert back to the same
// bytes.
#include "bot_core/image_t.hpp"
#include "bot_core/pose_t.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "lcmtypes/convert_robot.hpp"
#include "marco/maebot_encoders_t.hpp"
#include "marco/map_request_t.hpp"
#include "marco/mbot_pose2d_t.hpp"
#include "marco/mesh_t.hpp"
#include "marco/process_status_t.hpp"
#include "marco/scene_t.hpp"
#include "marco/slam_command_t.hpp"
#include "marco/slam_pose_t.hpp"
#include "tests/fuzz/target.hpp"

namespace marco::fuzz {
namespace {

/// The bytes behind the type's fingerprint, which nobody can guess.
template <class Message>
Bytes with_fingerprint(std::span<const uint8_t> bytes) {
  Bytes whole(8);
  const auto hash = static_cast<uint64_t>(Message::getHash());
  for (unsigned i = 0; i < 8; ++i) whole[i] = static_cast<uint8_t>(hash >> (56U - 8U * i));
  whole.insert(whole.end(), bytes.begin(), bytes.end());
  return whole;
}

template <class Message>
bool decoded(std::span<const uint8_t> bytes, Message& message) {
  const Bytes whole = with_fingerprint<Message>(bytes);
  const int size = static_cast<int>(whole.size());
  const int used = message.decode(whole.data(), 0, size);
  promise(used <= size, "a decoder reads no more than there is");
  if (used != size) return false;
  // Booleans become 0 or 1 and strings end at their first zero, so sizes need not be the same.
  promise(message.getEncodedSize() <= size, "what was decoded needs no more than it came from");
  encode_message(message);
  return true;
}

template <class Message>
void only_decode(std::span<const uint8_t> bytes) {
  Message message{};
  decoded(bytes, message);
}

template <class Message>
void convert_there_and_back(std::span<const uint8_t> bytes) {
  Message message{};
  if (!decoded(bytes, message)) return;
  try {
    const auto value = from_message(message);
    encode_message(to_message(value));
  } catch (const std::invalid_argument&) {
  }
}

void as_laser(std::span<const uint8_t> bytes) {
  bot_core::planar_lidar_t message{};
  if (!decoded(bytes, message)) return;
  try {
    const LaserScan scan = from_message(message, channels::kLidar);
    encode_message(to_message(scan));
  } catch (const std::invalid_argument&) {
  }
}

void as_raw_laser(std::span<const uint8_t> bytes) {
  lidar_raw_t message{};
  if (!decoded(bytes, message)) return;
  try {
    const LaserScan scan = from_message(message, channels::kLidarRaw);
    encode_message(to_raw_message(scan));
  } catch (const std::invalid_argument&) {
  }
}

template <class Message>
void only_from(std::span<const uint8_t> bytes) {
  Message message{};
  if (!decoded(bytes, message)) return;
  try {
    from_message(message);
  } catch (const std::invalid_argument&) {
  }
}

void as_sample(std::span<const uint8_t> bytes) {
  Input input(bytes);
  constexpr const char* kChannels[] = {
      channels::kLidar,    channels::kLidarRaw,     channels::kSensorInfo, channels::kImu,
      channels::kOdometry, channels::kPanTiltState, channels::kTruePose,   "NOBODYS"};
  const char* channel = kChannels[input.byte() % 8];
  try {
    if (const auto sample = decode_sample(channel, input.rest())) encode_sample(*sample);
  } catch (const std::invalid_argument&) {
  }
}

constexpr void (*kTypes[])(std::span<const uint8_t>) = {
    as_laser,
    as_raw_laser,
    convert_there_and_back<sensor_info_t>,
    convert_there_and_back<odometry_t>,
    convert_there_and_back<imu_t>,
    convert_there_and_back<pantilt_state_t>,
    convert_there_and_back<pose2_t>,
    convert_there_and_back<base_command_t>,
    convert_there_and_back<base_status_t>,
    convert_there_and_back<sonar_t>,
    convert_there_and_back<pantilt_command_t>,
    convert_there_and_back<gamepad_t>,
    only_from<trajectory_t>,
    only_from<line_map_t>,
    only_from<grid_map_t>,
    only_decode<bot_core::image_t>,
    only_decode<bot_core::pose_t>,
    only_decode<maebot_encoders_t>,
    only_decode<map_request_t>,
    only_decode<mbot_pose2d_t>,
    only_decode<mesh_t>,
    only_decode<process_status_t>,
    only_decode<scene_t>,
    only_decode<slam_command_t>,
    only_decode<slam_pose_t>,
    as_sample,
    convert_there_and_back<emergency_stop_t>,
    only_from<loop_closures_t>,
};

MARCO_FUZZ(messages) {
  Input input(bytes);
  const std::size_t type = input.byte() % std::size(kTypes);
  kTypes[type](input.rest());
}

}  // namespace
}  // namespace marco::fuzz
