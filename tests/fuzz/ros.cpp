// Recordings of ROS messages that somebody sent.
#include <string_view>
#include <vector>

#include "recordings/ros/messages.hpp"
#include "recordings/ros/open_messages.hpp"
#include "recordings/ros/wire_reader.hpp"
#include "tests/fuzz/memory_file.hpp"
#include "tests/fuzz/target.hpp"
#include "tools/bridge/ros_input.hpp"
#include "web/foxglove/client.hpp"

namespace marco::fuzz {
namespace {

template <class Read>
void quietly(Read read) {
  try {
    read();
  } catch (const std::invalid_argument&) {
  } catch (const std::runtime_error&) {
  }
}

/// A bag, an MCAP file, a database: whatever it begins as.
MARCO_FUZZ(ros_messages) {
  Input input(bytes);
  constexpr std::string_view kHeads[] = {"#ROSBAG V2.0\n", "\x89MCAP0\r\n", ""};
  const std::string_view head = kHeads[input.byte() % 3];
  std::vector<uint8_t> content(head.begin(), head.end());
  const auto rest = input.rest();
  content.insert(content.end(), rest.begin(), rest.end());
  const MemoryFile file(content);
  quietly([&] {
    const auto source = ros::open_messages(file.path());
    int64_t messages = 0;
    while (const auto message = source->next()) {
      ++messages;
      try {
        switch (ros::use_of(*message->topic)) {
          case ros::Use::scan:
            ros::decode_scan(*message);
            break;
          case ros::Use::cloud:
            ros::decode_cloud(*message);
            break;
          case ros::Use::odometry:
            ros::decode_odometry(*message);
            break;
          case ros::Use::transforms:
            ros::decode_transforms(*message);
            break;
          case ros::Use::imu:
            ros::decode_imu(*message);
            break;
          case ros::Use::pose:
            ros::decode_pose(*message);
            break;
          case ros::Use::joints:
            ros::decode_joints(*message);
            break;
          case ros::Use::none:
            break;
        }
      } catch (const ros::WireError&) {
      }
    }
    source->rewind();
    int64_t again = 0;
    while (source->next()) ++again;
    promise(again >= messages, "a second reading, which knows all topics, gives no less");
  });
}

/// One message of a type that is used, in each encoding.
MARCO_FUZZ(ros_message) {
  Input input(bytes);
  const uint8_t kind = input.byte();
  ros::Topic topic;
  constexpr const char* kEncodings[] = {"ros1", "cdr", "json"};
  topic.encoding = kEncodings[kind % 3];
  topic.type = "sensor_msgs/LaserScan";
  const auto rest = input.rest();
  const ros::Message message{&topic, 0, 0, rest};
  const auto refused = [](auto decode) {
    try {
      decode();
    } catch (const ros::WireError&) {
    }
  };
  refused([&] { ros::decode_scan(message); });
  refused([&] { ros::decode_cloud(message); });
  refused([&] { ros::decode_odometry(message); });
  refused([&] { ros::decode_transforms(message); });
  refused([&] { ros::decode_imu(message); });
  refused([&] { ros::decode_pose(message); });
}

/// What a robot's foxglove_bridge, or somebody in its place, says.
MARCO_FUZZ(foxglove) {
  if (const auto data = foxglove::parse_binary(bytes)) {
    promise(data->payload.size() + 13 == bytes.size(), "a payload is the rest of its message");
  }
  try {
    const auto text =
        foxglove::parse_text({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
    const auto* advertised = std::get_if<foxglove::Advertised>(&text);
    if (advertised == nullptr) return;
    bridge::RosInput input({}, [](const Sample&) {});
    input.advertised(advertised->channels);
    double now_s = 0.0;
    for (const foxglove::ServerChannel& channel : advertised->channels) {
      // Each channel says its own schema, four seconds after the one before.
      const auto* said = reinterpret_cast<const uint8_t*>(channel.schema.data());
      for (uint32_t id = 1; id <= 3; ++id) {
        quietly([&] { input.take({id, 1, {said, channel.schema.size()}}, now_s); });
      }
      now_s += 4.0;
    }
  } catch (const std::invalid_argument&) {
  }
}

}  // namespace
}  // namespace marco::fuzz
