#include "simulator/live/faulty_emulator.hpp"

#include <algorithm>

namespace marco::sim {
namespace {

constexpr Duration kLate = Duration::from_us(500'000);
constexpr int64_t kPeriodUs = 1'000'000, kSilentUs = 400'000;
constexpr unsigned kGarbagePercent = 30;

}  // namespace

bool FaultyEmulator::silent(Utime now) const {
  if (board_.has(device_, FaultKind::off, now)) return true;
  return board_.has(device_, FaultKind::intermittent, now) && now.us % kPeriodUs < kSilentUs;
}

void FaultyEmulator::spoil(std::vector<uint8_t>& bytes) {
  for (uint8_t& byte : bytes) {
    if (random_() % 100 < kGarbagePercent) byte = static_cast<uint8_t>(random_());
  }
}

void FaultyEmulator::receive(std::span<const uint8_t> bytes, int baud, Utime now) {
  inner_.receive(silent(now) ? std::span<const uint8_t>{} : bytes, baud, now);
}

void FaultyEmulator::advance(Utime now, std::vector<uint8_t>& out) {
  std::vector<uint8_t> sent;
  inner_.advance(now, sent);
  if (silent(now)) sent.clear();
  if (board_.has(device_, FaultKind::garbage, now)) spoil(sent);
  // Bytes on their way stay late after the end of the fault, so that the order is kept.
  const bool is_slow = board_.has(device_, FaultKind::slow, now);
  if (is_slow || !late_.empty()) {
    if (!sent.empty()) late_.emplace_back(is_slow ? now + kLate : now, std::move(sent));
    sent.clear();
  }
  while (!late_.empty() && late_.front().first <= now) {
    out.insert(out.end(), late_.front().second.begin(), late_.front().second.end());
    late_.pop_front();
  }
  out.insert(out.end(), sent.begin(), sent.end());
}

Utime FaultyEmulator::next_event() const {
  const Utime next = inner_.next_event();
  return late_.empty() ? next : std::min(next, late_.front().first);
}

void FaultyEmulator::on_connection(bool connected, Utime now) {
  late_.clear();
  inner_.on_connection(connected, now);
}

}  // namespace marco::sim
