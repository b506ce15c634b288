#include "lcm_tools/relay/echo_filter.hpp"

#include <functional>

namespace marco::relay {
namespace {

constexpr int64_t kMemoryUs = 1'000'000;

}  // namespace

uint64_t EchoFilter::key(int side, std::string_view channel, std::span<const uint8_t> data) {
  const std::hash<std::string_view> hash;
  const std::string_view bytes(reinterpret_cast<const char*>(data.data()), data.size());
  constexpr uint64_t kPrime = 0x9E3779B97F4A7C15;  // the golden ratio, as in Fibonacci hashing
  return (hash(bytes) * kPrime + hash(channel)) * kPrime + static_cast<uint64_t>(side);
}

void EchoFilter::forget_before(int64_t time_us) {
  while (!sent_.empty() && sent_.front().time_us < time_us) {
    const auto count = counts_.find(sent_.front().key);
    if (--count->second == 0) counts_.erase(count);
    sent_.pop_front();
  }
}

void EchoFilter::note_sent(int side,
                           std::string_view channel,
                           std::span<const uint8_t> data,
                           int64_t now_us) {
  forget_before(now_us - kMemoryUs);
  sent_.push_back({now_us, key(side, channel, data)});
  ++counts_[sent_.back().key];
}

bool EchoFilter::is_echo(int side,
                         std::string_view channel,
                         std::span<const uint8_t> data,
                         int64_t now_us) {
  forget_before(now_us - kMemoryUs);
  return counts_.contains(key(side, channel, data));
}

}  // namespace marco::relay
