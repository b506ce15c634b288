#include "tools/bridge/ros_input.hpp"

#include <algorithm>

#include "recordings/ros/messages.hpp"
#include "recordings/ros/ros_survey.hpp"

namespace marco::bridge {
namespace {

// From the first scan on: what a robot publishes at all has come by then, but for what is only
// about to start; that is waited for longer.
constexpr double kLookS = 3.0, kWaitS = 10.0, kTryAgainS = 1.0;
constexpr std::size_t kMostBytes = 64 << 20;

bool is_latched(const ros::Topic& topic) { return topic.name.ends_with("tf_static"); }

}  // namespace

void HeardMessages::add(const ros::Message& message) {
  bytes_ += message.bytes.size();
  heard_.push_back(
      {message.topic, message.received_ns, {message.bytes.begin(), message.bytes.end()}});
}

void HeardMessages::clear() {
  heard_.clear();
  bytes_ = next_ = 0;
}

void HeardMessages::forget() {
  std::erase_if(heard_, [](const Heard& message) { return !is_latched(*message.topic); });
  bytes_ = 0;
  for (const Heard& message : heard_) bytes_ += message.bytes.size();
}

void HeardMessages::select(std::function<bool(const ros::Topic&)> is_wanted) {
  is_wanted_ = std::move(is_wanted);
  rewind();
}

std::optional<ros::Message> HeardMessages::next() {
  while (next_ < heard_.size()) {
    const Heard& message = heard_[next_++];
    if (is_wanted_ && !is_wanted_(*message.topic)) continue;
    return ros::Message{message.topic, message.received_ns, message.received_ns, message.bytes};
  }
  return std::nullopt;
}

RosInput::RosInput(RosOptions options, std::function<void(const Sample&)> give)
    : options_(std::move(options)), give_(std::move(give)) {}

// Clouds are large, and seldom of a 2D laser: only one that the user names.
bool RosInput::is_used(const ros::Topic& topic) const {
  switch (ros::use_of(topic)) {
    case ros::Use::scan:
    case ros::Use::odometry:
    case ros::Use::transforms:
    case ros::Use::imu:
    case ros::Use::joints:
      return true;
    case ros::Use::cloud:
      return topic.name == options_.laser;
    case ros::Use::pose:
      return topic.name == options_.truth;
    case ros::Use::none:
      break;
  }
  return false;
}

std::vector<std::pair<uint32_t, uint32_t>> RosInput::advertised(
    const std::vector<foxglove::ServerChannel>& channels) {
  std::vector<std::pair<uint32_t, uint32_t>> wanted;
  for (const foxglove::ServerChannel& channel : channels) {
    ros::Topic topic;
    topic.id = channel.id;
    topic.name = channel.topic;
    topic.type = ros::plain_type(channel.schema_name);
    topic.encoding = channel.encoding;
    topic.schema_encoding = channel.schema_encoding;
    if (!is_used(topic)) continue;
    const bool is_known =
        std::any_of(subscribed_.begin(), subscribed_.end(),
                    [&channel](const auto& one) { return one.second.channel == channel.id; });
    if (is_known) continue;
    wanted.emplace_back(next_id_, channel.id);
    subscribed_.emplace(next_id_++, Subscribed{channel.id, std::move(topic)});
    is_looking_ = true;
    first_scan_s_.reset();
  }
  return wanted;
}

void RosInput::unadvertised(const std::vector<uint32_t>& channels) {
  // Their topics stay: messages that are kept name them.
  for (auto& [id, subscribed] : subscribed_) {
    if (std::find(channels.begin(), channels.end(), subscribed.channel) != channels.end()) {
      subscribed.channel = UINT32_MAX;
    }
  }
}

void RosInput::forget() {
  heard_.clear();
  subscribed_.clear();
  is_looking_ = true;
  first_scan_s_.reset();
  missing_.clear();
}

void RosInput::take(const foxglove::ServerData& data, double now_s) {
  const auto subscribed = subscribed_.find(data.subscription);
  if (subscribed == subscribed_.end()) return;
  const ros::Topic& topic = subscribed->second.topic;
  const ros::Message message{&topic, data.received_ns, data.received_ns, data.payload};
  if (is_looking_) look(message, now_s);
  if (!samples_ || !samples_->wants(topic)) return;
  for (const Sample& sample : samples_->take(message)) give_(sample);
}

void RosInput::look(const ros::Message& message, double now_s) {
  heard_.add(message);
  const ros::Use use = ros::use_of(*message.topic);
  if (!first_scan_s_ && (use == ros::Use::scan || use == ros::Use::cloud)) {
    first_scan_s_ = tried_s_ = now_s;
  }
  const bool is_full = heard_.bytes() > kMostBytes;
  if (!first_scan_s_ || (!is_full && now_s - *first_scan_s_ < kLookS)) {
    if (is_full) heard_.forget();
    return;
  }
  if (is_full || now_s - tried_s_ >= kTryAgainS) decide(now_s);
}

void RosInput::decide(double now_s) {
  tried_s_ = now_s;
  const bool is_last = now_s - *first_scan_s_ >= kWaitS || heard_.bytes() > kMostBytes;
  try {
    const ros::RosSurvey survey = ros::survey(heard_);
    ros::RosPlan plan = ros::plan_of(survey, options_);
    const bool has_odometry = !plan.odometry_topic.empty() || !plan.odometry_parent.empty();
    const bool is_whole = has_odometry || options_.odometry == "none";
    if (is_whole || is_last) return use(survey, std::move(plan));
    missing_ = "no odometry yet";
  } catch (const std::invalid_argument& problem) {
    missing_ = problem.what();
    if (!is_last) return;
    heard_.forget();
    first_scan_s_.reset();
  }
}

void RosInput::use(const ros::RosSurvey& survey, ros::RosPlan plan) {
  is_looking_ = false;
  missing_.clear();
  heard_.forget();
  notes_ = plan.notes;
  Frames frames{plan.odometry_parent, plan.base_frame};
  if (!plan.odometry_topic.empty()) {
    frames.odom = survey.topics.at(plan.odometry_topic).frame_id;
    if (frames.odom.empty()) frames.odom = "odom";
  }
  if (frames.robot.empty()) frames.robot = plan.lasers.front().frame;
  frames_ = frames;
  samples_.emplace(std::move(plan), options_);
}

std::string RosInput::state() const {
  if (!samples_) {
    if (!missing_.empty()) return missing_;
    if (first_scan_s_) return "reading the robot's topics";
    const bool has_scans = std::any_of(subscribed_.begin(), subscribed_.end(), [](const auto& one) {
      return ros::use_of(one.second.topic) == ros::Use::scan;
    });
    return has_scans ? "waiting for scans" : "the robot advertises no sensor_msgs/LaserScan";
  }
  const ros::RosPlan& plan = samples_->plan();
  std::string text = "laser " + plan.lasers.front().topic;
  text += !plan.odometry_topic.empty()    ? ", odometry " + plan.odometry_topic
          : !plan.odometry_parent.empty() ? ", odometry from tf"
                                          : ", no odometry";
  return plan.imu_topic.empty() ? text : text + ", gyroscope " + plan.imu_topic;
}

}  // namespace marco::bridge
