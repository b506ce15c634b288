#include "lcm_tools/procman/sheriff_state.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "lcm_tools/base/check.hpp"

namespace marco::procman {
namespace {

constexpr int64_t kOrdersPeriodUs = 1'000'000;
constexpr int64_t kMaxInfoAgeUs = 30'000'000;
constexpr int64_t kTellStaleAgainUs = 60'000'000;
constexpr std::size_t kMostDeputies = 1000, kMostCommands = 10000;

CommandSpec spec_of(const PlacedCommand& placed) {
  const CommandConfig& command = placed.command;
  return {command.id,          command.wire_exec(),
          placed.group,        command.auto_respawn,
          command.stop_signal, static_cast<double>(command.stop_time_allowed_s)};
}

}  // namespace

SheriffState::SheriffState(std::string sheriff_id, bool observer)
    : sheriff_id_(std::move(sheriff_id)), observer_(observer) {}

void SheriffState::load(const Config& config) {
  for (const PlacedCommand& placed : all_commands(config)) {
    SheriffCommand& command = commands_[placed.command.id];
    command.spec = spec_of(placed);
    command.label = placed.command.label;
    command.deputy = placed.command.deputy;
    changed_deputies_.insert(command.deputy);
  }
}

SheriffCommand& SheriffState::command(const std::string& id) {
  const auto at = commands_.find(id);
  require(at != commands_.end(), "there is no command \"" + id + "\"");
  return at->second;
}

std::vector<std::string> SheriffState::on_info(const DeputyInfo& info,
                                               int64_t now_utime_us,
                                               int64_t now_us) {
  if (!observer_ && info.utime_us < now_utime_us - kMaxInfoAgeUs) {
    return tell_stale(info, now_utime_us, now_us);
  }
  // Anybody on the network can make up deputies and commands: their numbers are limited.
  const bool is_known = deputies_.contains(info.deputy_id);
  if (!is_known && deputies_.size() >= kMostDeputies) return {};
  std::vector<std::string> events;
  const auto [deputy, is_new] = deputies_.try_emplace(info.deputy_id);
  deputy->second = {info.machine, now_us};
  if (is_new) {
    events.push_back("deputy " + info.deputy_id + " is there");
    changed_deputies_.insert(info.deputy_id);
  }
  std::set<std::string> listed;
  for (const CommandStatus& status : info.commands) {
    if (!commands_.contains(status.spec.id) && commands_.size() >= kMostCommands) continue;
    listed.insert(status.spec.id);
    std::set<std::string>& removed = removed_[info.deputy_id];
    if (removed.contains(status.spec.id)) {
      if (status.pid == 0) continue;
      removed.erase(status.spec.id);  // somebody has started it again
    }
    const auto [at, adopted] = commands_.try_emplace(status.spec.id);
    SheriffCommand& command = at->second;
    if (adopted) {
      command.spec = status.spec;
      command.deputy = info.deputy_id;
      command.desired_runid = status.actual_runid;
      events.push_back("deputy " + info.deputy_id + " has a command " + status.spec.id);
    }
    if (command.deputy != info.deputy_id) continue;
    const Status before = command.status();
    report(command, status, adopted);
    const Status after = command.status();
    if (before != after) {
      std::string event = status.spec.id + ": " + status_text(after);
      if (after == Status::stopped_error) event += ", " + describe_exit(status.exit_code);
      events.push_back(std::move(event));
    }
  }
  std::erase_if(removed_[info.deputy_id],
                [&listed](const std::string& id) { return !listed.contains(id); });
  note_missing(info.deputy_id, listed);
  forget_removed();
  return events;
}

void SheriffState::report(SheriffCommand& command, const CommandStatus& status, bool adopted) {
  const bool first = !command.reported;
  command.reported = status;
  if (first && !adopted) settle_first_report(command);
  if (status.actual_runid > command.desired_runid) {
    // Another sheriff has started it: two sheriffs with run ids of their own would keep
    // restarting it.
    command.desired_runid = status.actual_runid;
    command.force_quit = status.pid == 0;
  }
  if (status.pid == 0 && status.actual_runid == command.desired_runid &&
      !command.spec.auto_respawn) {
    command.force_quit = true;  // or a restarted deputy would run it again
  }
}

std::vector<std::string> SheriffState::tell_stale(const DeputyInfo& info,
                                                  int64_t now_utime_us,
                                                  int64_t now_us) {
  if (!stale_told_us_.contains(info.deputy_id) && stale_told_us_.size() >= kMostDeputies) return {};
  const auto [told, is_new] = stale_told_us_.try_emplace(info.deputy_id, now_us);
  if (!is_new && now_us - told->second < kTellStaleAgainUs) return {};
  told->second = now_us;
  // In doubles: a foreign stamp may be any number.
  const double age_s =
      1e-6 * (static_cast<double>(now_utime_us) - static_cast<double>(info.utime_us));
  return {"deputy " + info.deputy_id + " is ignored: its clock is " +
          std::to_string(std::llround(std::min(age_s, 1e12))) +
          " s behind ours. Synchronize both clocks (chrony, ntp)"};
}

void SheriffState::note_missing(const std::string& deputy, const std::set<std::string>& listed) {
  for (auto& [id, command] : commands_) {
    if (command.deputy != deputy || listed.contains(id)) continue;
    const bool first = !command.reported;
    // A restarted deputy has forgotten everything; orders start its commands again.
    if (!first && command.reported->actual_runid == 0) continue;
    command.reported = CommandStatus{command.spec, 0, 0, 0, 0.0, 0, 0};
    if (first) settle_first_report(command);
    if (command.desired_runid == 0) command.force_quit = true;
    changed_deputies_.insert(deputy);
  }
}

void SheriffState::settle_first_report(SheriffCommand& command) {
  const CommandStatus& status = *command.reported;
  if (command.desired_runid == 0) command.desired_runid = status.actual_runid;
  apply(command, std::exchange(command.intent_, SheriffCommand::Intent::none));
}

bool SheriffState::on_orders(const Orders& orders) {
  if (orders.sheriff_id == sheriff_id_) return false;
  if (!observer_) {
    if (orders.sheriff_id.starts_with(kGuest)) adopt(orders);
    return true;
  }
  for (const CommandOrder& order : orders.commands) {
    if (!commands_.contains(order.spec.id) && commands_.size() >= kMostCommands) continue;
    SheriffCommand& command = commands_[order.spec.id];
    command.spec = order.spec;
    command.deputy = orders.deputy_id;
    command.desired_runid = order.desired_runid;
    command.force_quit = order.force_quit;
  }
  return true;
}

// A guest repeats the reports on all other commands: only newer ones count.
void SheriffState::adopt(const Orders& guests) {
  for (const CommandOrder& order : guests.commands) {
    const auto at = commands_.find(order.spec.id);
    if (at == commands_.end() || at->second.deputy != guests.deputy_id) continue;
    SheriffCommand& command = at->second;
    if (order.desired_runid < command.desired_runid) continue;
    command.force_quit =
        order.force_quit || (command.force_quit && order.desired_runid == command.desired_runid);
    command.desired_runid = order.desired_runid;
  }
}

void SheriffState::apply(SheriffCommand& command, SheriffCommand::Intent intent) {
  using Intent = SheriffCommand::Intent;
  if (intent == Intent::none) return;
  if (!command.reported) {
    command.intent_ = intent;
    return;
  }
  const bool runs =
      command.reported->pid != 0 || command.desired_runid != command.reported->actual_runid;
  if (intent == Intent::stop) {
    command.force_quit = true;
  } else if (intent == Intent::restart || !runs || command.force_quit) {
    // A deputy may report any run id; only that it differs counts.
    const int32_t last = std::max(command.desired_runid, command.reported->actual_runid);
    command.desired_runid = last < std::numeric_limits<int32_t>::max() ? last + 1 : 1;
    command.force_quit = false;
  }
  changed_deputies_.insert(command.deputy);
}

void SheriffState::start(const std::string& id) {
  apply(command(id), SheriffCommand::Intent::start);
}
void SheriffState::stop(const std::string& id) { apply(command(id), SheriffCommand::Intent::stop); }
void SheriffState::restart(const std::string& id) {
  apply(command(id), SheriffCommand::Intent::restart);
}

void SheriffState::put(const PlacedCommand& placed) {
  const auto [at, added] = commands_.try_emplace(placed.command.id);
  SheriffCommand& command = at->second;
  if (!added && command.deputy != placed.command.deputy) {
    removed_[command.deputy].insert(placed.command.id);
    changed_deputies_.insert(command.deputy);
    command = {};
  }
  command.spec = spec_of(placed);
  command.label = placed.command.label;
  command.deputy = placed.command.deputy;
  command.removing = false;
  removed_[command.deputy].erase(placed.command.id);
  changed_deputies_.insert(command.deputy);
}

void SheriffState::remove(const std::string& id) {
  SheriffCommand& gone = command(id);
  gone.removing = gone.force_quit = true;
  changed_deputies_.insert(gone.deputy);
  forget_removed();
}

void SheriffState::forget_removed() {
  for (auto at = commands_.begin(); at != commands_.end();) {
    const SheriffCommand& command = at->second;
    const bool runs = command.reported && command.reported->pid != 0;
    if (!command.removing || runs) {
      ++at;
      continue;
    }
    removed_[command.deputy].insert(at->first);
    changed_deputies_.insert(command.deputy);
    at = commands_.erase(at);
  }
}

Orders SheriffState::single_order(const std::string& id,
                                  const std::string& action,
                                  int64_t now_utime_us,
                                  int64_t now_us) {
  const auto at = commands_.find(id);
  require(at != commands_.end(), "there is no command \"" + id.substr(0, 100) + "\"");
  const std::string& deputy = at->second.deputy;
  require(at->second.reported.has_value(),
          "deputy '" + deputy + "' of this command does not answer");
  if (action == "start") {
    start(id);
  } else if (action == "stop") {
    stop(id);
  } else {
    require(action == "restart", "procman starts, stops or restarts");
    restart(id);
  }
  observer_ = false;
  std::vector<Orders> due = take_due_orders(now_utime_us, now_us);
  observer_ = true;
  const auto orders = std::find_if(due.begin(), due.end(),
                                   [&](const Orders& one) { return one.deputy_id == deputy; });
  require(orders != due.end(), "deputy '" + deputy + "' no longer answers");
  return std::move(*orders);
}

std::vector<Orders> SheriffState::take_due_orders(int64_t now_utime_us, int64_t now_us) {
  std::vector<Orders> due;
  if (observer_) return due;
  for (const auto& [deputy, state] : deputies_) {
    const auto [sent, never] = orders_sent_us_.try_emplace(deputy, 0);
    const bool changed = changed_deputies_.erase(deputy) > 0;
    if (!never && !changed && now_us - sent->second < kOrdersPeriodUs) continue;
    sent->second = now_us;
    Orders orders{now_utime_us, deputy, sheriff_id_, {}};
    for (const auto& [id, command] : commands_) {
      if (command.deputy != deputy) continue;
      orders.commands.push_back({command.spec, command.desired_runid, command.force_quit});
    }
    if (!orders.commands.empty() || !never) due.push_back(std::move(orders));
  }
  return due;
}

std::vector<std::string> SheriffState::running() const {
  std::vector<std::string> ids;
  for (const auto& [id, command] : commands_) {
    if (command.reported && command.reported->pid != 0) ids.push_back(id);
  }
  return ids;
}

std::vector<std::string> SheriffState::commands_of(const Target& target) const {
  std::vector<std::string> ids;
  for (const auto& [id, command] : commands_) {
    const bool meant =
        target.kind == TargetKind::everything ||
        (target.kind == TargetKind::command &&
         (id == target.name || (!command.label.empty() && command.label == target.name))) ||
        (target.kind == TargetKind::group && group_is_within(command.spec.group, target.name));
    if (meant) ids.push_back(id);
  }
  return ids;
}

}  // namespace marco::procman
