#pragma once

#include <map>
#include <string>

#include "lcm_tools/log/mcap_writer.hpp"
#include "recordings/ros/message_sink.hpp"

namespace marco::logs {

/// An MCAP file as ROS' own recorders write it: of profile `ros2` (CDR; `ros2 bag play` takes it)
/// or `ros1` (the bytes of a bag, with its connections).
class McapSink : public ros::MessageSink {
 public:
  /// @param encoding "cdr" or "ros1". @param out as of McapWriter
  McapSink(OutputFile& out, const std::string& encoding);

  std::string encoding() const override { return encoding_; }
  uint32_t add_topic(const ros::Topic& topic) override;
  void write(uint32_t topic,
             int64_t received_ns,
             int64_t published_ns,
             std::span<const uint8_t> bytes) override;
  void finish() override { writer_.finish(); }

 private:
  std::string encoding_;
  McapWriter writer_;
  std::map<std::string, uint16_t> schemas_;  // by name and text
};

}  // namespace marco::logs
