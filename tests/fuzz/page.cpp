// What a browser, or somebody in its place, sends to marco-page.
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "tests/fuzz/target.hpp"
#include "web/access.hpp"
#include "web/foxglove/server.hpp"
#include "web/hub.hpp"
#include "web/site.hpp"
#include "web/steering.hpp"

namespace marco::fuzz {
namespace {

/// A client's whole conversation: pieces, each a text or bytes, a moment after the one before.
MARCO_FUZZ(page_client) {
  Input input(bytes);
  double now_s = 0.0;
  process::DropCounter drops;
  web::Hub hub({"page", "s", {}, {}}, drops, [&now_s] { return now_s; });
  web::Steering steering{web::SteeringOptions{}};
  bool was_let_go = false;
  const uint32_t channel = hub.add_channel("LIDAR", "bot_core.planar_lidar_t", "{}");
  hub.add_service("go", "{}", "{}", [&](const web::Hub::Call& call, std::string_view) {
    hub.answer(call, R"({"ok":true})");
  });
  hub.on_subscribed = [&](web::Hub::ClientId client, uint32_t wanted) {
    hub.publish_to(client, wanted, 1, "{}");
  };
  hub.on_part = [&](web::Hub::ClientId client, uint32_t wanted, uint64_t from) {
    hub.publish_to(client, wanted, 1, "{}", from);
    return from < 3 ? from + 1 : 0;
  };
  hub.on_published = [&](const web::Hub::Published& message) {
    const Utime now = Utime::from_us(static_cast<int64_t>(1e6 * now_s));
    try {
      if (message.topic == "/cmd_vel") {
        steering.drive(message.client, web::parse_twist(message.json), now);
      } else {
        const auto goal = web::parse_pose(message.json);
        promise(std::isfinite(goal.pose.x_m) && std::isfinite(goal.pose.y_m), "a goal is a place");
        steering.let_go();
      }
    } catch (const std::invalid_argument&) {
    }
    if (const auto order = steering.due(now)) {
      promise(std::abs(order->velocity_m_per_s) <= web::SteeringOptions{}.most_velocity_m_per_s,
              "nobody drives faster than the limit");
    }
  };
  const auto client = hub.open(
      {[] {}, [&was_let_go](const std::string&) { was_let_go = true; }, [] {}}, {true, ""});
  while (!input.empty() && !was_let_go) {
    const uint8_t kind = input.byte();
    const auto piece = input.piece();
    now_s += 1e-3 * kind;
    if (kind % 2 == 0) {
      hub.take_text(client, {reinterpret_cast<const char*>(piece.data()), piece.size()});
    } else {
      hub.take_binary(client, piece);
    }
    hub.publish(channel, 1, "{}");
    promise(!hub.is_stop(piece), "there is no stop here");
    hub.turns().take_one();
    promise(hub.waiting_bytes() <= web::Hub::kMostWaitingBytes, "what waits is bounded");
  }
  while (const auto message = hub.next_outgoing(client)) {
    if (!message->is_text) continue;
    promise(nlohmann::json::accept(*message->body), "what is said is JSON");
  }
  hub.close(client);
  promise(!hub.wanted(channel), "who is gone listens no more");
}

/// A request's target and headers.
MARCO_FUZZ(page_request) {
  Input input(bytes);
  const auto text = [](std::span<const uint8_t> piece) {
    return std::string(piece.begin(), piece.end());
  };
  const std::string host = text(input.piece()), origin = text(input.piece());
  const std::string token = text(input.piece()), target = text(input.rest());
  const web::Access access("a secret", false, {"https://app.example.org"}, {"robot"});
  std::string why;
  const auto right = access.judge({host, origin, token}, why);
  if (right == web::Access::Right::steer) promise(token == "a secret", "only the token steers");
  promise((right == web::Access::Right::refused) == !why.empty(), "a refusal has its cause");
  web::query_value(target, "token");
  foxglove::choose_subprotocol(target);
  web::Site site([](std::string_view) { return std::optional<std::string_view>(); },
                 "/nowhere/three.js");
  site.show_folder("/nowhere/map", target);  // as a snapshot that was written by anybody
  const auto answer = site.get(target);
  promise(answer.status == 404 || target.starts_with("/snapshot.json") || !answer.body.empty(),
          "there are no files in a folder that is not there");
}

}  // namespace
}  // namespace marco::fuzz
