#include "drivers/sick/codec.hpp"

#include <algorithm>

#include "common/check.hpp"

namespace marco::drivers::sick {
namespace {

constexpr std::size_t kOverhead = 6;           // STX, address, length, CRC
constexpr std::size_t kMaxHostPayload = 64;    // the longest request has 36 bytes
constexpr std::size_t kMaxReplyPayload = 300;  // the status block has 154
constexpr std::size_t kMaxScanPayload = 808;
constexpr int kStatusBytes = 152;
constexpr int kOldStatusBytes = 146;

uint16_t u16(std::span<const uint8_t> bytes, std::size_t at) {
  return static_cast<uint16_t>(bytes[at] | bytes[at + 1] << 8);
}

void put_u16(Bytes& bytes, uint16_t value) {
  bytes.push_back(static_cast<uint8_t>(value));
  bytes.push_back(static_cast<uint8_t>(value >> 8));
}

void set_u16(Bytes& bytes, std::size_t at, int value) {
  bytes[at] = static_cast<uint8_t>(value);
  bytes[at + 1] = static_cast<uint8_t>(value >> 8);
}

// Codes are counted from the top of the distance: 8191 (no echo) down to 8183 (beyond range).
constexpr std::array<std::pair<int, Special>, 6> kSpecials{{{0, Special::no_echo},
                                                            {1, Special::dazzled},
                                                            {2, Special::overflow},
                                                            {4, Special::noise},
                                                            {5, Special::read_error},
                                                            {8, Special::beyond_range}}};

struct BaudWord {
  int baud;
  Mode mode;
  int status_word;
};
constexpr std::array<BaudWord, 4> kBauds{{{9600, kBaud9600, 0x8067},
                                          {19200, kBaud19200, 0x8033},
                                          {38400, kBaud38400, 0x8019},
                                          {500000, kBaud500000, 0x8001}}};

std::string text_of(std::span<const uint8_t> bytes) {
  std::string text(bytes.begin(), bytes.end());
  text.erase(std::find(text.begin(), text.end(), '\0'), text.end());
  while (!text.empty() && text.back() == ' ') text.pop_back();
  return text;
}

}  // namespace

std::optional<Mode> mode_of_baud(int baud) {
  for (const BaudWord& one : kBauds) {
    if (one.baud == baud) return one.mode;
  }
  return std::nullopt;
}

std::optional<int> baud_of_mode(uint8_t mode) {
  for (const BaudWord& one : kBauds) {
    if (one.mode == mode) return one.baud;
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

void TelegramParser::push(std::span<const uint8_t> bytes) {
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(head_));
  head_ = 0;
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
}

bool TelegramParser::plausible(std::span<const uint8_t> header) const {
  const bool from_laser = side_ == Side::laser;
  if (header.size() > 1 && (header[1] >= 0x80) != from_laser) return false;
  if (header.size() <= 3) return true;
  const std::size_t length = u16(header, 2);
  if (length < (from_laser ? 2u : 1u)) return false;
  if (!from_laser) return length <= kMaxHostPayload;
  if (length > kMaxScanPayload) return false;
  if (header.size() <= 4) return true;
  if (header[4] < 0x80) return false;
  if (header[4] != kValuesReply) return length <= kMaxReplyPayload || header[4] == kSubRangeReply;
  if (header.size() <= 6) return true;
  const std::size_t scan_length = 4u + 2u * (u16(header, 5) & 0x3FFu);
  return length == scan_length || length == scan_length + 2;
}

TelegramParser::Look TelegramParser::look(std::span<const uint8_t> from_stx) const {
  if (!plausible(from_stx.first(std::min<std::size_t>(from_stx.size(), 7)))) return Look::nonsense;
  if (from_stx.size() < 4) return Look::incomplete;
  return from_stx.size() < u16(from_stx, 2) + kOverhead ? Look::incomplete : Look::telegram;
}

std::optional<Event> TelegramParser::next() {
  while (head_ < buffer_.size()) {
    const std::span<const uint8_t> rest(buffer_.data() + head_, buffer_.size() - head_);
    if (side_ == Side::laser && (rest[0] == kAck || rest[0] == kNak)) {
      ++head_;
      Event event;
      event.kind = rest[0] == kAck ? Event::Kind::ack : Event::Kind::nak;
      event.bytes_total = 1;
      event.bytes_after = rest.size() - 1;
      return event;
    }
    const Look found = rest[0] == kStx ? look(rest) : Look::nonsense;
    if (found == Look::incomplete) return std::nullopt;
    if (found == Look::telegram) {
      const std::size_t length = u16(rest, 2);
      Event event;
      event.address = rest[1];
      event.payload = rest.subspan(4, length);
      event.bytes_total = length + kOverhead;
      event.bytes_after = rest.size() - event.bytes_total;
      if (crc(rest.first(length + 4)) == u16(rest, length + 4)) {
        head_ += event.bytes_total;
        return event;
      }
      ++bad_checksums_;
      ++garbage_bytes_;
      ++head_;
      event.kind = Event::Kind::bad_checksum;
      return event;
    }
    ++garbage_bytes_;
    ++head_;
  }
  return std::nullopt;
}

void TelegramParser::give_up_waiting() {
  if (head_ == buffer_.size()) return;
  ++head_;
  ++garbage_bytes_;
}

void TelegramParser::clear() {
  buffer_.clear();
  head_ = 0;
}

double metres(Unit unit) { return unit == Unit::mm ? 0.001 : unit == Unit::cm ? 0.01 : 0.1; }

RangeRule range_rule(int measuring_mode) {
  switch (measuring_mode) {
    case 0x00:
    case 0x01:
    case 0x02:
      return {0x1FFF, 0x1FF7};
    case 0x03:
    case 0x04:
      return {0x3FFF, 0x3FF7};
    case 0x05:
    case 0x06:
      return {0x7FFF, 0x7FF7};
    case 0x0F:
      return {0xFFFF, 0xFFF7};
    default:
      throw std::invalid_argument("SICK measuring mode " + std::to_string(measuring_mode) +
                                  " carries no distances");
  }
}

std::optional<Special> special_of(uint16_t word, const RangeRule& rule) {
  const uint16_t distance = word & rule.distance_mask;
  if (distance < rule.first_special) return std::nullopt;
  for (const auto& [below_top, special] : kSpecials) {
    if (rule.distance_mask - distance == below_top) return special;
  }
  return Special::unknown;
}

uint16_t word_of(Special special, const RangeRule& rule) {
  for (const auto& [below_top, one] : kSpecials) {
    if (one == special) return static_cast<uint16_t>(rule.distance_mask - below_top);
  }
  return rule.distance_mask;
}

Bytes encode_values(const MeasuredValues& values) {
  require(values.words.size() <= 0x3FF, "a scan has at most 1023 values");
  Bytes payload{values.sub_range ? kSubRangeReply : kValuesReply};
  if (values.sub_range) {
    put_u16(payload, (*values.sub_range)[0]);
    put_u16(payload, (*values.sub_range)[1]);
  }
  int header = static_cast<int>(values.words.size()) | static_cast<int>(values.unit) << 14;
  if (values.partial) header |= 1 << 13 | values.partial_offset_quarters << 11;
  put_u16(payload, static_cast<uint16_t>(header));
  for (const uint16_t word : values.words) put_u16(payload, word);
  payload.insert(payload.end(), values.indices.begin(), values.indices.end());
  return payload;
}

std::optional<MeasuredValues> decode_values(const Event& reply) {
  MeasuredValues values;
  if (reply.payload.size() < 4) return std::nullopt;
  std::span<const uint8_t> data = reply.data();
  if (reply.code() == kSubRangeReply) {
    if (data.size() < 6) return std::nullopt;
    values.sub_range = {u16(data, 0), u16(data, 2)};
    data = data.subspan(4);
  } else if (reply.code() != kValuesReply) {
    return std::nullopt;
  }
  const int header = u16(data, 0);
  const auto count = static_cast<std::size_t>(header & 0x3FF);
  data = data.subspan(2);
  if (data.size() != 2 * count && data.size() != 2 * count + 2) return std::nullopt;
  if (header >> 14 > 2) return std::nullopt;
  values.unit = static_cast<Unit>(header >> 14);
  values.partial = (header >> 13 & 1) != 0;
  values.partial_offset_quarters = header >> 11 & 3;
  values.words.resize(count);
  for (std::size_t i = 0; i < count; ++i) values.words[i] = u16(data, 2 * i);
  values.indices.assign(data.begin() + static_cast<std::ptrdiff_t>(2 * count), data.end());
  return values;
}

Bytes set_configuration_request(const Configuration& configuration) {
  Bytes payload{kSetConfiguration};
  payload.insert(payload.end(), configuration.bytes.begin(), configuration.bytes.end());
  return encode_request(payload);
}

std::optional<Configuration> decode_configuration(const Event& reply) {
  if (reply.payload.size() < 2 + 7) return std::nullopt;
  const std::span<const uint8_t> data = reply.data();
  return Configuration{Bytes(data.begin(), data.end())};
}

Bytes encode_status(const StatusReport& report) {
  Bytes data(kStatusBytes, 0);
  std::fill_n(data.begin(), 7, uint8_t{' '});
  std::copy_n(report.firmware.begin(), std::min<std::size_t>(7, report.firmware.size()),
              data.begin());
  data[7] = report.mode;
  data[8] = report.defect ? 1 : 0;
  for (std::size_t i = 0; i < 8; ++i) set_u16(data, 18 + 2 * i, report.pollution[i]);
  set_u16(data, 66, report.motor_revolutions);
  data[101] = static_cast<uint8_t>(report.measuring_mode);
  set_u16(data, 106, report.angle_deg);
  set_u16(data, 108, report.resolution_cdeg);
  for (const BaudWord& one : kBauds) {
    if (one.baud == report.baud) set_u16(data, 115, one.status_word);
  }
  data[118] = report.permanent_baud ? 1 : 0;
  data[119] = report.address;
  data[121] = static_cast<uint8_t>(report.unit);
  std::fill_n(data.begin() + 123, 7, uint8_t{' '});
  std::copy_n(report.boot_firmware.begin(), std::min<std::size_t>(7, report.boot_firmware.size()),
              data.begin() + 123);
  data.insert(data.begin(), kGetStatus | 0x80);
  return data;
}

std::optional<StatusReport> decode_status(const Event& reply) {
  if (reply.payload.size() < 2 || reply.code() != (kGetStatus | 0x80)) return std::nullopt;
  const std::span<const uint8_t> data = reply.data();
  if (data.size() < kOldStatusBytes) return std::nullopt;
  const std::size_t shift = data.size() < kStatusBytes ? 6 : 0;  // all behind byte 8
  StatusReport report;
  report.firmware = text_of(data.first(7));
  report.mode = data[7];
  report.defect = data[8] != 0;
  for (std::size_t i = 0; i < 8; ++i) report.pollution[i] = u16(data, 18 - shift + 2 * i);
  report.motor_revolutions = u16(data, 66 - shift);
  report.measuring_mode = data[101 - shift];
  report.angle_deg = u16(data, 106 - shift);
  report.resolution_cdeg = u16(data, 108 - shift);
  report.baud = 0;
  for (const BaudWord& one : kBauds) {
    if (one.status_word == u16(data, 115 - shift)) report.baud = one.baud;
  }
  report.permanent_baud = data[118 - shift] != 0;
  report.address = data[119 - shift];
  report.unit = static_cast<Unit>(data[121 - shift] & 3);
  report.boot_firmware = text_of(data.subspan(123 - shift, 7));
  return report;
}

std::string describe_status_byte(uint8_t status) {
  constexpr std::array<const char*, 8> kSeverity{"",      "info", "warning", "error",
                                                 "fatal", "?",    "?",       "?"};
  std::string text = kSeverity[status & 7];
  const auto add = [&text](bool set, const char* what) {
    if (set) text += (text.empty() ? "" : " ") + std::string(what);
  };
  add((status & 0x20) != 0, "restart");
  add((status & 0x40) != 0, "implausible");
  add((status & 0x80) != 0, "pollution");
  return text;
}

int beams_of_variant(int angle_deg, int resolution_cdeg) {
  const bool exists = (angle_deg == 180 && (resolution_cdeg == 100 || resolution_cdeg == 50)) ||
                      (angle_deg == 100 &&
                       (resolution_cdeg == 100 || resolution_cdeg == 50 || resolution_cdeg == 25));
  return exists ? angle_deg * 100 / resolution_cdeg + 1 : 0;
}

}  // namespace marco::drivers::sick
