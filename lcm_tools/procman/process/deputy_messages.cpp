#include <spdlog/spdlog.h>

#include <algorithm>
#include <ctime>
#include <utility>

#include "lcm_tools/procman/process/deputy_process.hpp"
#include "lcm_tools/procman/process/messages.hpp"
#include "procman_lcm/discovery_t.hpp"
#include "procman_lcm/output_span_t.hpp"
#include "procman_lcm/output_t.hpp"

namespace marco::procman {
namespace {

constexpr int64_t kInfoPeriodUs = 1'000'000;
constexpr int64_t kLastOutputUs = 2'000'000;

}  // namespace

// A network that is down for a while must not end what runs on this host.
template <class Message>
void DeputyProcess::publish(const char* channel, const Message& message) {
  try {
    bus_.publish(channel, message);
    network_down_ = false;
  } catch (const std::runtime_error& failure) {
    if (!std::exchange(network_down_, true)) spdlog::warn("{}; going on", failure.what());
  }
}

int DeputyProcess::find_rival() {
  const int64_t begin_us = monotonic_us();
  const int64_t end_us = begin_us + 500'000;
  int64_t next_us = begin_us;
  for (int64_t now_us = begin_us; now_us < end_us && rival_exit_ == 0; now_us = monotonic_us()) {
    if (now_us >= next_us) {
      procman_lcm::discovery_t question;
      question.utime = wall_clock_us();
      question.transmitter_id = options_.state.deputy_id;
      question.nonce = nonce_;
      publish(channels::kDiscover, question);
      next_us += 200'000;
    }
    bus_.handle_once(10);
    if (take_stop_signal(signals_) != 0) leaving_ = true;
  }
  return rival_exit_;
}

void DeputyProcess::publish_info() {
  const int64_t now_us = monotonic_us();
  DeputyInfo info{wall_clock_us(), options_.state.deputy_id, {}, state_.commands()};
  if (now_us >= next_info_us_) {
    machine_ = meter_.measure_machine();
    std::vector<CommandStatus> measured = info.commands;
    meter_.measure_commands(measured);
    loads_.clear();
    for (CommandStatus& command : measured) loads_[command.spec.id] = command;
    next_info_us_ = now_us + kInfoPeriodUs;
  }
  info.machine = machine_;
  for (CommandStatus& command : info.commands) {
    const auto load = loads_.find(command.spec.id);
    if (load == loads_.end() || load->second.pid != command.pid) continue;
    command.cpu_usage = load->second.cpu_usage;
    command.mem_vsize_bytes = load->second.mem_vsize_bytes;
    command.mem_rss_bytes = load->second.mem_rss_bytes;
  }
  publish(channels::kInfo, to_message(info));
  info_wanted_ = false;
}

void DeputyProcess::publish_output() {
  const std::vector<OutputPiece> pieces = pump_.take(monotonic_us());
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
  publish(channels::kOutputSpan, span);
  publish(channels::kOutput, output);
  for (const OutputPiece& piece : pieces) {
    const auto run = runs_.find(piece.id);
    if (run == runs_.end() || piece.end_byte < 0) continue;
    KeeperMessage shown;
    shown.kind = "shown";
    const OutputPump::Shown read = pump_.shown(piece.id);
    shown.output_inode = read.inode;
    shown.output_shown = read.bytes;
    run->second.link.send(shown);
  }
}

void DeputyProcess::publish_last_output() {
  publish_info();
  const int64_t end_us = monotonic_us() + kLastOutputUs;
  while (pump_.next_due_us() && monotonic_us() < end_us) {
    publish_output();
    const timespec period = {0, 5'000'000};
    nanosleep(&period, nullptr);
  }
}

}  // namespace marco::procman
