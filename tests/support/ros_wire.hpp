#pragma once

#include <cstdint>
#include <cstring>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "recordings/ros/message_source.hpp"

namespace marco::testing {

/// Writes ROS messages field by field, packed (ROS 1) or as CDR: the tests' own, so that it shares
/// nothing with the reader.
class RosWriter {
 public:
  enum class Form { ros1, cdr };
  explicit RosWriter(Form form) : form_(form) {
    if (form == Form::cdr) bytes_ = {0, 1, 0, 0};
  }

  template <class Number>
  RosWriter& number(Number value) {
    if (form_ == Form::cdr) {
      while ((bytes_.size() - 4) % sizeof value != 0) bytes_.push_back(0);
    }
    const auto* raw = reinterpret_cast<const uint8_t*>(&value);
    bytes_.insert(bytes_.end(), raw, raw + sizeof value);
    return *this;
  }
  RosWriter& text(const std::string& value) {
    const std::size_t end_mark = form_ == Form::cdr ? 1 : 0;
    number(static_cast<uint32_t>(value.size() + end_mark));
    bytes_.insert(bytes_.end(), value.begin(), value.end());
    if (end_mark == 1) bytes_.push_back(0);
    return *this;
  }
  template <class Number>
  RosWriter& numbers(const std::vector<Number>& values) {
    for (const Number value : values) number(value);
    return *this;
  }
  RosWriter& header(double stamp_s, const std::string& frame) {
    if (form_ == Form::ros1) number(uint32_t{0});
    const auto whole = static_cast<int32_t>(stamp_s);
    number(whole);
    number(static_cast<uint32_t>((stamp_s - whole) * 1e9 + 0.5));
    return text(frame);
  }
  const std::vector<uint8_t>& bytes() const { return bytes_; }

 private:
  Form form_;
  std::vector<uint8_t> bytes_;
};

/// A recording in memory.
class MemorySource : public ros::MessageSource {
 public:
  void add(const std::string& topic,
           const std::string& type,
           double received_s,
           const std::vector<uint8_t>& bytes,
           const std::string& encoding = "cdr") {
    auto [known, is_new] = topics_.try_emplace(topic);
    if (is_new) {
      known->second.name = topic;
      known->second.type = type;
      known->second.encoding = encoding;
    }
    messages_.push_back({&known->second, static_cast<int64_t>(received_s * 1e9 + 0.5), bytes});
  }

  std::string format() const override { return "memory"; }
  std::vector<std::string> paths() const override { return {"memory"}; }
  void select(std::function<bool(const ros::Topic&)> is_wanted) override {
    is_wanted_ = std::move(is_wanted);
    rewind();
  }
  std::optional<ros::Message> next() override {
    while (next_ < messages_.size()) {
      const Stored& stored = messages_[next_++];
      if (is_wanted_ && !is_wanted_(*stored.topic)) continue;
      return ros::Message{stored.topic, stored.received_ns, stored.received_ns, stored.bytes};
    }
    return std::nullopt;
  }
  void rewind() override { next_ = 0; }
  std::vector<const ros::Topic*> topics() const override {
    std::vector<const ros::Topic*> topics;
    for (const auto& [name, topic] : topics_) topics.push_back(&topic);
    return topics;
  }
  const ros::Damage& damage() const override { return damage_; }
  const std::vector<std::string>& notes() const override { return notes_; }
  double progress() const override { return 0.0; }

 private:
  struct Stored {
    const ros::Topic* topic;
    int64_t received_ns;
    std::vector<uint8_t> bytes;
  };
  std::map<std::string, ros::Topic> topics_;
  std::vector<Stored> messages_;
  std::function<bool(const ros::Topic&)> is_wanted_;
  std::size_t next_ = 0;
  ros::Damage damage_;
  std::vector<std::string> notes_;
};

}  // namespace marco::testing
