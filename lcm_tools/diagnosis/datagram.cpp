#include "lcm_tools/diagnosis/datagram.hpp"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <new>

namespace marco::diagnosis {
namespace {

constexpr uint32_t kShortMagic = 0x4c433032;
constexpr uint32_t kFragmentMagic = 0x4c433033;
constexpr std::size_t kShortHeader = 8;
constexpr std::size_t kFragmentHeader = 20;
constexpr std::size_t kMaxChannel = 63;
constexpr uint32_t kMaxMessageBytes = 256U << 20U;
constexpr std::size_t kMaxPartials = 4;
constexpr uint32_t kRestart = 1U << 24U;

uint32_t word(const uint8_t* bytes) {
  return static_cast<uint32_t>(bytes[0]) << 24U | static_cast<uint32_t>(bytes[1]) << 16U |
         static_cast<uint32_t>(bytes[2]) << 8U | bytes[3];
}

uint16_t half(const uint8_t* bytes) { return static_cast<uint16_t>(bytes[0] << 8U | bytes[1]); }

// Takes "CHANNEL\0" from the front of the payload.
bool take_channel(Datagram& datagram) {
  const std::size_t limit = std::min(datagram.payload.size(), kMaxChannel + 1);
  if (limit == 0) return false;
  const void* end = std::memchr(datagram.payload.data(), 0, limit);
  if (end == nullptr) return false;
  const auto length =
      static_cast<std::size_t>(static_cast<const uint8_t*>(end) - datagram.payload.data());
  datagram.channel = {reinterpret_cast<const char*>(datagram.payload.data()), length};
  datagram.payload = datagram.payload.subspan(length + 1);
  return length > 0;
}

}  // namespace

std::string to_string(const Address& address) {
  std::string result;
  for (unsigned shift = 32; shift > 0; shift -= 8) {
    result += std::to_string(address.ip >> (shift - 8) & 255U) + (shift > 8 ? "." : ":");
  }
  return result + std::to_string(address.port);
}

std::optional<Datagram> parse_datagram(std::span<const uint8_t> bytes) {
  if (bytes.size() < kShortHeader) return {};
  Datagram result;
  const uint32_t magic = word(bytes.data());
  result.sequence = word(bytes.data() + 4);
  if (magic == kShortMagic) {
    result.payload = bytes.subspan(kShortHeader);
    if (!take_channel(result)) return {};
    return result;
  }
  if (magic != kFragmentMagic || bytes.size() < kFragmentHeader) return {};
  result.fragmented = true;
  result.message_bytes = word(bytes.data() + 8);
  result.offset = word(bytes.data() + 12);
  result.fragment = half(bytes.data() + 16);
  result.fragments = half(bytes.data() + 18);
  result.payload = bytes.subspan(kFragmentHeader);
  if (result.fragment == 0 && !take_channel(result)) return {};
  const bool inside = result.message_bytes <= kMaxMessageBytes &&
                      uint64_t{result.offset} + result.payload.size() <= result.message_bytes;
  if (!inside || result.fragment >= result.fragments) return {};
  return result;
}

bool SequenceTracker::add(uint32_t sequence) {
  if (!started_) {
    started_ = true;
    next_ = sequence;
    seen_.fill(true);  // what came before we listened is not missing
  }
  const uint32_t ahead = sequence - next_;
  const uint32_t behind = next_ - sequence;
  if (behind >= 1 && behind <= kWindow) {
    if (seen(sequence)) {
      ++duplicates_;
      return false;
    }
    seen(sequence) = true;
    --lost_;
    return true;
  }
  if (ahead >= kRestart) {
    ++restarts_;
    next_ = sequence;
    seen_.fill(true);
  } else if (ahead > 0) {
    lost_ += ahead;
    if (ahead >= kWindow) {
      seen_.fill(false);
    } else {
      for (; next_ != sequence; ++next_) seen(next_) = false;
    }
  }
  seen(sequence) = true;
  next_ = sequence + 1;
  return true;
}

bool SequenceTracker::add_fragment(uint32_t sequence) {
  const int64_t duplicates = duplicates_;
  const bool fresh = add(sequence);
  duplicates_ = duplicates;
  return fresh;
}

void SequenceTracker::forget_losses() {
  lost_ = duplicates_ = restarts_ = 0;
  seen_.fill(true);  // a late one must not count below 0
}

Reassembler::Partial& Reassembler::partial_of(const Datagram& datagram,
                                              std::vector<std::string>& incomplete) {
  for (Partial& partial : partials_) {
    if (partial.sequence == datagram.sequence && partial.have.size() == datagram.fragments &&
        partial.size == datagram.message_bytes) {
      return partial;
    }
  }
  uint64_t kept = datagram.message_bytes;
  for (const Partial& partial : partials_) kept += partial.size;
  while (!partials_.empty() && (partials_.size() >= kMaxPartials || kept > kMaxMessageBytes)) {
    kept -= partials_.front().size;
    incomplete.push_back(partials_.front().channel);
    partials_.pop_front();
  }
  Partial partial;
  partial.sequence = datagram.sequence;
  partial.size = datagram.message_bytes;
  partial.data.reset(static_cast<uint8_t*>(std::calloc(partial.size + 1, 1)), std::free);
  if (!partial.data) throw std::bad_alloc();
  partial.have.resize(datagram.fragments);
  partial.missing = datagram.fragments;
  partials_.push_back(std::move(partial));
  return partials_.back();
}

bool Reassembler::holds(uint32_t sequence) const {
  return std::any_of(partials_.begin(), partials_.end(),
                     [&](const Partial& partial) { return partial.sequence == sequence; });
}

void Reassembler::give_up(int64_t before_us, std::vector<std::string>& incomplete) {
  while (!partials_.empty() && partials_.front().time_us < before_us) {
    incomplete.push_back(partials_.front().channel);
    partials_.pop_front();
  }
}

std::optional<Reassembler::Message> Reassembler::add(const Datagram& datagram,
                                                     int64_t time_us,
                                                     std::vector<std::string>& incomplete) {
  Partial& partial = partial_of(datagram, incomplete);
  partial.time_us = time_us;
  if (partial.have[datagram.fragment]) return {};
  partial.have[datagram.fragment] = true;
  if (datagram.fragment == 0) partial.channel = datagram.channel;
  std::copy(datagram.payload.begin(), datagram.payload.end(), partial.data.get() + datagram.offset);
  if (--partial.missing > 0) return {};
  Message message{std::move(partial.channel), std::move(partial.data), partial.size};
  for (auto it = partials_.begin(); it != partials_.end(); ++it) {
    if (&*it != &partial) continue;
    // Older ones still open can only be completed by datagrams that overtake each other; they stay
    // until they have to give way.
    partials_.erase(it);
    break;
  }
  return message;
}

}  // namespace marco::diagnosis
