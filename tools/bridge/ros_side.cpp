#include "tools/bridge/ros_side.hpp"

#include <chrono>
#include <utility>

namespace marco::bridge {
namespace {

double steady_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

RosSide::RosSide(const std::string& url,
                 const RosOptions& options,
                 process::DropCounter& drops,
                 std::function<void(const std::string&)> say)
    : url_(url),
      drops_(drops),
      say_(std::move(say)),
      input_(options,
             [this](const Sample& sample) {
               if (const auto* odometry = std::get_if<OdometrySample>(&sample)) {
                 output_.note(*odometry);
               }
               if (marco_ != nullptr) marco_->give(sample);
             }),
      output_([this](std::vector<uint8_t> message) {
        const bool sent = socket_.send_binary(std::move(message));
        if (!sent) drops_.count("not sent: the robot reads messages too slowly");
        return sent;
      }),
      socket_(parse_websocket_url(url),
              foxglove::kSubprotocols,
              {[this](const std::string& subprotocol) {
                 not_connected_.clear();
                 say_("connected to " + url_ + " (" + subprotocol + ")");
               },
               [this](std::string_view text) { count([&] { take_text(text); }); },
               [this](std::span<const uint8_t> message) { count([&] { take_binary(message); }); },
               [this](const std::string& why) {
                 const std::string now = "not connected to " + url_ + ": " + why;
                 if (now != not_connected_) say_(now + "; retrying every second");
                 not_connected_ = now;
                 input_.forget();
                 output_.close();
               }}) {}

void RosSide::count(const std::function<void()>& handle) {
  drops_.count_received();
  try {
    handle();
  } catch (const std::invalid_argument& bad_message) {
    drops_.count(bad_message.what());
  }
}

void RosSide::take_text(std::string_view text) {
  const foxglove::ServerText message = foxglove::parse_text(text);
  if (const auto* server = std::get_if<foxglove::ServerInfo>(&message)) {
    input_.forget();  // what a session before this one called its channels
    if (const auto topics = output_.open(*server)) {
      socket_.send_text(*topics);
      output_.send_map_again();
    } else {
      say_("nothing is sent back: " + output_.trouble());
    }
  } else if (const auto* advertised = std::get_if<foxglove::Advertised>(&message)) {
    const auto wanted = input_.advertised(advertised->channels);
    if (!wanted.empty()) socket_.send_text(foxglove::subscribe_text(wanted));
  } else if (const auto* gone = std::get_if<foxglove::Unadvertised>(&message)) {
    input_.unadvertised(gone->channels);
  } else if (const auto* status = std::get_if<foxglove::ServerStatus>(&message)) {
    if (status->level > 0) say_("the robot's bridge says: " + status->message);
  }
}

void RosSide::take_binary(std::span<const uint8_t> message) {
  const auto data = foxglove::parse_binary(message);
  if (!data) return;
  input_.take(*data, steady_s());
  for (const std::string& note : input_.take_notes()) say_(note);
  if (input_.frames()) output_.note_frames(*input_.frames());
}

std::string RosSide::state() const {
  if (!not_connected_.empty()) return not_connected_;
  return output_.trouble().empty() ? input_.state() : input_.state() + "; " + output_.trouble();
}

}  // namespace marco::bridge
