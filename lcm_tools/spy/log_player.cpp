#include "lcm_tools/spy/log_player.hpp"

#include <algorithm>
#include <chrono>

namespace marco::spy {
namespace {

using Clock = std::chrono::steady_clock;
constexpr int64_t kLongestGapUs = 60'000'000;

}  // namespace

int64_t bounded_time_us(const files::LogEvent& event) {
  return std::clamp<int64_t>(event.event_time.us, 0, int64_t{1} << 60U);
}

std::string damage_text(const files::LogDamage& damage) {
  return "the log is damaged: " + std::to_string(damage.places) + " places, " +
         std::to_string(damage.bytes_skipped) + " bytes skipped";
}

LogPlayer::LogPlayer(const Options& options, SharedModel& shared)
    : options_(options), shared_(shared), reader_(options.path), thread_([this] { run(); }) {}

LogPlayer::~LogPlayer() {
  stop_ = true;
  thread_.join();
}

void LogPlayer::run() {
  std::optional<int64_t> first_us;
  while (const auto event = reader_.next()) {
    const int64_t time_us = bounded_time_us(*event);
    if (!first_us) {
      first_us = time_us;
      now_us_ = time_us;
    }
    const double into_log_s = static_cast<double>(time_us - *first_us) * 1e-6;
    if (options_.duration_s > 0 && into_log_s > options_.duration_s) break;
    if (options_.speed > 0) wait_for(time_us);
    if (stop_) return;
    now_us_ = std::max(now_us_.load(), time_us);
    const SharedModel::Look look(shared_);
    shared_.model.add_message(time_us, event->channel, event->bytes);
  }
  ended_ = true;
}

void LogPlayer::wait_for(int64_t time_us) {
  if (time_us - now_us_ > kLongestGapUs) now_us_ = time_us;
  auto last = Clock::now();
  while (!stop_ && now_us_ < time_us) {
    const double left_us = static_cast<double>(time_us - now_us_) / options_.speed;
    std::this_thread::sleep_for(
        std::chrono::duration<double, std::micro>(std::clamp(left_us, 1.0, 20000.0)));
    const auto now = Clock::now();
    if (!paused_) {
      const double passed_us = std::chrono::duration<double, std::micro>(now - last).count();
      now_us_ += static_cast<int64_t>(passed_us * options_.speed);
    }
    last = now;
  }
}

}  // namespace marco::spy
