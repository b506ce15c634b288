#include "web/steering.hpp"

#include <algorithm>
#include <cmath>

#include "lcm_tools/base/check.hpp"
#include "web/foxglove/fields.hpp"

namespace marco::web {
namespace {

using Json = nlohmann::json;

constexpr Duration kSendEvery = Duration::from_us(50'000);
constexpr double kFarthestM = 1e5;

const Json& part(const Json& json, const char* name) {
  static const Json kNone;
  if (!json.is_object()) return kNone;
  const auto at = json.find(name);
  return at == json.end() ? kNone : *at;
}

/// Absent is 0.
double number(const Json& json, const char* name) {
  const Json& value = part(json, name);
  if (value.is_null()) return 0.0;
  require(value.is_number(), std::string("an order whose ") + name + " is not a number");
  const auto number = value.get<double>();
  require(std::isfinite(number) && std::abs(number) < kFarthestM,
          std::string("an order whose ") + name + " is not finite or too large");
  return number;
}

Json parsed(std::string_view text) {
  Json json = foxglove::parse_shallow(text);
  require(json.is_object(), "an order that is not a JSON object");
  return json;
}

}  // namespace

Velocity parse_twist(std::string_view json) {
  const Json message = parsed(json);
  const Json& twist = part(message, "twist").is_object() ? part(message, "twist") : message;
  require(part(twist, "linear").is_object() || part(twist, "angular").is_object(),
          "a velocity without linear and angular");
  return {number(part(twist, "linear"), "x"), number(part(twist, "angular"), "z")};
}

FramedPose parse_pose(std::string_view json) {
  const Json message = parsed(json);
  const Json& outer = part(message, "pose");
  const Json& pose = part(outer, "pose").is_object() ? part(outer, "pose") : outer;
  require(part(pose, "position").is_object(), "a pose without a position");
  const Json& turn = part(pose, "orientation");
  const double w = number(turn, "w"), x = number(turn, "x"), y = number(turn, "y"),
               z = number(turn, "z");
  FramedPose framed{
      "map",
      {number(part(pose, "position"), "x"), number(part(pose, "position"), "y"),
       w == 0.0 && z == 0.0 ? 0.0
                            : std::atan2(2.0 * (w * z + x * y), w * w + x * x - y * y - z * z)}};
  const Json& frame = part(part(message, "header"), "frame_id");
  if (frame.is_string() && !frame.get_ref<const std::string&>().empty()) framed.frame = frame;
  if (framed.frame.starts_with('/')) framed.frame.erase(0, 1);
  require(framed.frame == "map" || framed.frame == "odom",
          "a pose in a frame other than map and odom");
  return framed;
}

Steering::Steering(const SteeringOptions& options) : options_(options) {
  validate(options, "steering");
}

int64_t Steering::next_id(Utime now) {
  // Another operator or a tour may count too: ids go by time.
  return id_ = std::max(id_ + 1, now.us / 1000);
}

BaseCommand Steering::order(BaseCommand command, Utime now) {
  command.utime = now;
  command.id = next_id(now);
  return command;
}

void Steering::drive(Client client, Velocity velocity, Utime now) {
  const bool is_held = driver_ != 0 && now >= heard_ && (now - heard_).seconds() < kOrderHoldsS;
  require(!is_held || driver_ == client, "another client drives");
  if (velocity.is_rest()) {
    // A stick at rest orders nothing, unless it was just released: a goal may be active.
    if (driver_ == client) {
      waiting_.reset();
      stop_waits_ = true;
      driver_ = 0;
    }
    return;
  }
  const double yaw_rate = deg_to_rad(options_.most_yaw_rate_deg_per_s);
  driver_ = client;
  heard_ = now;
  stop_waits_ = false;
  waiting_ = {
      std::clamp(velocity.m_per_s, -options_.most_velocity_m_per_s, options_.most_velocity_m_per_s),
      std::clamp(velocity.rad_per_s, -yaw_rate, yaw_rate)};
}

void Steering::let_go() {
  waiting_.reset();
  driver_ = 0;
}

void Steering::forget(Client client, Utime now) {
  if (driver_ == client) drive(client, {}, now);
}

std::optional<BaseCommand> Steering::due(Utime now) {
  if (std::exchange(stop_waits_, false)) return order(BaseCommand{}, now);
  if (!waiting_ || (now >= sent_ && now - sent_ < kSendEvery)) return std::nullopt;
  sent_ = now;
  BaseCommand command;
  command.kind = BaseCommand::Kind::velocity;
  command.velocity_m_per_s = waiting_->m_per_s;
  command.yaw_rate_rad_per_s = waiting_->rad_per_s;
  waiting_.reset();
  return order(command, now);
}

}  // namespace marco::web
