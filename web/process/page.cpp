#include "web/process/page.hpp"

namespace marco::web {

Page::Page(Hub& hub, process::DropCounter& drops) : raw_(hub), robot_(hub, drops) {
  hub.on_subscribed = [this](Hub::ClientId client, uint32_t channel) {
    raw_.send_known(client, channel);
    robot_.send_known(client, channel);
  };
}

void Page::take(const process::RawMessage& message) {
  raw_.take(message);
  robot_.take(message);
}

void Page::step(Utime now) { robot_.step(now); }

}  // namespace marco::web
