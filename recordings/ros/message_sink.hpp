#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "recordings/ros/message_source.hpp"

namespace marco::ros {

/// Where messages of ROS go: the counterpart of MessageSource.
class MessageSink {
 public:
  virtual ~MessageSink() = default;

  /// "ros1" or "cdr": how the bytes of messages must be written.
  virtual std::string encoding() const = 0;

  /// @param topic  with its schema; its id and count are ignored. @returns its number here
  virtual uint32_t add_topic(const Topic& topic) = 0;

  /// In any order of times. @param topic  its number
  virtual void write(uint32_t topic,
                     int64_t received_ns,
                     int64_t published_ns,
                     std::span<const uint8_t> bytes) = 0;

  /// Completes the file. Nothing may be written after it.
  virtual void finish() = 0;
};

}  // namespace marco::ros
