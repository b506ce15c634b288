#pragma once

#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "recordings/ros/ros_samples.hpp"
#include "web/foxglove/client.hpp"

namespace marco::bridge {

/// Received messages, as a recording for ros::survey().
class HeardMessages : public ros::MessageSource {
 public:
  void add(const ros::Message& message);
  /// But what a latched topic said once.
  void forget();
  void clear();
  std::size_t bytes() const { return bytes_; }

  std::string format() const override { return "live"; }
  std::vector<std::string> paths() const override { return {}; }
  void select(std::function<bool(const ros::Topic&)> is_wanted) override;
  std::optional<ros::Message> next() override;
  void rewind() override { next_ = 0; }
  std::vector<const ros::Topic*> topics() const override { return {}; }
  const ros::Damage& damage() const override { return damage_; }
  const std::vector<std::string>& notes() const override { return notes_; }
  double progress() const override { return 0.0; }

 private:
  struct Heard {
    const ros::Topic* topic;
    int64_t received_ns;
    std::vector<uint8_t> bytes;
  };
  std::deque<Heard> heard_;
  std::size_t bytes_ = 0, next_ = 0;
  std::function<bool(const ros::Topic&)> is_wanted_;
  ros::Damage damage_;
  std::vector<std::string> notes_;
};

/// A robot's topics of ROS as samples. For some seconds it listens to scans, odometry, transforms
/// and gyroscopes, and decides, as for a recording, which it takes and where the laser sits; again
/// when other topics come.
class RosInput {
 public:
  struct Frames {
    std::string odom, robot;  ///< odom "": there is no odometry
  };

  RosInput(RosOptions options, std::function<void(const Sample&)> give);

  /// @returns what is to be subscribed: pairs of our id and the server's channel.
  std::vector<std::pair<uint32_t, uint32_t>> advertised(
      const std::vector<foxglove::ServerChannel>& channels);
  void unadvertised(const std::vector<uint32_t>& channels);
  /// The connection is gone.
  void forget();

  /// @param now_s  of any clock that never steps back
  /// @throws std::invalid_argument saying what is wrong with the message.
  void take(const foxglove::ServerData& data, double now_s);

  /// Nothing until it has decided.
  const std::optional<Frames>& frames() const { return frames_; }
  /// What was decided, a sentence each; once.
  std::vector<std::string> take_notes() { return std::exchange(notes_, {}); }
  /// For PROCESS_STATUS: what comes and what is missing.
  std::string state() const;

 private:
  struct Subscribed {
    uint32_t channel;
    ros::Topic topic;
  };
  bool is_used(const ros::Topic& topic) const;
  void look(const ros::Message& message, double now_s);
  void decide(double now_s);
  void use(const ros::RosSurvey& survey, ros::RosPlan plan);

  RosOptions options_;
  std::function<void(const Sample&)> give_;
  std::map<uint32_t, Subscribed> subscribed_;  // by our id
  uint32_t next_id_ = 1;
  HeardMessages heard_;
  bool is_looking_ = true;
  std::optional<double> first_scan_s_;
  double tried_s_ = 0.0;
  std::optional<ros::RosSamples> samples_;
  std::optional<Frames> frames_;
  std::string missing_;  // why nothing is decided yet
  std::vector<std::string> notes_;
};

}  // namespace marco::bridge
