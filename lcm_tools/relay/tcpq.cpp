#include "lcm_tools/relay/tcpq.hpp"

#include "lcm_tools/base/check.hpp"

namespace marco::relay {
namespace {

constexpr uint32_t kServerMagic = 0x287617fa;
constexpr uint32_t kClientMagic = 0x287617fb;
constexpr uint32_t kVersion = 0x0100;

uint32_t magic_of(Role role) { return role == Role::server ? kServerMagic : kClientMagic; }

void put(std::string& to, uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) to += static_cast<char>(value >> shift);
}

void put(std::string& to, std::string_view text) {
  put(to, static_cast<uint32_t>(text.size()));
  to += text;
}

}  // namespace

std::string greeting_of(Role role) {
  std::string bytes;
  put(bytes, magic_of(role));
  put(bytes, kVersion);
  return bytes;
}

void append_publish(std::string& to, std::string_view channel, std::span<const uint8_t> data) {
  put(to, static_cast<uint32_t>(Frame::Kind::publish));
  put(to, channel);
  put(to, std::string_view(reinterpret_cast<const char*>(data.data()), data.size()));
}

void append_subscribe(std::string& to, std::string_view expression) {
  put(to, static_cast<uint32_t>(Frame::Kind::subscribe));
  put(to, expression);
}

void FrameReader::add(std::span<const uint8_t> bytes) {
  bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(used_));
  used_ = 0;
  bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
}

std::optional<uint32_t> FrameReader::number_at(std::size_t at) const {
  if (bytes_.size() < at + 4) return std::nullopt;
  uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value = value << 8U | bytes_[at + i];
  return value;
}

bool FrameReader::read_greeting() {
  const auto magic = number_at(used_);
  require(!magic || *magic == magic_of(sender_), "it does not use LCM's tcpq");
  const auto version = number_at(used_ + 4);
  require(!version || *version == kVersion, "it uses another version of LCM's tcpq");
  if (!version) return false;
  used_ += 8;
  return is_greeted_ = true;
}

std::optional<Frame> FrameReader::next() {
  if (!is_greeted_ && !read_greeting()) return std::nullopt;
  const auto kind = number_at(used_);
  const auto name_bytes = number_at(used_ + 4);
  require(!kind || (*kind >= 1 && *kind <= 3), "an unknown type of tcpq frame");
  require(!name_bytes || *name_bytes <= kMostName, "a channel's name is too long");
  if (!name_bytes) return std::nullopt;
  Frame frame;
  frame.kind = static_cast<Frame::Kind>(*kind);
  const std::size_t name_at = used_ + 8;
  std::size_t end = name_at + *name_bytes;
  uint32_t data_bytes = 0;
  if (frame.kind == Frame::Kind::publish) {
    const auto told = number_at(end);
    require(!told || *told <= kMostData, "a message is larger than 64 MB");
    if (!told) return std::nullopt;
    data_bytes = *told;
    end += 4 + data_bytes;
  }
  if (bytes_.size() < end) return std::nullopt;
  const auto at = [this](std::size_t offset) {
    return bytes_.begin() + static_cast<std::ptrdiff_t>(offset);
  };
  frame.channel.assign(at(name_at), at(name_at + *name_bytes));
  frame.data.assign(at(end - data_bytes), at(end));
  used_ = end;
  return frame;
}

}  // namespace marco::relay
