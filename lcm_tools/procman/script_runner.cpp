#include "lcm_tools/procman/script_runner.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include "lcm_tools/base/check.hpp"

namespace marco::procman {
namespace {

// The public procman's pause after a wait, in which reports of the change arrive.
constexpr int64_t kPauseUs = 100'000;

bool has_stopped(Status status) {
  return status == Status::stopped_ok || status == Status::stopped_error;
}

std::string describe_wait(const ScriptAction& action) {
  switch (action.wait->what) {
    case WaitFor::running:
      return action.target.text() + " to run";
    case WaitFor::stopped:
      return action.target.text() + " to stop";
    case WaitFor::publishing:
      break;
  }
  return action.target.text() + " to publish " + action.wait->channel;
}

}  // namespace

std::string describe_action(const ScriptAction& action) {
  switch (action.kind) {
    case ActionKind::start:
      return "start " + action.target.text();
    case ActionKind::stop:
      return "stop " + action.target.text();
    case ActionKind::restart:
      return "restart " + action.target.text();
    case ActionKind::wait_ms:
      return "wait ms " + std::to_string(action.wait_ms);
    case ActionKind::wait_for:
      return "wait for " + describe_wait(action);
    case ActionKind::run_script:
      break;
  }
  return "run_script \"" + action.script + "\"";
}

ScriptRunner::ScriptRunner(const Config& config, const std::string& name)
    : config_(config), name_(name) {
  for (const ScriptConfig& script : config_.scripts) scripts_.emplace(script.name, &script);
  require(scripts_.contains(name), "there is no script \"" + name + "\"");
  const auto mistakes = find_script_mistakes(config_);
  if (const auto at = mistakes.find(name); at != mistakes.end()) {
    std::string why = "script \"" + name + "\" cannot be run";
    for (const std::string& mistake : at->second) why += "; " + mistake;
    require(false, why);
  }
  stack_.push_back({scripts_.at(name)});
  events_.push_back("script " + name + " begins");
}

std::vector<std::string> ScriptRunner::channels() const {
  std::set<std::string> all;
  std::set<std::string> seen = {name_};
  for (std::vector<std::string> open = {name_}; !open.empty();) {
    const ScriptConfig& script = *scripts_.at(open.back());
    open.pop_back();
    for (const ScriptAction& action : script.actions) {
      if (action.wait && action.wait->what == WaitFor::publishing) all.insert(action.wait->channel);
      if (action.kind == ActionKind::run_script && seen.insert(action.script).second) {
        open.push_back(action.script);
      }
    }
  }
  return {all.begin(), all.end()};
}

void ScriptRunner::on_message(const std::string& channel, int64_t now_us) {
  heard_us_[channel] = now_us;
}

ScriptRunner::State ScriptRunner::step(SheriffState& sheriff, int64_t now_us) {
  next_due_us_.reset();
  for (int actions = 0; state_ == State::running; ++actions) {
    if (actions == kMostActionsAStep) {
      next_due_us_ = now_us;
      break;
    }
    if (rest_until_us_ && now_us < *rest_until_us_) {
      next_due_us_ = rest_until_us_;
      break;
    }
    rest_until_us_.reset();
    Frame& frame = stack_.back();
    if (frame.next == frame.script->actions.size()) {
      stack_.pop_back();
      if (stack_.empty()) finish(State::finished, "script " + name_ + " is done");
      continue;
    }
    const ScriptAction& action = frame.script->actions[frame.next];
    if (action.kind == ActionKind::run_script) {
      ++frame.next;
      events_.push_back(describe_action(action));
      stack_.push_back({scripts_.at(action.script)});
      continue;
    }
    const Progress progress =
        action_began_us_ ? check_wait(action, sheriff, now_us) : run(action, sheriff, now_us);
    if (progress != Progress::done) break;
    ++frame.next;
    action_began_us_.reset();
  }
  return state_;
}

ScriptRunner::Progress ScriptRunner::run(const ScriptAction& action,
                                         SheriffState& sheriff,
                                         int64_t now_us) {
  action_began_us_ = now_us;
  events_.push_back(describe_action(action));
  for (const std::string& id : sheriff.commands_of(action.target)) {
    if (action.kind == ActionKind::start) sheriff.start(id);
    if (action.kind == ActionKind::stop) sheriff.stop(id);
    if (action.kind == ActionKind::restart) sheriff.restart(id);
    ordered_runids_[id] = sheriff.commands().at(id).desired_runid;
  }
  if (action.kind == ActionKind::wait_ms) {
    rest_until_us_ = now_us + static_cast<int64_t>(action.wait_ms) * 1000;
    return Progress::done;
  }
  return action.wait ? check_wait(action, sheriff, now_us) : Progress::done;
}

ScriptRunner::Progress ScriptRunner::check_wait(const ScriptAction& action,
                                                const SheriffState& sheriff,
                                                int64_t now_us) {
  const WaitCondition& wait = *action.wait;
  waited_for_ = sheriff.commands_of(action.target);
  if (is_satisfied(action, sheriff)) {
    rest_until_us_ = *action_began_us_ + kPauseUs;
    return Progress::done;
  }
  if (wait.what == WaitFor::publishing) {
    for (const std::string& id : waited_for_) {
      const SheriffCommand& command = sheriff.commands().at(id);
      const bool returns = command.spec.auto_respawn && !command.force_quit;
      if (!has_stopped(command.status()) || returns) continue;
      return give_up(wait, id + " has ended, so waiting for " + describe_wait(action) + " fails (" +
                               action.place.text() + ")");
    }
  }
  if (!wait.timeout_ms) return Progress::waits;
  const int64_t end_us = *action_began_us_ + static_cast<int64_t>(*wait.timeout_ms) * 1000;
  if (now_us < end_us) {
    next_due_us_ = end_us;
    return Progress::waits;
  }
  return give_up(wait, "timed out after " + std::to_string(*wait.timeout_ms) + " ms waiting for " +
                           describe_wait(action) + " (" + action.place.text() + ")");
}

ScriptRunner::Progress ScriptRunner::give_up(const WaitCondition& wait, const std::string& event) {
  wait_failed_ = true;
  if (wait.continue_after_timeout) {
    events_.push_back(event + "; continuing");
    return Progress::done;
  }
  finish(State::aborted, event + "; script " + name_ + " is aborted");
  return Progress::failed;
}

bool ScriptRunner::is_satisfied(const ScriptAction& action, const SheriffState& sheriff) const {
  const WaitCondition& wait = *action.wait;
  const std::vector<std::string> ids = sheriff.commands_of(action.target);
  const bool statuses = std::all_of(ids.begin(), ids.end(), [&](const std::string& id) {
    const SheriffCommand& command = sheriff.commands().at(id);
    const Status status = command.status();
    if (wait.what == WaitFor::publishing) return status == Status::running;
    // A command that ended before anybody saw it run must not hang the script, nor one that
    // somebody else has started again since it stopped.
    const auto ordered = ordered_runids_.find(id);
    const bool another_run = ordered != ordered_runids_.end() && command.reported &&
                             command.reported->actual_runid > ordered->second;
    return has_stopped(status) || (wait.what == WaitFor::stopped && another_run) ||
           (wait.what == WaitFor::running && status == Status::running);
  });
  if (!statuses || wait.what != WaitFor::publishing) return statuses;
  const auto heard = heard_us_.find(wait.channel);
  return heard != heard_us_.end() && heard->second >= *action_began_us_;
}

std::string ScriptRunner::waiting_for() const {
  if (state_ != State::running || !action_began_us_) return "";
  const ScriptAction& action = stack_.back().script->actions[stack_.back().next];
  return action.wait ? describe_wait(action) : "";
}

std::optional<int64_t> ScriptRunner::waiting_since_us() const {
  return waiting_for().empty() ? std::nullopt : action_began_us_;
}

void ScriptRunner::finish(State state, const std::string& event) {
  state_ = state;
  events_.push_back(event);
}

std::vector<std::string> ScriptRunner::take_events() { return std::exchange(events_, {}); }

}  // namespace marco::procman
