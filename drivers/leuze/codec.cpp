#include "drivers/leuze/codec.hpp"

#include <bit>
#include <cmath>
#include <utility>

#include "lcm_tools/base/check.hpp"

namespace marco::drivers::leuze {
namespace {

constexpr uint8_t kFiller = 0xFE;
constexpr uint8_t kStuffing = 0xFF;
constexpr std::size_t kMaxBody = 1200;  // 529 values have 1058 bytes
constexpr int kMaxIndex = 529;

bool is_operation(uint8_t byte) {
  return byte == kMeasurement || byte == kError || byte == kWarning;
}

// Takes bytes from the front; too few make `good` false.
struct Reader {
  std::span<const uint8_t> rest;
  bool good = true;

  uint8_t u8() {
    if (rest.empty()) {
      good = false;
      return 0;
    }
    const uint8_t value = rest[0];
    rest = rest.subspan(1);
    return value;
  }
  int u16() {
    const int high = u8();
    return high << 8 | u8();
  }
};

uint8_t xor_of(std::span<const uint8_t> bytes) {
  uint8_t sum = 0;
  for (const uint8_t byte : bytes) sum = static_cast<uint8_t>(sum ^ byte);
  return sum;
}

}  // namespace

Bytes encode_telegram(const Telegram& telegram) {
  require(!telegram.options.empty() && telegram.options.size() <= 3 &&
              (telegram.options[0] & 3u) == telegram.options.size(),
          "an RS4 telegram's first option byte gives their number");
  Bytes body{telegram.operation};
  body.insert(body.end(), telegram.options.begin(), telegram.options.end());
  if ((telegram.options[0] & kPasswordFollows) != 0) body.insert(body.end(), 8, ' ');
  for (const int shift : {24, 16, 8, 0}) {
    body.push_back(static_cast<uint8_t>(telegram.scan_number >> shift));
    body.push_back(kFiller);
  }
  const auto put = [&body](int value) {
    body.push_back(static_cast<uint8_t>(value >> 8));
    body.push_back(static_cast<uint8_t>(value));
  };
  body.push_back(static_cast<uint8_t>(telegram.step));
  put(telegram.first);
  put(telegram.last());
  for (const uint16_t value : telegram.values_mm) put(value & 0xFFFE);

  Bytes stuffed{0, 0};
  int zeros = 0;
  for (const uint8_t byte : body) {
    stuffed.push_back(byte);
    zeros = byte == 0 ? zeros + 1 : 0;
    if (zeros == 2) {
      stuffed.push_back(kStuffing);
      zeros = 0;
    }
  }
  const uint8_t sum = xor_of(std::span(stuffed).subspan(2));
  stuffed.push_back(sum == 0 ? 0xFF : sum);
  stuffed.insert(stuffed.end(), 3, 0);
  return stuffed;
}

std::optional<Telegram> decode_body(std::span<const uint8_t> body) {
  Reader reader{body};
  Telegram telegram;
  telegram.operation = reader.u8();
  telegram.options = {reader.u8()};
  const uint8_t first_option = telegram.options[0];
  for (int i = 1; i < (first_option & 3); ++i) telegram.options.push_back(reader.u8());
  if ((first_option & kPasswordFollows) != 0) {
    for (int i = 0; i < 8; ++i) reader.u8();
  }
  if (telegram.operation != kMeasurement) {
    return reader.good ? std::optional(telegram) : std::nullopt;
  }
  for (int i = 0; i < 4; ++i) {
    telegram.scan_number = telegram.scan_number << 8 | reader.u8();
    if (reader.u8() != kFiller) return std::nullopt;
  }
  telegram.step = reader.u8();
  telegram.first = reader.u16();
  const int last = reader.u16();
  if (!reader.good || telegram.step < 1 || telegram.first < 1 || last < telegram.first ||
      last > kMaxIndex) {
    return std::nullopt;
  }
  const int count = (last - telegram.first) / telegram.step + 1;
  if (reader.rest.size() != 2 * static_cast<std::size_t>(count) || telegram.options.size() == 0 ||
      (last - telegram.first) % telegram.step != 0) {
    return std::nullopt;
  }
  for (int i = 0; i < count; ++i) {
    telegram.values_mm.push_back(static_cast<uint16_t>(reader.u16() & 0xFFFE));
  }
  return telegram;
}

void TelegramParser::clear() {
  unread_.clear();
  body_.clear();
  inside_ = false;
  zeros_ = 0;
}

std::optional<Telegram> TelegramParser::next() {
  while (!unread_.empty()) {
    const uint8_t byte = unread_.rest().front();
    unread_.take(1);
    if (auto telegram = take(byte)) return telegram;
  }
  return std::nullopt;
}

std::optional<Telegram> TelegramParser::take(uint8_t byte) {
  if (inside_ && zeros_ == 2 && byte == 0) {
    zeros_ = 3;
    return finish();
  }
  if (inside_ && zeros_ == 2 && byte == kStuffing) {
    ++stuffed_;
    zeros_ = 0;
    return std::nullopt;
  }
  if (zeros_ >= 2 && byte != 0) {
    garbage_bytes_ += static_cast<int64_t>(body_.size());
    body_.clear();
    stuffed_ = 0;
    zeros_ = 0;
    inside_ = is_operation(byte);
    if (!inside_) ++garbage_bytes_;
    if (inside_) body_.push_back(byte);
    return std::nullopt;
  }
  zeros_ = byte == 0 ? zeros_ + 1 : 0;
  if (!inside_) {
    garbage_bytes_ += byte == 0 ? 0 : 1;
    return std::nullopt;
  }
  body_.push_back(byte);
  if (body_.size() > kMaxBody) {
    garbage_bytes_ += static_cast<int64_t>(body_.size());
    body_.clear();
    inside_ = false;
  }
  return std::nullopt;
}

std::optional<Telegram> TelegramParser::finish() {
  Bytes body = std::exchange(body_, {});
  inside_ = false;
  const bool odd = std::exchange(stuffed_, 0) % 2 != 0;
  body.resize(body.size() - 2);  // the first two zeros of the end
  if (body.size() > 2) {
    const std::span<const uint8_t> content(body.data(), body.size() - 1);
    const auto sum = static_cast<uint8_t>(xor_of(content) ^ (odd ? kStuffing : 0));
    if ((sum == 0 ? 0xFF : sum) == body.back()) {
      if (auto telegram = decode_body(content)) return telegram;
    }
  }
  ++bad_checksums_;
  garbage_bytes_ += static_cast<int64_t>(body.size());
  return std::nullopt;
}

std::array<uint8_t, 4> service_request() { return {1, 0, 0, 0}; }

Bytes encode_service_answer(std::span<const float> ranges) {
  require(ranges.size() == kServiceBeams, "the service answers 133 ranges");
  Bytes bytes;
  for (const float range : ranges) {
    const auto word = std::bit_cast<uint32_t>(range);
    for (const int shift : {0, 8, 16, 24}) bytes.push_back(static_cast<uint8_t>(word >> shift));
  }
  return bytes;
}

std::optional<std::vector<float>> decode_service_answer(std::span<const uint8_t> bytes) {
  if (bytes.size() != kServiceBytes) return std::nullopt;
  std::vector<float> ranges;
  for (std::size_t at = 0; at < bytes.size(); at += 4) {
    const uint32_t word =
        static_cast<uint32_t>(bytes[at]) | static_cast<uint32_t>(bytes[at + 1]) << 8 |
        static_cast<uint32_t>(bytes[at + 2]) << 16 | static_cast<uint32_t>(bytes[at + 3]) << 24;
    ranges.push_back(std::bit_cast<float>(word));
    if (!std::isfinite(ranges.back()) || ranges.back() < 0.0f) return std::nullopt;
  }
  return ranges;
}

}  // namespace marco::drivers::leuze
