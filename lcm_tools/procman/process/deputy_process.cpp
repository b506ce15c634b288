#include "lcm_tools/procman/process/deputy_process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <spdlog/spdlog.h>
#include <sys/file.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <filesystem>
#include <random>
#include <utility>

#include "lcm_tools/procman/process/message_check.hpp"
#include "lcm_tools/procman/process/messages.hpp"
#include "procman_lcm/discovery_t.hpp"

namespace marco::procman {
namespace {

constexpr int kMessagesAStep = 200;  // a flood must not keep keepers waiting
constexpr int kSpawnFailedExit = 255 << 8;
constexpr int kLostKeeperExit = SIGKILL;

// Whoever owns it could make this deputy believe in commands that are none.
void refuse_foreign_folder(const std::string& folder) {
  struct stat owner = {};
  if (stat(folder.c_str(), &owner) != 0 || (owner.st_uid != getuid() && owner.st_uid != 0)) {
    throw std::runtime_error("the runtime folder " + folder + " is somebody else's");
  }
}

}  // namespace

DeputyProcess::DeputyProcess(DeputyProcessOptions options)
    : options_(std::move(options)),
      signals_(open_stop_signals()),
      drops_([](const std::string& line) { spdlog::warn(line); }),
      bus_(options_.lcm_url),
      state_(options_.state),
      pump_(options_.output_bytes_per_s) {
  std::signal(SIGCHLD, SIG_IGN);  // keepers that end leave no zombie
  nonce_ = static_cast<int64_t>(std::random_device{}()) << 16 | getpid();
  const std::string& id = options_.state.deputy_id;
  bus_.subscribe<procman_lcm::deputy_info_t>(channels::kInfo, drops_,
                                             [this, id](const auto& message, const auto&) {
                                               if (!serving_ && message.deputy_id == id)
                                                 rival_exit_ = 2;
                                             });
  subscribe_checked<procman_lcm::discovery_t>(
      bus_, channels::kDiscover, layouts::kDiscover, drops_, [this, id](const auto& message) {
        info_wanted_ = true;
        if (!serving_ && message.transmitter_id == id && message.nonce != nonce_) rival_exit_ = 1;
      });
  subscribe_checked<procman_lcm::orders_t>(
      bus_, channels::kOrders, layouts::kOrders, drops_, [this](const auto& message) {
        if (!serving_ || leaving_) return;
        state_.on_orders(from_message(message), wall_clock_us(), monotonic_us());
        do_actions();
      });
}

int DeputyProcess::run() {
  if (const int code = find_rival(); code != 0) {
    spdlog::error("there is a deputy '{}' on this network already", options_.state.deputy_id);
    return code;
  }
  lock_runtime_folder();
  adopt_keepers();
  serving_ = true;
  info_wanted_ = true;
  spdlog::info("deputy '{}' on {}; output of commands in {}", options_.state.deputy_id,
               process::effective_lcm_url(options_.lcm_url), options_.output_folder);
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

void DeputyProcess::lock_runtime_folder() {
  const std::string& folder = options_.runtime_folder;
  std::filesystem::create_directories(folder);
  std::filesystem::create_directories(options_.output_folder);
  chmod(folder.c_str(), 0700);
  refuse_foreign_folder(folder);
  refuse_foreign_folder(std::filesystem::path(folder).parent_path());
  lock_.reset(open(lock_path(folder).c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600));
  if (!lock_.is_open()) throw_errno("cannot open " + lock_path(folder));
  if (flock(lock_.get(), LOCK_EX | LOCK_NB) != 0) {
    throw std::runtime_error("another deputy uses the runtime folder " + folder);
  }
}

void DeputyProcess::adopt_keepers() {
  for (const auto& entry : std::filesystem::directory_iterator(options_.runtime_folder)) {
    if (entry.path().extension() != ".sock") continue;
    auto link = KeeperLink::connect(entry.path());
    if (!link) {
      std::filesystem::remove(entry.path());
      continue;
    }
    pollfd source = {link->fd(), POLLIN, 0};
    poll(&source, 1, 1000);
    bool closed = false;
    const std::vector<KeeperMessage> messages = link->receive(closed);
    if (messages.empty()) continue;
    const KeeperMessage& state = messages.front();
    const std::string id = state.spec.id;
    state_.adopt(state.spec, state.runid, state.pid, monotonic_us());
    pump_.open_run(id, state.output_file, state.output_shown);
    spdlog::info("found '{}' again, pid {}", id, state.pid);
    Run& run = runs_.insert_or_assign(id, Run{std::move(*link), state, state.output_inode, true})
                   .first->second;
    if (state.pid == 0) {  // it ended while there was no deputy
      KeeperMessage ended = state;
      ended.kind = "ended";
      on_keeper_message(id, run, ended);
      continue;
    }
    for (const KeeperMessage& message : messages) on_keeper_message(id, run, message);
  }
  for (const std::string& id : std::exchange(ended_, {})) runs_.erase(id);
  do_actions();
}

void DeputyProcess::step() {
  const int64_t now_us = monotonic_us();
  int64_t next_us = next_info_us_;
  if (info_wanted_ || bus_.waiting()) next_us = now_us;
  for (const auto& due : {state_.next_due_us(), pump_.next_due_us()}) {
    if (due) next_us = std::min(next_us, *due);
  }
  std::vector<pollfd> sources = {{signals_.get(), POLLIN, 0}, {bus_.lcm().getFileno(), POLLIN, 0}};
  std::vector<std::string> ids;
  for (const auto& [id, run] : runs_) {
    sources.push_back({run.link.fd(), POLLIN, 0});
    ids.push_back(id);
  }
  const int64_t wait_us = std::max<int64_t>(next_us - now_us, 0);
  const timespec wait = {wait_us / 1'000'000, (wait_us % 1'000'000) * 1000};
  if (ppoll(sources.data(), sources.size(), &wait, nullptr) < 0 && errno != EINTR) {
    throw_errno("ppoll");
  }
  if (take_stop_signal(signals_) != 0) {
    leaving_ = true;
    state_.shut_down();
  }
  for (int n = 0; n < kMessagesAStep && bus_.handle_once(0); ++n) {
  }
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (sources[i + 2].revents == 0) continue;
    const auto run = runs_.find(ids[i]);
    if (run != runs_.end()) read_keeper(run->first, run->second);
  }
  for (const std::string& id : std::exchange(ended_, {})) runs_.erase(id);
  state_.on_time(monotonic_us());
  do_actions();
  publish_output();
  if (state_.take_changed() || info_wanted_ || monotonic_us() >= next_info_us_) publish_info();
}

void DeputyProcess::read_keeper(const std::string& id, Run& run) {
  bool closed = false;
  for (const KeeperMessage& message : run.link.receive(closed)) on_keeper_message(id, run, message);
  if (closed && !ended_.contains(id)) on_keeper_lost(id, run);
}

void DeputyProcess::on_keeper_message(const std::string& id,
                                      Run& run,
                                      const KeeperMessage& message) {
  if (message.kind == "state" && !run.known) {
    run.known = true;
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
  KeeperMessage release;
  release.kind = "release";
  run.link.send(release);
  ended_.insert(id);
  spdlog::info("'{}' ended: {}", id, describe_exit(message.raw_status));
  state_.on_ended(id, message.raw_status, monotonic_us());
}

void DeputyProcess::on_keeper_lost(const std::string& id, const Run& run) {
  ended_.insert(id);
  if (run.last.pid > 0) {
    for (const pid_t pid : descendants_of(run.last.pid)) kill(pid, SIGKILL);
    kill(run.last.pid, SIGKILL);
  }
  tell({id, run.known ? "its keeper is gone; the command was killed"
                      : "could not be started: the deputy's own messages say why"});
  state_.on_ended(id, run.known ? kLostKeeperExit : kSpawnFailedExit, monotonic_us());
}

void DeputyProcess::do_actions() {
  for (bool again = true; again;) {
    again = false;
    for (const DeputyAction& action : state_.take_actions()) {
      again = true;
      if (const auto* order = std::get_if<StartCommand>(&action)) start(*order);
      if (const auto* order = std::get_if<StopCommand>(&action)) stop(*order);
      if (const auto* line = std::get_if<TellSheriffs>(&action)) tell(*line);
    }
  }
}

std::string DeputyProcess::output_file(const std::string& id) const {
  return options_.output_folder + "/" + file_name_of(id) + ".log";
}

void DeputyProcess::start(const StartCommand& order) {
  const std::string& id = order.spec.id;
  KeeperMessage run;
  run.kind = "run";
  run.spec = order.spec;
  run.runid = order.runid;
  run.output_file = output_file(id);
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
    tell({id, failure.what()});
    state_.on_ended(id, kSpawnFailedExit, monotonic_us());
  }
}

void DeputyProcess::stop(const StopCommand& order) {
  const auto run = runs_.find(order.id);
  if (run == runs_.end()) return;
  KeeperMessage stop;
  stop.kind = "stop";
  stop.signal = order.signal;
  stop.allowed_s = order.allowed_s;
  run->second.link.send(stop);
  spdlog::info("stop '{}': signal {}, {} s allowed", order.id, order.signal, order.allowed_s);
}

void DeputyProcess::tell(const TellSheriffs& line) {
  const bool warns = line.tone == TellSheriffs::Tone::warning;
  spdlog::log(warns ? spdlog::level::warn : spdlog::level::info, "{}{}{}", line.id,
              line.id.empty() ? "" : ": ", line.text);
  pump_.tell(line.id, line.text);
}

}  // namespace marco::procman
