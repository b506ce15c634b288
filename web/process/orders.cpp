#include "web/process/orders.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/inside_folder.hpp"
#include "lcm_tools/process/emergency_stop.hpp"
#include "lcm_tools/process/wall_clock.hpp"
#include "lcm_tools/procman/process/descriptor.hpp"
#include "lcm_tools/procman/process/message_check.hpp"
#include "lcm_tools/recorder/recordings.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert_robot.hpp"
#include "web/foxglove/json.hpp"
#include "web/page_schemas.hpp"
#include "web/process/request_fields.hpp"

namespace marco::web {
namespace {

using foxglove::text_json;

// A second after its browser's last sign of life the robot stands: a base brakes for half of it. A
// page says each 0.15 s that it is there; one that draws much is late, and its goal continues.
constexpr double kGoalHoldsS = 0.45, kGoalEndsS = 1.0;
constexpr int64_t kPingEveryUs = 150'000, kStopAgainUs = 50'000;
constexpr auto kGoalEveryUs = static_cast<int64_t>(1e6 * teleop::GoalDrive::kSendEveryS);
constexpr const char* kReadOnly =
    "only watching: to give orders, open the address with its token, or a page on this host";
constexpr const char* kRecording = "a recording takes no orders";

Utime wall_now() { return Utime::from_us(process::wall_clock_us()); }

teleop::GoalDrive::Speeds goal_speeds(const SteeringOptions& options) {
  return {std::min(options.goal_velocity_m_per_s, options.most_velocity_m_per_s),
          std::min(teleop::GoalDrive::Speeds{}.most_rad_per_s,
                   deg_to_rad(options.most_yaw_rate_deg_per_s))};
}

std::string schema(const std::string& properties) {
  return R"({"type":"object","properties":{)" + properties + "}}";
}

const std::string kNumbers =
    R"("x_m":{"type":"number"},"y_m":{"type":"number"},"theta_rad":{"type":"number"})";
const std::string kAnswer =
    schema(R"("ok":{"type":"boolean"},"text":{"type":"string"},"path":{"type":"string"})");

}  // namespace

Orders::Orders(Hub& hub,
               const Source& source,
               ProcmanChannels& procman,
               const teleop::MapFrame& map,
               const SteeringOptions& options)
    : hub_(hub),
      drops_(source.drops),
      bus_(source.live),
      procman_(procman),
      map_(map),
      steering_(options),
      speeds_(goal_speeds(options)),
      slam_(source,
            [this](const Hub::Call& call, const slam::SlamAnswers& answers) {
              answer(call, answers.are_good(),
                     answers.is_empty() ? "SLAM did not answer within 10 s: is it running?"
                                        : answers.text(),
                     answers.path());
            }),
      stop_channel_(add_page_channel(hub, "page/stop")),
      goal_channel_(add_page_channel(hub, "page/goal")) {
  add_services();
  hub_.on_published = [this](const Hub::Published& message) { take_published(message); };
  constexpr const char* kStopLayout = "lbss";
  procman::subscribe_checked<emergency_stop_t>(
      source.in, channels::kEmergencyStop, kStopLayout, drops_,
      [this](const emergency_stop_t& message) {
        emergency_.hear({message.utime, message.engaged != 0, message.sender, message.reason});
        tell_stop();
      });
  source.in.subscribe<base_status_t>(channels::kBaseStatus, drops_,
                                     [this](const base_status_t& status, const auto&) {
                                       if (goal_) goal_->drive.on_status(from_message(status));
                                     });
}

void Orders::answer(const Hub::Call& call,
                    bool ok,
                    const std::string& text,
                    const std::string& path) {
  std::string json =
      std::string(R"({"ok":)") + (ok ? "true" : "false") + R"(,"text":)" + text_json(text);
  if (!path.empty()) json += R"(,"path":)" + text_json(path);
  hub_.answer(call, json + "}");
}

void Orders::serve_anybody(const std::string& name, const std::string& request_schema, Act act) {
  hub_.add_service(name, request_schema, kAnswer,
                   [this, act = std::move(act)](const Hub::Call& call, std::string_view json) {
                     try {
                       require(bus_ != nullptr, kRecording);
                       if (const auto text = act(call, json)) answer(call, true, *text);
                     } catch (const std::invalid_argument& why) {
                       drops_.count(std::string("refused: ") + why.what());
                       answer(call, false, why.what());
                     }
                   });
}

void Orders::serve(const std::string& name, const std::string& request_schema, Act act) {
  serve_anybody(name, request_schema,
                [act = std::move(act)](const Hub::Call& call, std::string_view json) {
                  require(call.may_steer, kReadOnly);
                  return act(call, json);
                });
}

void Orders::add_services() {
  serve("slam", schema(R"("command":{"type":"string"},"folder":{"type":"string"},)" + kNumbers),
        [this](const Hub::Call& call, std::string_view json) {
          slam_.order(call, json);
          return std::nullopt;
        });
  serve("go", schema(kNumbers),
        [this](const Hub::Call& call, std::string_view json) { return go(call, json); });
  serve("end_goal", schema(""), [this](const Hub::Call&, std::string_view) {
    end_goal("ordered in the browser");
    return "the drive has ended";
  });
  serve_anybody("stop", schema(R"("engaged":{"type":"boolean"})"),
                [this](const Hub::Call& call, std::string_view json) { return stop(call, json); });
  serve("head", schema(R"("pan_rad":{"type":"number"},"tilt_rad":{"type":"number"})"),
        [this](const Hub::Call&, std::string_view json) {
          const Json request = parsed(json);
          const PanTiltCommand command{wall_now(), PanTiltCommand::Kind::go_to,
                                       number_of(request, "pan_rad"),
                                       number_of(request, "tilt_rad")};
          bus_->publish(channels::kPanTiltCommand, to_message(command));
          return "the head turns";
        });
  serve("procman", schema(R"("command":{"type":"string"},"action":{"type":"string"})"),
        [this](const Hub::Call&, std::string_view json) {
          const Json request = parsed(json);
          return procman_.order(text_of(request, "command"), text_of(request, "action"));
        });
  serve("record", schema(R"("on":{"type":"boolean"})"),
        [this](const Hub::Call&, std::string_view json) {
          return procman_.order("logger", flag_of(parsed(json), "on") ? "start" : "stop");
        });
  serve("keep", schema(""), [](const Hub::Call&, std::string_view) {
    return "kept: " + recorder::keep_newest(recorder::default_home());
  });
}

std::string Orders::go(const Hub::Call& call, std::string_view json) {
  const Json request = parsed(json);
  require(request.contains("x_m") && request.contains("y_m"), "a goal needs x_m and y_m");
  begin_goal(call.client, {"map", {number_of(request, "x_m"), number_of(request, "y_m"), 0.0}});
  return "on the way";
}

void Orders::begin_goal(Hub::ClientId client, const FramedPose& pose) {
  require(!emergency_.is_engaged(), "the emergency stop is engaged");
  const Utime now = wall_now();
  in_robot(pose, now);  // what is missing is the answer
  goal_ = Goal{client, pose, teleop::GoalDrive(steering_.next_id(now), speeds_, now)};
  steering_.let_go();
  tell_goal(true, "");
}

Eigen::Vector2d Orders::in_robot(const FramedPose& place, Utime now) const {
  const Eigen::Vector2d point_m(place.pose.x_m, place.pose.y_m);
  if (place.frame != "map") return map_.in_robot(point_m, now);
  return map_.in_robot(map_.odom_from_map(now) * point_m, now);
}

void Orders::step_goal(int64_t now_us) {
  if (!goal_) return;
  const double silence_s = hub_.silence_s(goal_->client);
  if (silence_s > kGoalEndsS) return end_goal("its browser disconnected or fell silent");
  if (now_us - goal_->pinged_us > kPingEveryUs) {
    goal_->pinged_us = now_us;
    hub_.ping(goal_->client);
  }
  if (now_us - goal_->sent_us < kGoalEveryUs) return;
  goal_->sent_us = now_us;
  try {
    const Utime now = wall_now();
    const auto order = silence_s > kGoalHoldsS ? goal_->drive.hold(now)
                                               : goal_->drive.next(in_robot(goal_->pose, now), now);
    if (!order && goal_->drive.is_taken_over()) return drop_goal(goal_->drive.why_ended());
    if (!order) return end_goal(goal_->drive.why_ended());
    bus_->publish(channels::kBaseCommand, to_message(*order));
  } catch (const std::invalid_argument& why) {  // SLAM is lost
    end_goal(why.what());
  }
}

void Orders::end_goal(const std::string& why) {
  if (!goal_) return;
  drop_goal(why);
  bus_->publish(channels::kBaseCommand, to_message(steering_.order(BaseCommand{}, wall_now())));
}

void Orders::drop_goal(const std::string& why) {
  tell_goal(false, why.empty() ? "there" : why);
  goal_.reset();
}

void Orders::tell_goal(bool active, const std::string& text) {
  goal_told_ =
      std::string(R"({"active":)") + (active ? "true" : "false") + R"(,"text":)" + text_json(text);
  if (goal_->pose.frame == "map") {
    goal_told_ += R"(,"x_m":)" + foxglove::number(goal_->pose.pose.x_m) + R"(,"y_m":)" +
                  foxglove::number(goal_->pose.pose.y_m);
  }
  hub_.publish(goal_channel_, process::wall_clock_us() * 1000, goal_told_ += "}");
}

std::string Orders::stop(const Hub::Call& call, std::string_view json) {
  const bool engaged = flag_of(parsed(json), "engaged");
  require(engaged || call.may_steer, kReadOnly);
  const int64_t now_us = procman::monotonic_us();
  // The same again is repeated anyway.
  const bool is_again = engaged && emergency_.is_engaged() && now_us - stop_sent_us_ < kStopAgainUs;
  if (!is_again) {
    stop_sent_us_ = now_us;
    const auto what = engaged ? process::EmergencyStop::engage : process::EmergencyStop::release;
    send_stop(emergency_.order(what, "ordered in the browser", process::wall_clock_us(), now_us));
  }
  if (engaged) end_goal("stopped");
  return engaged ? "stopped, until it is released" : "released";
}

void Orders::send_stop(const process::EmergencyStopSender::Message& stop) {
  try {
    process::publish(*bus_, stop);
  } catch (const std::runtime_error&) {
    emergency_.on_refused();  // step() tries again
  }
  tell_stop();
}

std::string Orders::stop_json() const {
  const auto& latest = emergency_.latest();
  const std::string by = latest.sender.substr(0, 40) +
                         (latest.reason.empty() ? "" : ": " + latest.reason.substr(0, 200));
  return std::string(R"({"engaged":)") + (latest.engaged ? "true" : "false") + R"(,"by":)" +
         text_json(by) + "}";
}

void Orders::tell_stop() {
  std::string json = stop_json();
  if (json == stop_told_) return;
  stop_told_ = json;
  hub_.publish(stop_channel_, process::wall_clock_us() * 1000, std::move(json));
}

void Orders::send_known(Hub::ClientId client, uint32_t channel) {
  if (channel != stop_channel_ && channel != goal_channel_) return;
  hub_.publish_to(client, channel, process::wall_clock_us() * 1000,
                  channel == stop_channel_ ? stop_json() : goal_told_);
}

void Orders::take_published(const Hub::Published& message) {
  try {
    require(message.may_steer, kReadOnly);
    require(bus_ != nullptr, kRecording);
    if (message.topic == "/cmd_vel") {
      const Velocity velocity = parse_twist(message.json);
      steering_.drive(message.client, velocity, wall_now());
      if (goal_ && !velocity.is_rest()) drop_goal("somebody is driving manually");
    } else if (message.topic == "/goal_pose") {
      begin_goal(message.client, parse_pose(message.json));
    } else if (message.topic == "/initialpose") {
      const FramedPose pose = parse_pose(message.json);
      require(pose.frame == "map", "a first pose is given in the map");
      slam_command_t command{};
      command.command = slam_command_t::SET_POSE;
      command.x_m = pose.pose.x_m;
      command.y_m = pose.pose.y_m;
      command.theta_rad = pose.pose.theta_rad;
      slam_.send(command);
    } else {
      throw std::invalid_argument("only /cmd_vel, /goal_pose and /initialpose are taken");
    }
  } catch (const std::invalid_argument& why) {
    drops_.count(std::string("refused: ") + why.what());
    hub_.tell(message.client, foxglove::Level::error, why.what());
  }
}

void Orders::forget(Hub::ClientId client) { steering_.forget(client, wall_now()); }

void Orders::step(int64_t now_us) {
  slam_.step(now_us);
  if (bus_ == nullptr) return;
  if (const auto command = steering_.due(wall_now())) {
    bus_->publish(channels::kBaseCommand, to_message(*command));
  }
  step_goal(now_us);
  if (const auto stop = emergency_.due(now_us)) send_stop(*stop);
}

}  // namespace marco::web
