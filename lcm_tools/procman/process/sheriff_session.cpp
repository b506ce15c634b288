#include "lcm_tools/procman/process/sheriff_session.hpp"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <utility>
#include <vector>

#include "lcm_tools/procman/process/folders.hpp"

namespace marco::procman {
namespace {

constexpr int64_t kListenUs = 600'000;

void say(const std::string& line) {
  std::fprintf(stderr, "marco-procman-sheriff: %s\n", printable(line).c_str());
}

}  // namespace

std::string lone_deputy_log() {
  return default_output_folder() + "/deputy-" + kLoneDeputyId + ".log";
}

std::string find_lone_rival(SheriffProcess& sheriff) {
  sheriff.hold_orders(true);  // its commands are not ours
  const auto is_heard = [&] { return sheriff.state().deputies().contains(kLoneDeputyId); };
  const int64_t end_us = monotonic_us() + kListenUs;
  while (!is_heard() && monotonic_us() < end_us && sheriff.stop_signals() == 0) {
    sheriff.step(50'000, -1);
  }
  const bool at_work = deputy_is_at_work(kLoneDeputyId);
  sheriff.hold_orders(false);
  if (!is_heard() && !at_work) return "";
  const std::string running = sheriff.running_text();
  return std::string("a deputy '") + kLoneDeputyId + "' is already active here" +
         (is_heard() ? "" : " (on another LCM network)") +
         (running.empty() ? "" : " and runs " + running) +
         ": another ./marco run, or a sheriff with -l, is open. Quit that one first; to watch it: "
         "marco-procman-sheriff -o. After being killed it needs some seconds to end";
}

SheriffSession::SheriffSession(SheriffProcess& sheriff, std::optional<LoneDeputyOptions> lone)
    : sheriff_(sheriff), began_(std::time(nullptr)) {
  if (lone) lone_.emplace(std::move(*lone));
}

void SheriffSession::step(int64_t max_wait_us, int extra_fd) {
  sheriff_.step(max_wait_us, extra_fd);
  if (!lone_) return;
  const std::string event = lone_->keep_alive(monotonic_us());
  if (event.empty()) return;
  sheriff_.log().note(event);
  sheriff_.ask_who_is_there();
}

void SheriffSession::say_what_runs() const {
  if (sheriff_.state().observer() && !lone_) return;
  const std::string running = sheriff_.running_text();
  if (running.empty()) return;
  if (lone_) {
    say("stopping: " + running + " (again ^C or SIGTERM: at once)");
  } else {
    say("left running under their deputies: " + running +
        ". A new sheriff with the same file finds them; stopping a deputy stops its commands");
  }
}

// MARCO_RUN is the folder of ./marco run: recordings, map, ports.
void SheriffSession::say_recordings() const {
  const char* folder = std::getenv("MARCO_RUN");
  if (folder == nullptr || *folder == '\0') return;
  std::vector<std::string> found;
  std::error_code none;
  using Entries = std::filesystem::recursive_directory_iterator;
  for (Entries at(folder, none); at != Entries(); at.increment(none)) {
    const auto& entry = *at;
    if (at.depth() >= 2) at.disable_recursion_pending();
    const std::string name = entry.path().filename();
    const auto age = std::filesystem::file_time_type::clock::now() - entry.last_write_time(none);
    const bool is_new = age <= std::chrono::seconds(std::time(nullptr) - began_ + 1);
    if (name.find(".lcm") != std::string::npos && is_new && entry.is_regular_file(none)) {
      found.push_back(entry.path());
    }
  }
  std::sort(found.begin(), found.end());
  for (const std::string& path : found) say("recorded: " + path);
}

void SheriffSession::end() {
  say_what_runs();
  if (lone_) lone_->ask_to_end();
  for (int seen = sheriff_.stop_signals(); lone_ && !lone_->has_ended();) {
    sheriff_.step(100'000, -1);
    if (sheriff_.stop_signals() == seen) continue;
    seen = sheriff_.stop_signals();
    lone_->ask_to_end();
  }
  if (lone_ && !lone_->ended_well()) {
    say(std::string("deputy ") + kLoneDeputyId +
        " died before it could stop them; these may still run: " + sheriff_.running_text() +
        ". Restart this sheriff: it finds them");
  }
  say_recordings();
}

}  // namespace marco::procman
