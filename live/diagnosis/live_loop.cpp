#include "live/diagnosis/live_loop.hpp"

#include <spdlog/spdlog.h>

#include <utility>

#include "lcm_tools/process/stop_signal.hpp"

namespace marco::diagnosis {

LiveLoop::LiveLoop(process::LcmBus& bus,
                   const SilenceWatch::Options& options,
                   Voice voice,
                   const std::string& started)
    : bus_(bus),
      status_(bus, options.program, *options.drops),
      silence_(bus, options),
      voice_(std::move(voice)) {
  spdlog::info("listening on {}{}", process::effective_lcm_url(options.url), started);
}

void LiveLoop::run_until_stopped() {
  while (!process::stop_requested()) {
    bus_.handle_once(100);
    log_note(silence_.step());
    status_.tick(silence_.state(voice_.state()));
    say_replies();
  }
}

void LiveLoop::say_replies() {
  if (!voice_.reply) return;
  for (std::string reply = voice_.reply(); !reply.empty(); reply = voice_.reply()) {
    spdlog::info("{}", reply);
    status_.send(reply);
  }
}

}  // namespace marco::diagnosis
