#include "drivers/sick/codec.hpp"

#include <algorithm>

#include "drivers/transport/little_endian.hpp"
#include "lcm_tools/base/check.hpp"

namespace marco::drivers::sick {
namespace {

constexpr std::size_t kOverhead = 6;           // STX, address, length, CRC
constexpr std::size_t kMaxHostPayload = 64;    // the longest request has 36 bytes
constexpr std::size_t kMaxReplyPayload = 300;  // the status block has 154
constexpr std::size_t kMaxScanPayload = 808;
constexpr std::size_t kMaxReflectivityPayload = 1100;  // a byte more for each value

constexpr std::array<std::pair<int, Mode>, 4> kBauds{
    {{9600, kBaud9600}, {19200, kBaud19200}, {38400, kBaud38400}, {500000, kBaud500000}}};

}  // namespace

std::optional<Mode> mode_of_baud(int baud) {
  for (const auto& [one, mode] : kBauds) {
    if (one == baud) return mode;
  }
  return std::nullopt;
}

std::optional<int> baud_of_mode(uint8_t mode) {
  for (const auto& [baud, one] : kBauds) {
    if (one == mode) return baud;
  }
  return std::nullopt;
}

uint16_t crc(std::span<const uint8_t> bytes) {
  uint32_t code = 0;
  uint32_t previous = 0;
  for (const uint8_t byte : bytes) {
    const uint32_t carry = (code & 0x8000) != 0 ? 0x8005u : 0u;
    code = ((code << 1) & 0xFFFF) ^ carry ^ (previous << 8 | byte);
    previous = byte;
  }
  return static_cast<uint16_t>(code);
}

Bytes encode_telegram(uint8_t address, std::span<const uint8_t> payload) {
  require(!payload.empty() && payload.size() <= 0xFFFF, "a telegram has 1 to 65535 bytes");
  Bytes telegram{kStx, address};
  telegram.reserve(payload.size() + kOverhead);
  put_u16(telegram, static_cast<uint16_t>(payload.size()));
  telegram.insert(telegram.end(), payload.begin(), payload.end());
  put_u16(telegram, crc(telegram));
  return telegram;
}

Bytes encode_request(std::span<const uint8_t> payload) { return encode_telegram(0, payload); }

Bytes encode_reply(std::span<const uint8_t> payload, uint8_t status, uint8_t address) {
  Bytes with_status(payload.begin(), payload.end());
  with_status.push_back(status);
  return encode_telegram(address, with_status);
}

Bytes set_mode_request(Mode mode) { return encode_request(Bytes{kSetMode, mode}); }

Bytes installation_request(const std::string& password) {
  require(password.size() == 8, "the laser's password has 8 characters");
  Bytes payload{kSetMode, kInstallation};
  payload.insert(payload.end(), password.begin(), password.end());
  return encode_request(payload);
}

Bytes set_variant_request(int angle_deg, int resolution_cdeg) {
  Bytes payload{kSetVariant};
  put_u16(payload, static_cast<uint16_t>(angle_deg));
  put_u16(payload, static_cast<uint16_t>(resolution_cdeg));
  return encode_request(payload);
}

bool carries_values(uint8_t code) {
  return code == kValuesReply || code == kSubRangeReply || code == kMeanReply ||
         code == kMeanSubRangeReply || code == kReflectivityReply;
}

bool TelegramParser::plausible(std::span<const uint8_t> header) const {
  const bool from_laser = side_ == Side::laser;
  if (header.size() > 1 && (header[1] >= 0x80) != from_laser) return false;
  if (header.size() <= 3) return true;
  const std::size_t length = get_u16(header, 2);
  if (length < (from_laser ? 2u : 1u)) return false;
  if (!from_laser) return length <= kMaxHostPayload;
  if (length > kMaxReflectivityPayload) return false;
  if (header.size() <= 4) return true;
  if (header[4] < 0x80) return false;
  if (header[4] == kReflectivityReply) return true;
  if (length > kMaxScanPayload) return false;
  if (header[4] != kValuesReply) return length <= kMaxReplyPayload || carries_values(header[4]);
  if (header.size() <= 6) return true;
  const std::size_t scan_length = 4u + 2u * (get_u16(header, 5) & 0x3FFu);
  return length == scan_length || length == scan_length + 2;
}

TelegramParser::Look TelegramParser::look(std::span<const uint8_t> from_stx) const {
  if (!plausible(from_stx.first(std::min<std::size_t>(from_stx.size(), 7)))) return Look::nonsense;
  if (from_stx.size() < 4) return Look::incomplete;
  return from_stx.size() < get_u16(from_stx, 2) + kOverhead ? Look::incomplete : Look::telegram;
}

std::optional<Event> TelegramParser::next() {
  while (!unread_.empty()) {
    const std::span<const uint8_t> rest = unread_.rest();
    if (side_ == Side::laser && (rest[0] == kAck || rest[0] == kNak)) {
      unread_.take(1);
      Event event;
      event.kind = rest[0] == kAck ? Event::Kind::ack : Event::Kind::nak;
      event.bytes_total = 1;
      event.bytes_after = rest.size() - 1;
      return event;
    }
    const Look found = rest[0] == kStx ? look(rest) : Look::nonsense;
    if (found == Look::incomplete) return std::nullopt;
    if (found == Look::telegram) {
      const std::size_t length = get_u16(rest, 2);
      Event event;
      event.address = rest[1];
      event.payload = rest.subspan(4, length);
      event.bytes_total = length + kOverhead;
      event.bytes_after = rest.size() - event.bytes_total;
      if (crc(rest.first(length + 4)) == get_u16(rest, length + 4)) {
        unread_.take(event.bytes_total);
        return event;
      }
      ++bad_checksums_;
      unread_.skip();
      event.kind = Event::Kind::bad_checksum;
      return event;
    }
    unread_.skip();
  }
  return std::nullopt;
}

void TelegramParser::give_up_waiting() {
  if (!unread_.empty()) unread_.skip();
}

}  // namespace marco::drivers::sick
