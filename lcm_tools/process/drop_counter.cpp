#include "lcm_tools/process/drop_counter.hpp"

#include <chrono>

namespace marco::process {
namespace {

// A stream of hostile messages must not grow the table: past this, causes share one entry.
constexpr std::size_t kMaxCauses = 64;

int64_t steady_seconds() {
  return std::chrono::duration_cast<std::chrono::seconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

}  // namespace

void DropCounter::count(const std::string& cause) {
  const bool known = by_cause_.contains(cause) || by_cause_.size() < kMaxCauses;
  const std::string& key = known ? cause : "other";
  const int64_t total = ++by_cause_[key];
  if (!warn_) return;
  const int64_t now_s = steady_seconds();
  const auto [last, first_time] = last_warning_s_.try_emplace(key, now_s);
  if (!first_time && last->second == now_s) return;
  last->second = now_s;
  warn_("dropped: " + key + " (" + std::to_string(total) + " so far)");
}

int64_t DropCounter::dropped() const {
  int64_t sum = 0;
  for (const auto& [cause, count] : by_cause_) sum += count;
  return sum;
}

std::string DropCounter::summary() const {
  std::string text =
      std::to_string(received_) + " received, " + std::to_string(dropped()) + " dropped";
  const char* separator = ": ";
  for (const auto& [cause, count] : by_cause_) {
    text += separator + cause + " " + std::to_string(count);
    separator = ", ";
  }
  return text;
}

}  // namespace marco::process
