#include "lcm_tools/procman/deputy_state.hpp"

#include <sys/wait.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstring>
#include <utility>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/procman/config.hpp"

namespace marco::procman {
namespace {

constexpr int kRefusedExit = 126 << 8;  // as a shell's for what may not be executed
constexpr int64_t kFirstDelayMs = 10;
constexpr int64_t kLongestDelayMs = 1000;
constexpr double kMaxStopTime = 86400.0;
constexpr int64_t kTellAgainUs = 10'000'000;

CommandSpec made_safe(CommandSpec spec) {
  if (spec.stop_signal < 1 || spec.stop_signal > kMaxSignal) spec.stop_signal = 2;
  if (!(spec.stop_time_allowed_s >= 0.0)) spec.stop_time_allowed_s = 7.0;
  spec.stop_time_allowed_s = std::min(spec.stop_time_allowed_s, kMaxStopTime);
  return spec;
}

}  // namespace

DeputyState::DeputyState(DeputyOptions options) : options_(std::move(options)) {
  require(!options_.deputy_id.empty(), "a deputy needs an id");
  require(options_.max_crashes > 0, "max_crashes must be positive");
}

void DeputyState::on_orders(const Orders& orders, int64_t now_utime_us, int64_t now_us) {
  if (orders.deputy_id != options_.deputy_id || shutting_down_) return;
  // In doubles: a foreign stamp may be any number.
  const double age_s =
      1e-6 * (static_cast<double>(now_utime_us) - static_cast<double>(orders.utime_us));
  if (age_s > options_.max_orders_age_s) {
    ++refusals_.stale;
    if (!last_stale_tell_us_ || now_us - *last_stale_tell_us_ > kTellAgainUs) {
      last_stale_tell_us_ = now_us;
      tell("", "ignored orders of " + orders.sheriff_id + " that are " +
                   std::to_string(std::llround(age_s)) + " s old: do the hosts' clocks agree?");
    }
    return;
  }
  std::set<std::string> ordered;
  for (const CommandOrder& order : orders.commands) {
    if (!entries_.contains(order.spec.id) && entries_.size() >= options_.max_commands) {
      ++refusals_.too_many;
      continue;
    }
    ordered.insert(order.spec.id);
    on_order(order, now_us);
  }
  on_left_out(ordered);
}

void DeputyState::on_order(const CommandOrder& order, int64_t now_us) {
  const auto [at, is_new] = entries_.try_emplace(order.spec.id);
  Entry& entry = at->second;
  if (!is_new && refuse_change(entry, order, now_us)) return;
  CommandSpec spec = made_safe(order.spec);
  if (!is_new && order.force_quit && !is_allowed(spec.exec)) spec = entry.spec;
  if (is_new || !(entry.spec == spec)) {
    entry.spec = spec;
    changed_ = true;
  }
  entry.remove_when_ended = false;
  entry.told_left_out = false;
  entry.should_run = !order.force_quit;
  if (order.force_quit) entry.respawn_us.reset();
  if (entry.life != Entry::Life::stopped) {
    on_order_running(entry, order);
  } else if (entry.runid != order.desired_runid && !order.force_quit) {
    entry.crashes = 0;
    entry.delay_ms = 0;
    start(entry, order.desired_runid, now_us);
  } else if (order.desired_runid != 0 && entry.runid != order.desired_runid) {
    entry.runid = entry.reported_runid = order.desired_runid;
    changed_ = true;
  }
}

bool DeputyState::is_allowed(const std::string& exec) const {
  return !options_.allowed_execs || options_.allowed_execs->contains(exec);
}

// Checked before anything is stopped: what is refused would not be started again.
bool DeputyState::refuse_change(Entry& entry, const CommandOrder& order, int64_t now_us) {
  const bool at_work = entry.life != Entry::Life::stopped || entry.respawn_us;
  const bool changes = order.spec.exec != entry.spec.exec ||
                       (order.desired_runid != entry.runid && order.desired_runid != 0);
  if (!at_work || !changes || order.force_quit || is_allowed(order.spec.exec)) return false;
  ++refusals_.exec;
  if (!entry.refused_us || now_us - *entry.refused_us > kTellAgainUs) {
    entry.refused_us = now_us;
    tell(entry.spec.id,
         "keeps running unchanged; refused: none of this deputy's scripts contains: " +
             order.spec.exec);
  }
  return true;
}

void DeputyState::on_order_running(Entry& entry, const CommandOrder& order) {
  const bool another_run = order.desired_runid != entry.runid && order.desired_runid != 0;
  if (another_run && !order.force_quit) {
    entry.next_runid = order.desired_runid;
  } else {
    entry.next_runid.reset();
  }
  if (order.force_quit || another_run) stop(entry, entry.spec.stop_time_allowed_s);
}

void DeputyState::on_left_out(const std::set<std::string>& ordered) {
  for (auto at = entries_.begin(); at != entries_.end();) {
    auto& [id, entry] = *at;
    if (ordered.contains(id)) {
      ++at;
    } else if (!options_.allowed_execs) {
      if (entry.life == Entry::Life::stopped) {
        at = entries_.erase(at);
        changed_ = true;
        continue;
      }
      entry.remove_when_ended = true;
      entry.should_run = false;
      entry.next_runid.reset();
      stop(entry, entry.spec.stop_time_allowed_s);
      ++at;
    } else {
      // Allowed commands stay; refused ones go, or anybody could fill the table.
      const bool refused = entry.life == Entry::Life::stopped && !is_allowed(entry.spec.exec);
      if (entry.life != Entry::Life::stopped && !entry.told_left_out) {
        ++refusals_.left_out;
        entry.told_left_out = true;
        tell(id, "kept running, although a sheriff left it out of its orders");
      }
      changed_ = changed_ || refused;
      at = refused ? entries_.erase(at) : std::next(at);
    }
  }
}

void DeputyState::start(Entry& entry, int32_t runid, int64_t now_us) {
  entry.runid = runid;
  entry.next_runid.reset();
  entry.respawn_us.reset();
  entry.stopping = false;
  if (!is_allowed(entry.spec.exec)) {
    ++refusals_.exec;
    changed_ = true;
    entry.reported_runid = runid;
    entry.exit_code = kRefusedExit;
    tell(entry.spec.id, "refused: none of this deputy's scripts contains: " + entry.spec.exec);
    return;
  }
  entry.life = Entry::Life::starting;
  entry.started_us = now_us;
  actions_.push_back(StartCommand{entry.spec, runid});
}

void DeputyState::stop(Entry& entry, double allowed_s) {
  if (entry.stopping) return;
  entry.stopping = true;
  actions_.push_back(StopCommand{entry.spec.id, entry.spec.stop_signal, allowed_s});
}

void DeputyState::on_started(const std::string& id, int32_t pid) {
  const auto at = entries_.find(id);
  if (at == entries_.end() || at->second.life != Entry::Life::starting) return;
  at->second.life = Entry::Life::running;
  at->second.pid = pid;
  at->second.exit_code = 0;
  at->second.reported_runid = at->second.runid;
  changed_ = true;
}

void DeputyState::on_ended(const std::string& id,
                           int raw_status,
                           int64_t now_us,
                           const std::string& cause) {
  const auto at = entries_.find(id);
  if (at == entries_.end()) return;
  Entry& entry = at->second;
  entry.life = Entry::Life::stopped;
  entry.pid = 0;
  entry.reported_runid = entry.runid;
  entry.exit_code = raw_status;
  changed_ = true;
  tell_end(entry, raw_status, cause);
  if (entry.remove_when_ended) {
    entries_.erase(at);
  } else if (shutting_down_) {
    entry.next_runid.reset();
  } else if (entry.next_runid) {
    entry.crashes = 0;
    entry.delay_ms = 0;
    start(entry, *entry.next_runid, now_us);
  } else if (entry.should_run && entry.spec.auto_respawn && !entry.stopping) {
    plan_respawn(entry, now_us);
  }
}

void DeputyState::tell_end(const Entry& entry, int raw_status, const std::string& cause) {
  if (!cause.empty()) return tell(entry.spec.id, "killed: " + cause);
  if (!WIFSIGNALED(raw_status)) return;
  const int signal = WTERMSIG(raw_status);
  if (entry.stopping && signal == entry.spec.stop_signal) {
    return tell(entry.spec.id, "stopped", TellSheriffs::Tone::information);
  }
  std::string text = strsignal(signal);
  if (entry.stopping && signal == SIGKILL) text += ": it did not stop in the time allowed";
  tell(entry.spec.id, text + (WCOREDUMP(raw_status) ? "\nCore dumped." : ""));
}

void DeputyState::plan_respawn(Entry& entry, int64_t now_us) {
  const double lived_s = static_cast<double>(now_us - entry.started_us) * 1e-6;
  if (lived_s >= options_.healthy_run_s) {
    entry.crashes = 0;
    entry.delay_ms = 0;
  }
  ++entry.crashes;
  if (entry.crashes >= options_.max_crashes) {
    tell(entry.spec.id,
         "gave up: " + std::to_string(entry.crashes) + " starts in a row lasted less than " +
             std::to_string(std::llround(options_.healthy_run_s)) + " s each (last: " +
             describe_exit(entry.exit_code) + "). Start it again when the cause is fixed.");
    return;
  }
  entry.delay_ms = std::clamp(entry.delay_ms * 2, kFirstDelayMs, kLongestDelayMs);
  entry.respawn_us = now_us + entry.delay_ms * 1000;
}

void DeputyState::adopt(const CommandSpec& spec, int32_t runid, int32_t pid, int64_t now_us) {
  Entry& entry = entries_[spec.id];
  entry.spec = made_safe(spec);
  entry.life = Entry::Life::running;
  entry.runid = entry.reported_runid = runid;
  entry.pid = pid;
  entry.should_run = true;
  entry.started_us = now_us;
  changed_ = true;
}

void DeputyState::on_time(int64_t now_us) {
  for (auto& [id, entry] : entries_) {
    if (entry.respawn_us && *entry.respawn_us <= now_us) start(entry, entry.runid, now_us);
  }
}

std::optional<int64_t> DeputyState::next_due_us() const {
  std::optional<int64_t> next;
  for (const auto& [id, entry] : entries_) {
    if (entry.respawn_us && (!next || *entry.respawn_us < *next)) next = entry.respawn_us;
  }
  return next;
}

void DeputyState::shut_down() {
  const bool again = std::exchange(shutting_down_, true);
  for (auto& [id, entry] : entries_) {
    entry.should_run = false;
    entry.respawn_us.reset();
    if (entry.life == Entry::Life::stopped) continue;
    if (again) entry.stopping = false;
    stop(entry, again ? 0.0 : entry.spec.stop_time_allowed_s);
  }
}

bool DeputyState::all_ended() const {
  return std::all_of(entries_.begin(), entries_.end(),
                     [](const auto& item) { return item.second.life == Entry::Life::stopped; });
}

std::vector<DeputyAction> DeputyState::take_actions() { return std::exchange(actions_, {}); }

bool DeputyState::take_changed() { return std::exchange(changed_, false); }

std::vector<CommandStatus> DeputyState::commands() const {
  std::vector<CommandStatus> all;
  for (const auto& [id, entry] : entries_) {
    all.push_back({entry.spec, entry.pid, entry.reported_runid, entry.exit_code, 0.0, 0, 0});
  }
  return all;
}

void DeputyState::tell(const std::string& id, std::string text, TellSheriffs::Tone tone) {
  actions_.push_back(TellSheriffs{id, std::move(text), tone});
}

}  // namespace marco::procman
