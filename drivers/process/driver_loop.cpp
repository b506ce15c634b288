#include "drivers/process/driver_loop.hpp"

#include <spdlog/spdlog.h>

#include <cmath>
#include <csignal>
#include <future>
#include <thread>
#include <utility>

namespace marco::drivers {
namespace {

using std::chrono::steady_clock;
constexpr std::chrono::milliseconds kReopenAfter{1000};
constexpr std::chrono::milliseconds kNap{50};
// A larger step means that the host's clock was set. It invalidates a session's deadlines and clock
// filters.
constexpr double kClockStepS = 0.5;

double clock_ahead_s() {
  const auto wall = std::chrono::system_clock::now().time_since_epoch();
  const auto steady = steady_clock::now().time_since_epoch();
  return std::chrono::duration<double>(wall - steady).count();
}

double steady_now_s() {
  return std::chrono::duration<double>(steady_clock::now().time_since_epoch()).count();
}

}  // namespace

DriverLoop::DriverLoop(process::Bus& bus,
                       process::DropCounter& drops,
                       DriverLoopOptions options,
                       StartSession start_session)
    : options_(std::move(options)),
      start_session_(std::move(start_session)),
      status_(bus, options_.process, drops) {
  std::signal(SIGPIPE, SIG_IGN);  // a connection or a log that broke must not end who drives
  if (!options_.guardian) return;
  options_.guardian->insert(options_.guardian->begin(),
                            {"--driver", options_.process + " " + std::to_string(getpid())});
  guardian_.emplace(*options_.guardian);
}

void DriverLoop::tick(const std::string& state) {
  if (guardian_) heartbeat_.beat();
  status_.tick(state);
  const auto now = steady_clock::now();
  if (!options_.every_second || now - last_second_ < std::chrono::seconds(1)) return;
  last_second_ = now;
  options_.every_second();
}

std::unique_ptr<ByteStream> DriverLoop::open() {
  const auto open = [this] {
    if (guardian_) guardian_->start();
    return options_.open ? options_.open() : open_stream(options_.address, options_.line);
  };
  if (!guardian_) return open();
  // The host's name, its answer and a port that drains may take seconds, in which the heart beats.
  auto opening = std::async(std::launch::async, open);
  while (opening.wait_for(kNap) != std::future_status::ready) tick("opening " + options_.address);
  return opening.get();
}

void DriverLoop::run(const std::function<bool()>& stop) {
  while (!stop()) {
    try {
      const std::unique_ptr<ByteStream> stream = open();
      spdlog::info("{} is open", options_.address);
      logged_loss_.clear();
      run_session(*stream, stop);
    } catch (const StreamLost& loss) {
      wait_to_reopen(loss.what(), stop);
    }
  }
}

void DriverLoop::run_session(ByteStream& stream, const std::function<bool()>& stop) {
  LineWatch line(options_.address);
  WatchedStream watched(stream, line);
  line.on_line(options_.line);
  logged_trouble_ = LineWatch::Trouble::none;
  std::optional<GuardedStream> guarded;
  if (guardian_) guarded.emplace(watched, *guardian_);
  const std::unique_ptr<DeviceSession> session =
      guarded ? start_session_(*guarded) : start_session_(watched);
  if (guarded) guarded->on_hang = [&session](double seconds) { session->on_hang(seconds); };
  std::string logged;
  double ahead_s = clock_ahead_s();
  while (!stop()) {
    session->step();
    if (guardian_) guardian_->beat(session->stop_bytes());
    for (const double latency_s : session->take_latencies_s()) status_.add_latency(latency_s);
    const double now_ahead_s = clock_ahead_s();
    const double step_s = now_ahead_s - std::exchange(ahead_s, now_ahead_s);
    if (std::abs(step_s) > kClockStepS) {
      spdlog::warn("this host's clock was set by {:.1f} s: the device is restarted", step_s);
      return;
    }
    std::string state = session->state();
    const LineWatch::Trouble trouble = line.judge(session->answers(), steady_now_s());
    log_trouble(line, trouble);
    const bool healthy = trouble == LineWatch::Trouble::none;
    tick(healthy ? state : process::kNoDevice + (" answers: " + line.text()) + "; " + state);
    if (state.substr(0, state.find(',')) != logged.substr(0, logged.find(','))) {
      spdlog::info("{}", state);
      logged = std::move(state);
    }
  }
  session->stop();
}

void DriverLoop::log_trouble(const LineWatch& line, LineWatch::Trouble trouble) {
  if (trouble == std::exchange(logged_trouble_, trouble)) return;
  if (trouble == LineWatch::Trouble::none) {
    spdlog::info("the device answers");
  } else {
    spdlog::warn("{}", line.text());
  }
}

void DriverLoop::wait_to_reopen(const std::string& why, const std::function<bool()>& stop) {
  if (std::exchange(logged_loss_, why) != why) {
    spdlog::warn("{}: {}. Retrying every second", process::kNoDevice, why);
  }
  const auto until = steady_clock::now() + kReopenAfter;
  while (!stop() && steady_clock::now() < until) {
    tick(process::kNoDevice + (": " + why));
    std::this_thread::sleep_for(kNap);
  }
}

}  // namespace marco::drivers
