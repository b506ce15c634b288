#include "tools/log/mcap_sink.hpp"

#include <algorithm>

namespace marco::logs {
namespace {

uint64_t time_ns(int64_t ns) { return static_cast<uint64_t>(std::max<int64_t>(0, ns)); }

// "sensor_msgs/msg/LaserScan", as ROS 2 names its types.
std::string ros2_type(std::string type) {
  const std::size_t slash = type.find('/');
  return slash == std::string::npos ? type : type.insert(slash, "/msg");
}

}  // namespace

McapSink::McapSink(OutputFile& out, const std::string& encoding)
    : encoding_(encoding), writer_(out, encoding == "cdr" ? "ros2" : "ros1") {}

uint32_t McapSink::add_topic(const ros::Topic& topic) {
  const std::string name = encoding_ == "cdr" ? ros2_type(topic.type) : topic.type;
  const auto [schema, is_new] = schemas_.try_emplace(name + '\n' + topic.schema, uint16_t{0});
  if (is_new) {
    schema->second = writer_.add_schema(
        name,
        encoding_ == "cdr" && topic.schema_encoding.empty() ? "ros2msg" : topic.schema_encoding,
        topic.schema);
  }
  std::map<std::string, std::string> metadata = topic.metadata;
  if (encoding_ == "ros1") {
    metadata["md5sum"] = topic.md5;
    if (topic.is_latched) metadata["latching"] = "1";
  } else {
    metadata.try_emplace("offered_qos_profiles", "");
  }
  return writer_.add_channel(schema->second, topic.name, encoding_, metadata);
}

void McapSink::write(uint32_t topic,
                     int64_t received_ns,
                     int64_t published_ns,
                     std::span<const uint8_t> bytes) {
  writer_.write(static_cast<uint16_t>(topic), 0, {time_ns(received_ns), time_ns(published_ns)},
                {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

}  // namespace marco::logs
