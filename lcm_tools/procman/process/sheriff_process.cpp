#include "lcm_tools/procman/process/sheriff_process.hpp"

#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <ctime>
#include <stdexcept>
#include <utility>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/procman/process/message_check.hpp"
#include "lcm_tools/procman/process/messages.hpp"
#include "procman_lcm/discovery_t.hpp"
#include "procman_lcm/output_span_t.hpp"
#include "procman_lcm/output_t.hpp"

namespace marco::procman {
namespace {

constexpr std::size_t kMaxEvents = 5000;
constexpr std::size_t kMaxEventBytes = 1000;
constexpr std::size_t kMostOtherSheriffs = 1000;
constexpr int64_t kLongWaitUs = 5'000'000;
constexpr std::size_t kLastLines = 5, kLastLineBytes = 200;

std::string new_sheriff_id() {
  char host[256] = "localhost";
  gethostname(host, sizeof host - 1);
  return std::string(host) + ":" + std::to_string(getpid()) + ":" + std::to_string(wall_clock_us());
}

std::string regex_of(const std::string& channel) {
  std::string out;
  for (const char c : channel) {
    if (std::string(".[]{}()*+?^$|\\").find(c) != std::string::npos) out += '\\';
    out += c;
  }
  return out;
}

std::string clock_text() {
  const std::time_t now = std::time(nullptr);
  std::tm local = {};
  localtime_r(&now, &local);
  char text[16];
  std::strftime(text, sizeof text, "%H:%M:%S", &local);
  return text;
}

}  // namespace

SheriffProcess::SheriffProcess(const std::string& lcm_url, Config config, bool observer)
    : config_(std::move(config)),
      signals_(open_stop_signals()),
      bus_(lcm_url),
      state_(new_sheriff_id(), observer),
      watch_(bus_, monotonic_us()),
      emergency_stop_(bus_, drops_, "sheriff") {
  state_.load(config_);
  subscribe();
  ask_who_is_there();
}

void SheriffProcess::ask_who_is_there() {
  procman_lcm::discovery_t question;
  question.utime = wall_clock_us();
  question.transmitter_id = state_.id();
  question.nonce = 0;
  publish(channels::kDiscover, question);
}

void SheriffProcess::require_editable() const {
  require(!state_.observer(), "only watching; o = give orders");
  require(!script_ || script_->state() != ScriptRunner::State::running,
          "a script is running; a = abort it");
}

void SheriffProcess::put_command(const PlacedCommand& placed) {
  require_editable();
  const bool is_new = !state_.commands().contains(placed.command.id);
  procman::put_command(config_, placed);
  state_.put(placed);
  note((is_new ? "new command " : "changed command ") + placed.command.id);
}

void SheriffProcess::remove_command(const std::string& id) {
  require_editable();
  state_.remove(id);
  procman::remove_command(config_, id);
  note("removed command " + id);
}

void SheriffProcess::subscribe() {
  subscribe_checked<procman_lcm::deputy_info_t>(
      bus_, channels::kInfo, layouts::kInfo, drops_, [this](const auto& message) {
        for (const std::string& event :
             state_.on_info(from_message(message), wall_clock_us(), monotonic_us())) {
          note(event);
        }
      });
  subscribe_checked<procman_lcm::orders_t>(
      bus_, channels::kOrders, layouts::kOrders, drops_, [this](const auto& message) {
        if (!state_.on_orders(from_message(message)) || state_.observer()) return;
        if (other_sheriffs_.size() >= kMostOtherSheriffs) return;
        if (!other_sheriffs_.insert(message.sheriff_id).second) return;
        note("another sheriff gives orders: " + message.sheriff_id);
        other_sheriff_seen_ = true;
      });
  subscribe_checked<procman_lcm::output_span_t>(
      bus_, channels::kOutputSpan, layouts::kOutputSpan, drops_, [this](const auto& message) {
        std::vector<OutputSpan> spans;
        for (std::size_t i = 0; i < message.command_ids.size(); ++i) {
          spans.push_back({message.command_ids[i], message.first_bytes[i], message.end_bytes[i],
                           message.files[i]});
        }
        output_.on_span(message.deputy_id, message.utime, std::move(spans));
      });
  subscribe_checked<procman_lcm::output_t>(
      bus_, channels::kOutput, layouts::kOutput, drops_, [this](const auto& message) {
        const auto lines =
            output_.on_output(message.deputy_id, message.utime, message.command_ids, message.text);
        for (const auto& [id, line] : lines) {
          if (id.empty()) note(message.deputy_id + ": " + line);
          if (!id.empty() && on_output_line) on_output_line(id, line);
        }
      });
}

void SheriffProcess::step(int64_t max_wait_us, int extra_fd) {
  const int64_t now_us = monotonic_us();
  int64_t wait_us = std::min<int64_t>(max_wait_us, 200'000);
  if (script_ && script_->next_due_us()) {
    wait_us = std::clamp<int64_t>(*script_->next_due_us() - now_us, 0, wait_us);
  }
  if (bus_.waiting()) wait_us = 0;
  pollfd sources[] = {
      {signals_.get(), POLLIN, 0}, {bus_.lcm().getFileno(), POLLIN, 0}, {extra_fd, POLLIN, 0}};
  const timespec wait = {wait_us / 1'000'000, (wait_us % 1'000'000) * 1000};
  if (ppoll(sources, 3, &wait, nullptr) < 0 && errno != EINTR) throw_errno("ppoll");
  if (take_stop_signal(signals_) != 0) ++stop_signals_;
  // A flood of messages must keep neither orders nor keys waiting.
  for (int n = 0; n < 200 && bus_.handle_once(0); ++n) {
  }
  for (const std::string& event : watch_.step_to(monotonic_us(), state_)) note(event);
  emergency_stop_.step_to(monotonic_us());
  step_script();
  send_due_orders();
}

void SheriffProcess::step_script() {
  if (!script_ || script_->state() != ScriptRunner::State::running) return;
  script_->step(state_, monotonic_us());
  for (const std::string& event : script_->take_events()) note(event);
  if (script_->take_waited_in_vain()) note_last_output(script_->waited_for());
  const auto since_us = script_->waiting_since_us();
  if (!since_us || since_us == told_wait_us_ || monotonic_us() - *since_us < kLongWaitUs) return;
  told_wait_us_ = since_us;
  note("waits for " + script_->waiting_for() + ", for 5 s now");
  note_last_output(script_->waited_for());
}

void SheriffProcess::note_last_output(const std::vector<std::string>& ids) {
  for (const std::string& id : ids) {
    std::vector<std::string> last;
    const auto& lines = output_.lines(id);
    for (auto line = lines.rbegin(); line != lines.rend() && last.size() < kLastLines; ++line) {
      if (!line->empty()) last.push_back(printable(*line).substr(0, kLastLineBytes));
    }
    if (last.empty()) note("  " + id + " has written nothing yet");
    for (auto line = last.rbegin(); line != last.rend(); ++line) note("  " + id + "| " + *line);
  }
}

std::string SheriffProcess::running_text() const {
  std::string text;
  for (const std::string& id : state_.running()) text += (text.empty() ? "" : ", ") + id;
  return text;
}

void SheriffProcess::run_script(const std::string& name) {
  abort_script();
  script_.emplace(config_, name);
  hear_channels_of_script();
}

void SheriffProcess::abort_script() {
  if (script_ && script_->state() == ScriptRunner::State::running) {
    note("script " + script_->name() + " is dropped");
  }
  script_.reset();
}

void SheriffProcess::hear_channels_of_script() {
  for (const std::string& channel : script_->channels()) {
    if (!heard_channels_.insert(channel).second) continue;
    bus_.subscribe_raw(regex_of(channel), [this, channel](const auto&) {
      if (script_) script_->on_message(channel, monotonic_us());
    });
  }
}

std::vector<std::string> SheriffProcess::unsettled() const {
  std::vector<std::string> waiting;
  for (const auto& [id, command] : state_.commands()) {
    if (command.settled()) continue;
    waiting.push_back(command.reported ? id + ": " + status_text(command.status())
                                       : id + ": no deputy '" + command.deputy + "' was heard");
  }
  return waiting;
}

void SheriffProcess::send_due_orders() {
  if (orders_held_) return;
  for (const Orders& orders : state_.take_due_orders(wall_clock_us(), monotonic_us())) {
    publish(channels::kOrders, to_message(orders));
  }
}

void SheriffProcess::note(const std::string& event) {
  events_.push_back(clock_text() + " " + event.substr(0, kMaxEventBytes));
  if (events_.size() > kMaxEvents) events_.pop_front();
  if (on_event) on_event(events_.back());
}

bool SheriffProcess::take_other_sheriff_seen() { return std::exchange(other_sheriff_seen_, false); }

// A network that is down for a while is no reason to end.
template <class Message>
void SheriffProcess::publish(const char* channel, const Message& message) {
  try {
    bus_.publish(channel, message);
    network_down_ = false;
  } catch (const std::runtime_error& failure) {
    if (!std::exchange(network_down_, true)) note(std::string(failure.what()) + "; going on");
  }
}

}  // namespace marco::procman
