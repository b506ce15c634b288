#include "lcm_tools/procman/process/command_runs.hpp"

#include <spdlog/spdlog.h>

#include <csignal>
#include <filesystem>
#include <utility>

#include "lcm_tools/process/state_folder.hpp"
#include "lcm_tools/procman/process/notify_socket.hpp"
#include "lcm_tools/procman/process/process_tree.hpp"

namespace marco::procman {
namespace {

constexpr int kSpawnFailedExit = 255 << 8;
constexpr int kLostKeeperExit = SIGKILL;

KeeperMessage message_of(const char* kind) {
  KeeperMessage message;
  message.kind = kind;
  return message;
}

}  // namespace

void CommandRuns::adopt_keepers() {
  for (const auto& entry : std::filesystem::directory_iterator(options_.runtime_folder)) {
    if (entry.path().extension() != ".sock") continue;
    if (auto link = KeeperLink::connect(entry.path())) {
      adopt_keeper(std::move(*link));
    } else {
      for (const char* extension : {".sock", kNotifyExtension}) {
        std::filesystem::remove(std::filesystem::path(entry.path()).replace_extension(extension));
      }
    }
  }
  forget_ended();
  do_actions();
}

void CommandRuns::adopt_keeper(KeeperLink link) {
  pollfd source = {link.fd(), POLLIN, 0};
  poll(&source, 1, 1000);
  bool closed = false;
  std::vector<KeeperMessage> messages = link.receive(closed);
  if (messages.empty()) return;
  const KeeperMessage state = messages.front();
  const std::string id = state.spec.id;
  state_.adopt(state.spec, state.runid, state.pid, monotonic_us());
  pump_.open_run(id, state.output_file, state.output_shown);
  spdlog::info("found '{}' again, pid {}", id, state.pid);
  Run& run = runs_.insert_or_assign(id, Run{std::move(link), state, state.output_inode, true})
                 .first->second;
  if (state.pid == 0) {  // it ended while there was no deputy
    messages.assign(1, state);
    messages.front().kind = "ended";
  }
  for (const KeeperMessage& message : messages) on_message(id, run, message);
}

std::vector<pollfd> CommandRuns::sources() const {
  std::vector<pollfd> sources;
  for (const auto& [id, run] : runs_) sources.push_back({run.link.fd(), POLLIN, 0});
  return sources;
}

void CommandRuns::read(const std::vector<pollfd>& sources) {
  std::set<int> ready;
  for (const pollfd& source : sources) {
    if (source.revents != 0) ready.insert(source.fd);
  }
  for (auto& [id, run] : runs_) {
    if (!ready.contains(run.link.fd())) continue;
    bool closed = false;
    for (const KeeperMessage& message : run.link.receive(closed)) on_message(id, run, message);
    if (closed && !ended_.contains(id)) on_keeper_lost(id, run);
  }
  forget_ended();
}

void CommandRuns::forget_ended() {
  for (const std::string& id : std::exchange(ended_, {})) runs_.erase(id);
}

void CommandRuns::on_message(const std::string& id, Run& run, const KeeperMessage& message) {
  if (message.kind == "state" && !run.is_started) {
    run.is_started = true;
    pump_.open_run(id, message.output_file, message.output_begin);
    run.inode = message.output_inode;
    state_.on_started(id, message.pid);
  }
  if (run.inode != message.output_inode &&
      pump_.open_next_file(id, message.output_file, message.output_inode)) {
    run.inode = message.output_inode;
  }
  if (run.inode == message.output_inode) pump_.on_growth(id, message.output_end);
  if (message.output_lost > run.last.output_lost) {
    pump_.tell(id, std::to_string(message.output_lost - run.last.output_lost) +
                       " bytes of output could not be written to " + message.output_file);
  }
  run.last = message;
  if (message.kind != "ended") return;
  run.link.send(message_of("release"));
  ended_.insert(id);
  spdlog::info("'{}' ended: {}", id, describe_exit(message.raw_status));
  state_.on_ended(id, message.raw_status, monotonic_us(), message.cause);
}

void CommandRuns::on_keeper_lost(const std::string& id, const Run& run) {
  ended_.insert(id);
  if (run.last.pid > 0) {
    for (const pid_t pid : descendants_of(run.last.pid)) kill(pid, SIGKILL);
    kill(run.last.pid, SIGKILL);
  }
  perform(TellSheriffs{
      id, run.is_started ? "its keeper died; the command was killed"
                         : "could not be started: the deputy's own messages give the reason"});
  state_.on_ended(id, run.is_started ? kLostKeeperExit : kSpawnFailedExit, monotonic_us());
}

void CommandRuns::do_actions() {
  for (auto actions = state_.take_actions(); !actions.empty(); actions = state_.take_actions()) {
    for (const DeputyAction& action : actions) {
      std::visit([this](const auto& one) { perform(one); }, action);
    }
  }
}

void CommandRuns::perform(const StartCommand& order) {
  const std::string& id = order.spec.id;
  KeeperMessage run = message_of("run");
  run.spec = order.spec;
  run.runid = order.runid;
  run.output_file = options_.output_folder + "/" + process::file_name_of(id) + ".log";
  run.output_limit = options_.max_file_bytes;
  ended_.erase(id);
  try {
    const std::string socket_path = options_.runtime_folder + "/" + std::to_string(getpid()) + "-" +
                                    std::to_string(++keepers_started_) + ".sock";
    runs_.erase(id);
    runs_.emplace(id,
                  Run{KeeperLink::spawn(options_.keeper_program, socket_path, run), run, 0, false});
    spdlog::info("start '{}': {}", id, order.spec.exec);
  } catch (const std::runtime_error& failure) {
    perform(TellSheriffs{id, failure.what()});
    state_.on_ended(id, kSpawnFailedExit, monotonic_us());
  }
}

void CommandRuns::perform(const StopCommand& order) {
  const auto run = runs_.find(order.id);
  if (run == runs_.end()) return;
  KeeperMessage stop = message_of("stop");
  stop.signal = order.signal;
  stop.allowed_s = order.allowed_s;
  run->second.link.send(stop);
  spdlog::info("stop '{}': signal {}, {} s allowed", order.id, order.signal, order.allowed_s);
}

void CommandRuns::perform(const TellSheriffs& line) {
  const bool warns = line.tone == TellSheriffs::Tone::warning;
  spdlog::log(warns ? spdlog::level::warn : spdlog::level::info, "{}{}{}", line.id,
              line.id.empty() ? "" : ": ", line.text);
  pump_.tell(line.id, line.text);
}

std::vector<OutputPiece> CommandRuns::take_output(int64_t now_us) {
  std::vector<OutputPiece> pieces = pump_.take(now_us);
  for (const OutputPiece& piece : pieces) {
    const auto run = runs_.find(piece.id);
    if (run == runs_.end() || piece.end_byte < 0) continue;
    KeeperMessage shown = message_of("shown");
    const OutputPump::Shown read = pump_.shown(piece.id);
    shown.output_inode = read.inode;
    shown.output_shown = read.bytes;
    run->second.link.send(shown);
  }
  return pieces;
}

}  // namespace marco::procman
