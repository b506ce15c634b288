#include "web/process/page.hpp"

#include "lcm_tools/process/wall_clock.hpp"
#include "lcm_tools/procman/process/descriptor.hpp"
#include "lcmtypes/channels.hpp"
#include "marco/map_request_t.hpp"
#include "web/foxglove/json.hpp"

namespace marco::web {
namespace {

constexpr int64_t kWholeUs = 1'000'000;   // a sweep comes in several messages, one after another
constexpr int64_t kApartUs = 10'000'000;  // of two requests

}  // namespace

void ModelRequests::take(const process::RawMessage& message) {
  if (message.channel == channels::kScene) has_new_rows_ = true;
}

void ModelRequests::step(int64_t now_us, bool somebody_watches) {
  if (has_new_rows_) {
    has_new_rows_ = false;
    is_due_ = true;
    heard_us_ = now_us;
  }
  if (live_ == nullptr || !is_due_ || !somebody_watches) return;
  if (now_us - heard_us_ < kWholeUs || now_us - asked_us_ < kApartUs) return;
  is_due_ = false;
  asked_us_ = now_us;
  map_request_t request;
  request.utime = process::wall_clock_us();
  request.channel = channels::kMesh;
  live_->publish(channels::kMapRequest, request);
}

Page::Page(Hub& hub, const Source& source, const SteeringOptions& steering)
    : raw_(hub),
      robot_(hub, source.drops),
      procman_(hub, source.drops, source.in, source.live),
      orders_(hub, source, procman_, robot_.map_frame(), steering),
      model_requests_(source.live),
      hub_(hub),
      health_(hub, source, raw_.decoder()) {
  hub.add_parameter("most_velocity_m_per_s", foxglove::number(steering.most_velocity_m_per_s));
  hub.add_parameter("most_yaw_rate_deg_per_s", foxglove::number(steering.most_yaw_rate_deg_per_s));
  // How late a browser is, by this clock.
  hub.add_service("time", R"({"type":"object"})",
                  R"({"type":"object","properties":{"utime":{"type":"integer"}}})",
                  [&hub](const Hub::Call& call, std::string_view) {
                    hub.answer(call,
                               R"({"utime":)" + std::to_string(process::wall_clock_us()) + "}");
                  });
  hub.on_subscribed = [this](Hub::ClientId client, uint32_t channel) {
    procman_.send_known(client, channel);
    orders_.send_known(client, channel);
  };
  hub.on_part = [this](Hub::ClientId client, uint32_t channel, uint64_t from) {
    return raw_.send_part(client, channel, from) + robot_.send_part(client, channel, from);
  };
  hub.on_closed = [this](Hub::ClientId client) { orders_.forget(client); };
  source.in.subscribe_raw(".*", [this](const process::RawMessage& message) {
    if (!model_parts_.put(message)) take(message);
    model_requests_.take(message);
    health_.take(message);
  });
}

void Page::take(const process::RawMessage& message) {
  raw_.take(message);
  robot_.take(message);
}

void Page::step(Utime now) {
  const int64_t now_us = procman::monotonic_us();
  constexpr int kPartsAtOnce = 2;  // some 10 ms
  model_parts_.give(kPartsAtOnce, [this](const process::RawMessage& part) { take(part); });
  robot_.step(now);
  procman_.step(now_us);
  orders_.step(now_us);
  model_requests_.step(now_us, hub_.clients() > 0);
  for (const std::string& program : procman_.ended_programs()) health_.forget(program);
  health_.step([this] {
    std::vector<HealthFinding> failed;
    for (const auto& [command, text] : procman_.troubles()) {
      failed.push_back(
          {true, command + " ended: " + text,
           "Its last lines of output show the reason. Restart it when that is fixed."});
    }
    return failed;
  });
}

}  // namespace marco::web
