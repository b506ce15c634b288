#include <bit>
#include <charconv>
#include <cmath>
#include <utility>

#include "drivers/cola/codec.hpp"
#include "lcm_tools/base/format.hpp"

namespace marco::drivers::cola {
namespace {

constexpr uint32_t kMostChannels = 32, kMostEncoders = 8;
constexpr int kTimeWords = 7, kPositionWords = 7;

/// Takes a telegram's words one after another. After the first that is wrong all are.
class Words {
 public:
  explicit Words(std::string_view text) : rest_(text) {}

  bool good() const { return good_; }
  void refuse_unless(bool sound) { good_ = good_ && sound; }

  std::string_view word() {
    if (rest_.empty()) good_ = false;
    const std::size_t end = std::min(rest_.find(' '), rest_.size());
    const std::string_view word = rest_.substr(0, end);
    rest_.remove_prefix(std::min(end + 1, rest_.size()));
    return word;
  }

  uint32_t number() {
    std::string_view digits = word();
    const bool is_signed = !digits.empty() && (digits[0] == '+' || digits[0] == '-');
    const bool negative = is_signed && digits[0] == '-';
    if (is_signed) digits.remove_prefix(1);
    uint32_t value = 0;
    const auto read =
        std::from_chars(digits.data(), digits.data() + digits.size(), value, is_signed ? 10 : 16);
    if (read.ec != std::errc() || read.ptr != digits.data() + digits.size()) good_ = false;
    return negative ? 0U - value : value;
  }

  int32_t signed_number() { return static_cast<int32_t>(number()); }

  double real() {
    const auto value = static_cast<double>(std::bit_cast<float>(number()));
    if (!std::isfinite(value)) good_ = false;
    return value;
  }

  /// Its length stands before it, since it may hold spaces.
  std::string text() {
    const std::size_t length = number();
    if (length > rest_.size()) good_ = false;
    if (!good_) return {};
    std::string taken(rest_.substr(0, length));
    rest_.remove_prefix(std::min(length + 1, rest_.size()));
    return taken;
  }

  void skip(int words) {
    for (int i = 0; i < words; ++i) word();
  }

 private:
  std::string_view rest_;
  bool good_ = true;
};

std::vector<Channel> read_channels(Words& words, uint32_t largest) {
  const uint32_t count = words.number();
  words.refuse_unless(count <= kMostChannels);
  std::vector<Channel> channels;
  for (uint32_t i = 0; words.good() && i < count; ++i) {
    Channel channel;
    channel.name = std::string(words.word());
    channel.scale = words.real();
    channel.offset = words.real();
    channel.start_e4 = words.signed_number();
    channel.step_e4 = words.signed_number();
    const uint32_t values = words.number();
    words.refuse_unless(values <= kMostBeams && !channel.name.empty());
    for (uint32_t k = 0; words.good() && k < values; ++k) {
      const uint32_t value = words.number();
      words.refuse_unless(value <= largest);
      channel.values.push_back(static_cast<uint16_t>(value));
    }
    channels.push_back(std::move(channel));
  }
  return channels;
}

void write(std::string& text, uint32_t number) { text += format(" %X", number); }

void write_real(std::string& text, double value) {
  text += format(" %08X", std::bit_cast<uint32_t>(static_cast<float>(value)));
}

void write_text(std::string& text, const std::string& what) {
  write(text, what.empty() ? 0 : 1);
  if (what.empty()) return;
  write(text, static_cast<uint32_t>(what.size()));
  text += " " + what;
}

void write_channels(std::string& text, const std::vector<Channel>& channels) {
  write(text, static_cast<uint32_t>(channels.size()));
  for (const Channel& channel : channels) {
    text += " " + channel.name;
    write_real(text, channel.scale);
    write_real(text, channel.offset);
    write(text, static_cast<uint32_t>(channel.start_e4));
    write(text, static_cast<uint32_t>(channel.step_e4));
    write(text, static_cast<uint32_t>(channel.values.size()));
    for (const uint16_t value : channel.values) write(text, value);
  }
}

}  // namespace

const Channel* ScanData::channel(std::string_view wanted) const {
  for (const auto* channels : {&wide, &narrow}) {
    for (const Channel& channel : *channels) {
      if (channel.name == wanted) return &channel;
    }
  }
  return nullptr;
}

std::string encode_scan(const ScanData& scan, std::string_view type) {
  std::string text = std::string(type) + " LMDscandata";
  for (const uint32_t number :
       {scan.version, scan.device, scan.serial, 0U, scan.status, scan.telegrams, scan.scans,
        scan.begin_us, scan.sent_us, 0U, scan.inputs, 0U, scan.outputs, 0U, scan.rate_chz,
        scan.sample_rate, static_cast<uint32_t>(scan.encoders.size())}) {
    write(text, number);
  }
  for (const Encoder& encoder : scan.encoders) {
    write(text, encoder.position);
    write(text, encoder.speed);
  }
  write_channels(text, scan.wide);
  write_channels(text, scan.narrow);
  write(text, 0);  // no position
  write_text(text, scan.name);
  write_text(text, scan.comment);
  write(text, scan.time.empty() ? 0 : 1);
  for (const uint32_t number : scan.time) write(text, number);
  write(text, 0);  // no event
  return text;
}

std::optional<ScanData> decode_scan(std::string_view text) {
  Words words(text);
  const std::string_view type = words.word();
  if ((type != "sSN" && type != "sRA") || words.word() != "LMDscandata") return std::nullopt;
  ScanData scan;
  // Two words make one number of two bytes; the first of the inputs and outputs may be either.
  const auto either = [&words] {
    const uint32_t first = words.number();
    return first | words.number();
  };
  scan.version = words.number();
  scan.device = words.number();
  scan.serial = words.number();
  scan.status = either();
  scan.telegrams = words.number();
  scan.scans = words.number();
  scan.begin_us = words.number();
  scan.sent_us = words.number();
  scan.inputs = either();
  scan.outputs = either();
  words.number();  // reserved
  scan.rate_chz = words.number();
  scan.sample_rate = words.number();
  const uint32_t encoders = words.number();
  if (!words.good() || encoders > kMostEncoders) return std::nullopt;
  for (uint32_t i = 0; i < encoders; ++i) {
    const uint32_t position = words.number();
    scan.encoders.push_back({position, words.number()});
  }
  scan.wide = read_channels(words, 0xFFFF);
  scan.narrow = read_channels(words, 0xFF);
  if (!words.good()) return std::nullopt;
  if (words.number() != 0) words.skip(kPositionWords);
  if (words.number() != 0) scan.name = words.text();
  if (words.number() != 0) scan.comment = words.text();
  const bool timed = words.number() != 0;
  for (int i = 0; timed && i < kTimeWords; ++i) scan.time.push_back(words.number());
  // What stands behind the values is left out when it is not as the listing says.
  if (!words.good()) {
    scan.name.clear();
    scan.comment.clear();
    scan.time.clear();
  }
  return scan;
}

}  // namespace marco::drivers::cola
