#include "tools/log/ros_copy.hpp"

#include <optional>

#include "recordings/ros/known_types.hpp"
#include "tools/log/ros_export.hpp"

namespace marco::logs {
namespace {

// How the messages of one topic go over.
struct Way {
  std::string left_out;  // why; "" where they are written
  uint32_t number = 0;   // in the sink
  const ros::KnownType* transcoded_by = nullptr;
};

class RosCopy {
 public:
  explicit RosCopy(ros::MessageSink& sink) : sink_(sink) {}

  void add(const ros::Message& message) {
    const auto [known, is_new] = ways_.try_emplace(message.topic);
    Way& way = known->second;
    if (is_new) way = way_of(*message.topic);
    if (!way.left_out.empty()) {
      ++result_.left_out[way.left_out];
    } else if (way.transcoded_by == nullptr) {
      write(way, message, message.bytes);
    } else {
      write_transcoded(way, message);
    }
  }
  RosCopyResult result() const { return result_; }

 private:
  void write(const Way& way, const ros::Message& message, std::span<const uint8_t> bytes) {
    sink_.write(way.number, message.received_ns, message.published_ns, bytes);
    ++result_.messages;
  }

  void write_transcoded(const Way& way, const ros::Message& message) {
    try {
      auto from = ros::WireReader::of(message.topic->encoding, message.bytes);
      ros::WireWriter to(sink_.encoding());
      ros::transcode(*way.transcoded_by, from, to);
      from.finish();
      write(way, message, to.bytes());
    } catch (const ros::WireError&) {
      ++result_.left_out["broken messages of " + message.topic->name];
    }
  }

  Way way_of(const ros::Topic& topic) {
    // Old rosbag2 databases hold no definitions.
    const std::string type = topic.type == "tf/tfMessage" ? "tf2_msgs/TFMessage" : topic.type;
    const ros::KnownType* known = ros::known_type(type);
    const bool is_public = known != nullptr && !known->md5.empty();
    const std::string encoding = sink_.encoding();
    Way way;
    if (topic.encoding == encoding) {
      ros::Topic same = topic;
      if (is_public && same.schema.empty()) {
        same.schema = ros::definition_text(*known, encoding);
        same.schema_encoding = encoding == "cdr" ? "ros2msg" : "ros1msg";
      }
      if (is_public && same.md5.empty()) same.md5 = known->md5;
      if (encoding == "ros1" && same.md5.empty()) {
        way.left_out = topic.type + " has no checksum, which bags need";
        return way;
      }
      way.number = sink_.add_topic(same);
      return way;
    }
    if (!is_public || (topic.encoding != "ros1" && topic.encoding != "cdr")) {
      way.left_out = topic.type + " (" + topic.encoding + ") is not known in " +
                     (encoding == "cdr" ? "ROS 2" : "ROS 1");
      return way;
    }
    ros::Topic other = topic_of(topic.name, type, encoding);
    if (topic.is_latched && encoding == "ros1") other.is_latched = true;
    way.number = sink_.add_topic(other);
    way.transcoded_by = known;
    return way;
  }

  ros::MessageSink& sink_;
  std::map<const ros::Topic*, Way> ways_;
  RosCopyResult result_;
};

}  // namespace

RosCopyResult copy_messages(ros::MessageSource& source,
                            ros::MessageSink& sink,
                            const OnProgress& on_progress) {
  RosCopy copy(sink);
  constexpr int64_t kMessagesBetweenProgress = 1024;
  for (int64_t count = 1; const auto message = source.next(); ++count) {
    copy.add(*message);
    if (count % kMessagesBetweenProgress == 0) on_progress(source.progress());
  }
  return copy.result();
}

}  // namespace marco::logs
