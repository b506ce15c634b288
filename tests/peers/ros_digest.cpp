// What our readers find in recordings of ROS messages, for comparison with other people's: a line a
// topic of each file, with the checksum of all its messages' bytes and times, and, of scans, of
// their decoded values.
#include <zlib.h>

#include <cstdio>
#include <map>
#include <string>

#include "recordings/ros/messages.hpp"
#include "recordings/ros/open_messages.hpp"

namespace {

struct Digest {
  long messages = 0;
  uLong bytes = crc32(0, nullptr, 0);
  uLong ranges = crc32(0, nullptr, 0);
  double angles = 0.0;

  template <class Value>
  static uLong extended(uLong sum, const Value* values, std::size_t count) {
    return crc32_z(sum, reinterpret_cast<const Bytef*>(values), count * sizeof(Value));
  }
};

}  // namespace

int main(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    const auto source = marco::ros::open_messages(argv[i]);
    std::map<std::string, Digest> digests;
    while (const auto message = source->next()) {
      const std::string type = message->topic->type;
      Digest& digest = digests[message->topic->name + " " + type];
      ++digest.messages;
      digest.bytes = Digest::extended(digest.bytes, &message->received_ns, 1);
      digest.bytes = Digest::extended(digest.bytes, message->bytes.data(), message->bytes.size());
      if (type != "sensor_msgs/LaserScan") continue;
      const auto scan = marco::ros::decode_scan(*message);
      digest.ranges = Digest::extended(digest.ranges, scan.ranges.data(), scan.ranges.size());
      digest.angles +=
          static_cast<double>(scan.angle_min) + static_cast<double>(scan.angle_increment) +
          static_cast<double>(scan.range_max) + 1e-9 * static_cast<double>(scan.header.stamp_ns);
    }
    for (const auto& [topic, digest] : digests) {
      std::printf("%s %s %ld %08lx %08lx %.6f\n", argv[i], topic.c_str(), digest.messages,
                  digest.bytes, digest.ranges, digest.angles);
    }
  }
  return 0;
}
