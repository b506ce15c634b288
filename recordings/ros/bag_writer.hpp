#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "lcm_tools/files/output_file.hpp"
#include "recordings/ros/message_sink.hpp"

namespace marco::ros {

/// Writes a ROS 1 bag (format 2.0) that `rosbag play` accepts: chunks of about 768 kB, packed with
/// LZ4 in the one form that ROS reads, each followed by its indexes; the index of the file behind
/// them. Memory: one chunk, and about 100 bytes for each chunk written.
class BagWriter : public MessageSink {
 public:
  /// @param out must outlive it; finish() it after finish(). A file, not a pipe: the start of a bag
  /// says where its end is.
  explicit BagWriter(files::OutputFile& out);

  std::string encoding() const override { return "ros1"; }
  uint32_t add_topic(const Topic& topic) override;
  /// ROS refuses messages of time 0; they are given the first nanosecond.
  void write(uint32_t topic,
             int64_t received_ns,
             int64_t published_ns,
             std::span<const uint8_t> bytes) override;
  /// @throws std::runtime_error when the start of the file cannot be written again.
  void finish() override;

 private:
  struct Entry {
    int64_t time_ns;
    uint32_t offset;
  };
  using Index = std::map<uint32_t, std::vector<Entry>>;  // by connection
  struct ChunkInfo {
    uint64_t offset = 0;
    int64_t start_ns = 0, end_ns = 0;
    std::map<uint32_t, uint32_t> counts;  // by connection
  };
  void flush_chunk();

  files::OutputFile& out_;
  std::vector<std::string> connections_;  // whole records
  std::set<uint32_t> written_connections_;
  std::string chunk_;
  Index index_;
  std::vector<ChunkInfo> chunks_;
};

}  // namespace marco::ros
