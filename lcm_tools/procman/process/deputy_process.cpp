#include "lcm_tools/procman/process/deputy_process.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <random>
#include <utility>

#include "lcm_tools/procman/process/folders.hpp"
#include "lcm_tools/procman/process/message_check.hpp"
#include "lcm_tools/procman/process/messages.hpp"
#include "procman_lcm/output_span_t.hpp"
#include "procman_lcm/output_t.hpp"

namespace marco::procman {
namespace {

constexpr int kMessagesPerStep = 200;  // a flood of messages must not delay the keepers
constexpr int64_t kRivalSearchUs = 500'000;
constexpr int64_t kAskAgainUs = 200'000;
constexpr int64_t kLastOutputUs = 2'000'000;

}  // namespace

DeputyProcess::DeputyProcess(DeputyProcessOptions options)
    : options_(std::move(options)),
      drops_([](const std::string& line) { spdlog::warn(line); }),
      bus_(options_.lcm_url),
      publisher_(bus_, [](const std::string& failure) { spdlog::warn(failure); }),
      state_(options_.state),
      runs_(options_.runs, state_) {
  std::signal(SIGCHLD, SIG_IGN);  // keepers that end leave no zombie
  rivals_.nonce = static_cast<int64_t>(std::random_device{}()) << 16 | getpid();
  subscribe();
}

void DeputyProcess::subscribe() {
  const std::string& id = options_.state.deputy_id;
  bus_.subscribe<procman_lcm::deputy_info_t>(channels::kInfo, drops_,
                                             [this, id](const auto& message, const auto&) {
                                               if (!rivals_.is_over && message.deputy_id == id)
                                                 rivals_.exit_code = 2;
                                             });
  subscribe_checked<procman_lcm::discovery_t>(
      bus_, channels::kDiscover, layouts::kDiscover, drops_, [this, id](const auto& message) {
        info_wanted_ = true;
        const bool is_other = message.transmitter_id == id && message.nonce != rivals_.nonce;
        if (!rivals_.is_over && is_other) rivals_.exit_code = 1;
      });
  subscribe_checked<procman_lcm::orders_t>(
      bus_, channels::kOrders, layouts::kOrders, drops_, [this](const auto& message) {
        if (!rivals_.is_over || leaving_) return;
        state_.on_orders(from_message(message), wall_clock_us(), monotonic_us());
        runs_.do_actions();
      });
}

int DeputyProcess::run() {
  find_rival();
  if (rivals_.exit_code != 0) {
    spdlog::error("there already is a deputy '{}' on this network", options_.state.deputy_id);
    return rivals_.exit_code;
  }
  lock_ = lock_runtime_folder(options_.runs.runtime_folder);
  std::filesystem::create_directories(options_.runs.output_folder);
  runs_.adopt_keepers();
  rivals_.is_over = true;
  info_wanted_ = true;
  spdlog::info("deputy '{}' on {}; output of commands in {}", options_.state.deputy_id,
               process::effective_lcm_url(options_.lcm_url), options_.runs.output_folder);
  if (leaving_) state_.shut_down();
  while (!leaving_ || !state_.all_ended()) step();
  publish_last_output();
  const DeputyState::Refusals& refused = state_.refusals();
  spdlog::info(
      "{}; refused: {} starts, {} stale orders, {} commands too many; {} left out by "
      "sheriffs and kept",
      drops_.summary(), refused.exec, refused.stale, refused.too_many, refused.left_out);
  return 0;
}

void DeputyProcess::find_rival() {
  const int64_t begin_us = monotonic_us();
  int64_t next_us = begin_us;
  for (int64_t now_us = begin_us; now_us < begin_us + kRivalSearchUs && rivals_.exit_code == 0;
       now_us = monotonic_us()) {
    if (now_us >= next_us) {
      publisher_.publish(channels::kDiscover,
                         discovery_message(options_.state.deputy_id, rivals_.nonce));
      next_us += kAskAgainUs;
    }
    bus_.handle_once(10);
    if (signals_.take()) leaving_ = true;
  }
}

void DeputyProcess::step() {
  const int64_t now_us = monotonic_us();
  int64_t next_us = info_wanted_ || bus_.waiting() ? now_us : meter_.next_due_us();
  for (const auto& due : {state_.next_due_us(), runs_.next_output_us()}) {
    if (due) next_us = std::min(next_us, *due);
  }
  std::vector<pollfd> sources = runs_.sources();
  sources.push_back({signals_.fd(), POLLIN, 0});
  sources.push_back({bus_.lcm().getFileno(), POLLIN, 0});
  poll_for(sources, std::max<int64_t>(next_us - now_us, 0));
  if (signals_.take()) {
    leaving_ = true;
    state_.shut_down();
  }
  for (int n = 0; n < kMessagesPerStep && bus_.handle_once(0); ++n) {
  }
  runs_.read(sources);
  state_.on_time(monotonic_us());
  runs_.do_actions();
  publish_output();
  if (state_.take_changed() || info_wanted_ || monotonic_us() >= meter_.next_due_us()) {
    publish_info();
  }
}

void DeputyProcess::publish_info() {
  DeputyInfo info{wall_clock_us(), options_.state.deputy_id, {}, state_.commands()};
  meter_.fill(info, monotonic_us());
  publisher_.publish(channels::kInfo, to_message(info));
  info_wanted_ = false;
}

void DeputyProcess::publish_output() {
  const std::vector<OutputPiece> pieces = runs_.take_output(monotonic_us());
  if (pieces.empty()) return;
  procman_lcm::output_t output;
  procman_lcm::output_span_t span;
  output.utime = span.utime = wall_clock_us();
  output.deputy_id = span.deputy_id = options_.state.deputy_id;
  output.num_commands = span.num_commands = static_cast<int16_t>(pieces.size());
  for (const OutputPiece& piece : pieces) {
    output.command_ids.push_back(piece.id);
    output.text.push_back(piece.text);
    span.command_ids.push_back(piece.id);
    span.first_bytes.push_back(piece.first_byte);
    span.end_bytes.push_back(piece.end_byte);
    span.files.push_back(piece.file);
  }
  publisher_.publish(channels::kOutputSpan, span);
  publisher_.publish(channels::kOutput, output);
}

void DeputyProcess::publish_last_output() {
  publish_info();
  const int64_t end_us = monotonic_us() + kLastOutputUs;
  while (runs_.next_output_us() && monotonic_us() < end_us) {
    publish_output();
    poll_for({}, 5'000);
  }
}

}  // namespace marco::procman
