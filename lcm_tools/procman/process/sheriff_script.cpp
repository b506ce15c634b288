#include "lcm_tools/procman/process/sheriff_script.hpp"

#include <algorithm>

#include "lcm_tools/procman/process/descriptor.hpp"

namespace marco::procman {
namespace {

constexpr int64_t kLongWaitUs = 5'000'000;

std::string regex_of(const std::string& channel) {
  std::string out;
  for (const char c : channel) {
    if (std::string(".[]{}()*+?^$|\\").find(c) != std::string::npos) out += '\\';
    out += c;
  }
  return out;
}

}  // namespace

void SheriffScript::run(const std::string& name) {
  abort();
  runner_.emplace(config_, name);
  for (const std::string& channel : runner_->channels()) {
    if (!subscribed_.insert(channel).second) continue;
    bus_.subscribe_raw(regex_of(channel), [this, channel](const auto&) {
      if (runner_) runner_->on_message(channel, monotonic_us());
    });
  }
}

void SheriffScript::abort() {
  if (is_running()) log_.note("script " + runner_->name() + " is aborted");
  runner_.reset();
}

int64_t SheriffScript::wait_us(int64_t max_wait_us) const {
  if (!runner_ || !runner_->next_due_us()) return max_wait_us;
  return std::clamp<int64_t>(*runner_->next_due_us() - monotonic_us(), 0, max_wait_us);
}

void SheriffScript::step(SheriffState& state) {
  if (!is_running()) return;
  runner_->step(state, monotonic_us());
  for (const std::string& event : runner_->take_events()) log_.note(event);
  if (runner_->take_wait_failed()) note_last_output();
  const auto since_us = runner_->waiting_since_us();
  if (!since_us || since_us == told_wait_us_ || monotonic_us() - *since_us < kLongWaitUs) return;
  told_wait_us_ = since_us;
  log_.note("waits for " + runner_->waiting_for() + ", for 5 s now");
  note_last_output();
}

void SheriffScript::note_last_output() {
  for (const std::string& id : runner_->waited_for()) log_.note_last_output(id);
}

std::string SheriffScript::progress_text() const {
  if (!is_running()) return "";
  const std::string waits = runner_->waiting_for();
  return "script " + runner_->name() + " is running" +
         (waits.empty() ? "" : ", waits for " + waits);
}

}  // namespace marco::procman
