#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace marco::ros {

/// A topic of a recording as one publisher wrote it; ROS 1 calls it a connection, MCAP a channel.
/// Two publishers of one topic are two of these.
struct Topic {
  uint32_t id = 0;              ///< in its file
  std::string name;             ///< "/scan"
  std::string type;             ///< "sensor_msgs/LaserScan": without the "/msg" of ROS 2
  std::string encoding;         ///< of the messages: "ros1", "cdr", "json", "protobuf", ...
  std::string schema_encoding;  ///< "ros1msg", "ros2msg", "ros2idl", "jsonschema", ...; "" unknown
  std::string schema;           ///< the definition's text; "" where the file has none
  std::string md5;              ///< of the definition; "" where the file has none
  bool is_latched = false;      ///< a late subscriber is given the last message
  int64_t messages = -1;        ///< as the file's own index counts them; -1 unknown
  std::map<std::string, std::string> metadata;  ///< callerid, offered_qos_profiles, ...
};

/// Of all topics of a file, names and definitions: more than any robot has.
inline constexpr std::size_t kMostTopicBytes = std::size_t{128} << 20;
inline constexpr const char* kTooManyTopics = ": names and definitions of topics exceed 128 MB";

/// No message that a recorder writes is larger.
inline constexpr uint64_t kMostMessageBytes = uint64_t{1} << 28;
inline constexpr const char* kTooLarge = "messages of more than 256 MB are left out";

struct Message {
  const Topic* topic = nullptr;    ///< lives as long as its source
  int64_t received_ns = 0;         ///< when the recorder had it
  int64_t published_ns = 0;        ///< when it was sent; the same where the file does not say
  std::span<const uint8_t> bytes;  ///< valid until the next call of its source
};

/// When the first message was received, and the last.
struct TimeSpan {
  int64_t first_ns = 0, last_ns = 0;
};

/// What could not be read.
struct Damage {
  int64_t places = 0;         ///< stretches that were ignored
  int64_t bytes = 0;          ///< in them
  int64_t first_offset = -1;  ///< of the first, from the start of the file
  bool is_cut_off = false;    ///< the file ends within a record
};

/// A second reading says nothing again.
inline void note_once(std::vector<std::string>& notes, const std::string& note) {
  if (std::find(notes.begin(), notes.end(), note) == notes.end()) notes.push_back(note);
}

inline std::string note_of_checksum(int64_t chunk_offset) {
  return "the chunk at byte " + std::to_string(chunk_offset) +
         " has a wrong checksum: used unchanged";
}

/// The messages of a recording, whatever its container. Memory does not grow with the file.
/// Not safe for threads.
class MessageSource {
 public:
  virtual ~MessageSource() = default;

  /// "ROS bag", "MCAP", "rosbag2 (sqlite3)", ...
  virtual std::string format() const = 0;
  virtual std::vector<std::string> paths() const = 0;

  /// Only topics for which this is true are given from now on; all are without it. Sources that
  /// have an index do not even read the others.
  virtual void select(std::function<bool(const Topic&)> is_wanted) = 0;

  /// The next message by the time of receipt, those of one instant in the order of the file. Where
  /// pieces of the file overlap in time they are merged.
  virtual std::optional<Message> next() = 0;
  /// To the first message again; the selection stays, damage counts again.
  virtual void rewind() = 0;

  /// Of the whole recording. Nothing where there is no message, or all would have to be read.
  virtual std::optional<TimeSpan> span() const { return std::nullopt; }

  /// Those seen so far; all of them after the last message, or at once where the file has an index.
  virtual std::vector<const Topic*> topics() const = 0;
  virtual const Damage& damage() const = 0;
  /// Oddities for the report: an index that is missing, a checksum that is wrong, ...
  virtual const std::vector<std::string>& notes() const = 0;
  /// Part of the input that was read, 0..1.
  virtual double progress() const = 0;
};

/// "pkg/msg/Name" and "pkg/Name" are one type: "pkg/Name".
inline std::string plain_type(std::string_view type) {
  std::string plain(type);
  if (const auto at = plain.find("/msg/"); at != std::string::npos) plain.erase(at, 4);
  return plain;
}

}  // namespace marco::ros
