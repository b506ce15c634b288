#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <map>
#include <set>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/base/format.hpp"
#include "lcm_tools/log/commands.hpp"
#include "lcm_tools/log/keys.hpp"
#include "lcm_tools/log/player.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "lcm_tools/process/stop_signal.hpp"

namespace marco::logs {
namespace {

int64_t now_us() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

std::string clock_text(Duration duration) {
  const double seconds = duration.seconds();
  return format("%d:%04.1f", static_cast<int>(seconds / 60.0),
                seconds - 60.0 * static_cast<int>(seconds / 60.0));
}

// One line on the terminal: position in the log, speed, and the time to the next event.
class StatusLine {
 public:
  StatusLine() : terminal_(isatty(STDERR_FILENO) == 1) {}
  ~StatusLine() {
    if (drawn_) std::fputs("\r\033[K", stderr);
  }
  StatusLine(const StatusLine&) = delete;
  StatusLine& operator=(const StatusLine&) = delete;

  void draw(const Player& player, std::optional<int64_t> due_us, int64_t now) {
    constexpr int64_t kPeriodUs = 100000;
    if (!terminal_ || (drawn_ && now - last_us_ < kPeriodUs)) return;
    last_us_ = now;
    drawn_ = true;
    const Duration at = player.position() - player.span().first;
    const Duration all = player.span().last - player.span().first;
    const double part = all.us > 0 ? std::clamp(at.seconds() / all.seconds(), 0.0, 1.0) : 0.0;
    constexpr int kWidth = 24;
    std::string bar(kWidth, '-');
    bar[static_cast<std::size_t>(part * (kWidth - 1))] = '#';
    std::string remark;
    if (due_us && *due_us - now > 2000000) {
      remark = "  next in " + clock_text(Duration::from_us(*due_us - now));
    }
    std::fprintf(stderr, "\r%s [%s] %s / %s  x%g%s  %lld events%s\033[K",
                 player.paused() ? "paused " : "playing", bar.c_str(), clock_text(at).c_str(),
                 clock_text(all).c_str(), player.speed(), player.looping() ? "  loop" : "",
                 static_cast<long long>(player.published()), remark.c_str());
  }
  void say(const char* text) {
    if (drawn_) std::fputs("\r\033[K", stderr);
    std::fputs(text, stderr);
    drawn_ = false;
  }
  void soon() { last_us_ = 0; }

 private:
  bool terminal_;
  bool drawn_ = false;
  int64_t last_us_ = 0;
};

void seek_by(Player& player, double seconds, int64_t now) {
  const TimeRange& range = player.range();
  const Utime first = std::max(player.span().first, range.from);
  player.seek(std::max(first, player.position() + Duration::from_seconds(seconds)), now);
}

void mark_loop(Player& player, Key key) {
  TimeRange range = player.range();
  if (key == Key::loop_start) range.from = player.position();
  if (key == Key::loop_end) range.to = player.position() + Duration::from_us(1);
  if (key == Key::loop_clear) range = TimeRange{};
  if (range.from < range.to) player.set_range(range);
  player.set_loop(key != Key::loop_clear || player.looping());
}

// @returns false to quit.
bool handle_key(Player& player, Key key, StatusLine& status, int64_t now) {
  constexpr double kNearS = 5.0, kFarS = 60.0;
  constexpr double kSlowest = 1.0 / 1024, kFastest = 1024.0;
  const double speed = player.speed() > 0.0 ? player.speed() : kFastest;
  switch (key) {
    case Key::pause:
      if (player.finished()) player.rewind(now);
      player.set_paused(!player.paused(), now);
      break;
    case Key::step:
      player.step(now);
      break;
    case Key::back:
      seek_by(player, -kNearS, now);
      break;
    case Key::forward:
      seek_by(player, kNearS, now);
      break;
    case Key::far_back:
      seek_by(player, -kFarS, now);
      break;
    case Key::far_forward:
      seek_by(player, kFarS, now);
      break;
    case Key::start:
      player.rewind(now);
      break;
    case Key::faster:
      player.set_speed(std::min(kFastest, 2.0 * speed), now);
      break;
    case Key::slower:
      player.set_speed(std::max(kSlowest, 0.5 * speed), now);
      break;
    case Key::normal_speed:
      player.set_speed(1.0, now);
      break;
    case Key::loop:
      player.set_loop(!player.looping());
      break;
    case Key::loop_start:
    case Key::loop_end:
    case Key::loop_clear:
      mark_loop(player, key);
      break;
    case Key::help:
      status.say(kKeysHelp);
      break;
    case Key::quit:
      return false;
    case Key::none:
      break;
  }
  status.soon();
  return true;
}

void play(Player& player, bool keys) {
  StatusLine status;
  Keyboard keyboard(keys ? Keyboard::Use::keys : Keyboard::Use::only_wait);
  const bool has_keys = keyboard.is_there();
  if (has_keys) status.say(kKeysHelp);
  require(has_keys || !player.paused(), "--pause needs a terminal: nobody could resume");
  constexpr int64_t kLongestWaitUs = 100000;  // for the status line and signals
  std::string typed;
  while (!process::stop_requested()) {
    const auto due = player.advance(now_us());
    if (player.finished()) {
      if (!keyboard.is_there()) break;
      player.set_paused(true, now_us());  // at the end the user may still seek back
    }
    const int64_t now = now_us();
    status.draw(player, due, now);
    typed += keyboard.wait(std::min(kLongestWaitUs, due ? *due - now : kLongestWaitUs));
    for (Key key = take_key(typed); key != Key::none; key = take_key(typed)) {
      if (!handle_key(player, key, status, now_us())) return;
    }
  }
}

// Publishes the events of a log, but no orders unless asked: a live robot would obey them.
class Publisher {
 public:
  Publisher(const PlayArguments& arguments, process::Bus& bus)
      : renames_(arguments.renames), bus_(bus) {
    if (!arguments.orders) {
      withheld_.insert(arguments.order_channels.begin(), arguments.order_channels.end());
    }
  }

  bool publish(const std::string& recorded, std::span<const uint8_t> bytes, Utime event_time) {
    const std::string channel = renames_(recorded);
    if (withheld_.contains(channel)) {
      ++left_out_[channel];
      return false;
    }
    bus_.publish_raw(channel, bytes, event_time);
    return true;
  }
  void print_left_out() const {
    if (left_out_.empty()) return;
    int64_t total = 0;
    std::string each;
    for (const auto& [channel, count] : left_out_) {
      total += count;
      each += (each.empty() ? "" : ", ") + std::to_string(count) + " on " + channel;
    }
    std::printf("  left out %lld orders that a live robot would obey: %s (--orders plays them)\n",
                static_cast<long long>(total), each.c_str());
  }

 private:
  ChannelRenames renames_;
  std::set<std::string, std::less<>> withheld_;  // channels
  process::Bus& bus_;
  std::map<std::string, int64_t> left_out_;
};

}  // namespace

void run_play(const PlayArguments& arguments) {
  PlayerOptions options;
  options.range = parse_range(arguments.from, arguments.to, span_of_log(arguments.in));
  options.speed = arguments.speed;
  options.loop = arguments.loop;
  options.paused = arguments.paused;
  if (arguments.longest_wait_s > 0.0) {
    options.longest_wait = Duration::from_seconds(arguments.longest_wait_s);
  }
  process::catch_stop_signals();
  process::LcmBus bus(arguments.lcm_url);
  Publisher publisher(arguments, bus);
  Player player(arguments.in,
                ChannelChoice(arguments.channels, arguments.drop ? ChannelChoice::Sense::drop
                                                                 : ChannelChoice::Sense::keep),
                options,
                [&](const std::string& channel, std::span<const uint8_t> bytes, Utime event_time) {
                  return publisher.publish(channel, bytes, event_time);
                });
  const int64_t start_us = now_us();
  play(player, arguments.keys);
  std::printf("%s: %lld events in %.2f s\n", arguments.in.c_str(),
              static_cast<long long>(player.published()),
              Duration::from_us(now_us() - start_us).seconds());
  publisher.print_left_out();
  if (player.damage().places > 0) {
    std::printf("  skipped %lld damaged bytes\n",
                static_cast<long long>(player.damage().bytes_skipped));
  }
}

}  // namespace marco::logs
