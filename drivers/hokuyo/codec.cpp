#include "drivers/hokuyo/codec.hpp"

#include <algorithm>
#include <charconv>
#include <utility>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/base/format.hpp"

namespace marco::drivers::hokuyo {
namespace {

constexpr std::size_t kMaxReplyLine = 200;  // no reply of any model has a longer one
constexpr std::size_t kMaxReplyLines = 200;

std::optional<int> number_at(std::string_view line, std::size_t at, std::size_t digits) {
  if (line.size() < at + digits) return std::nullopt;
  int value = 0;
  const char* end = line.data() + at + digits;
  const auto result = std::from_chars(line.data() + at, end, value);
  if (result.ec != std::errc() || result.ptr != end || value < 0) return std::nullopt;
  return value;
}

// In the replies of VV, PP and II a line is "KEY:value;". Its ";" is left out of the sum, though
// some devices take it in. In the data of a scan a ";" is a character like any other.
bool has_key_lines(std::string_view echo) {
  const std::string_view command = echo.substr(0, 2);
  return command == "VV" || command == "PP" || command == "II";
}

bool is_key_line(std::string_view echo, std::string_view text) {
  return has_key_lines(echo) && text.ends_with(';') && text.find(':') != text.npos;
}

bool sum_fits(std::string_view echo, std::string_view line) {
  if (line.empty()) return false;
  const std::string_view text = line.substr(0, line.size() - 1);
  if (checksum(text) == line.back()) return true;
  return is_key_line(echo, text) && checksum(text.substr(0, text.size() - 1)) == line.back();
}

bool is_printable(std::string_view line) {
  return std::all_of(line.begin(), line.end(), [](char c) { return c >= 0x20 && c < 0x7F; });
}

}  // namespace

char checksum(std::string_view text) {
  unsigned sum = 0;
  for (const char c : text) sum += static_cast<unsigned char>(c);
  return static_cast<char>((sum & 0x3F) + 0x30);
}

std::string encode_number(uint32_t value, int characters) {
  std::string text;
  for (int i = characters - 1; i >= 0; --i) {
    text += static_cast<char>((value >> (6 * i) & 0x3F) + 0x30);
  }
  return text;
}

std::optional<uint32_t> decode_number(std::string_view text) {
  uint32_t value = 0;
  for (const char c : text) {
    if (c < 0x30 || c > 0x6F) return std::nullopt;
    value = value << 6 | static_cast<uint32_t>(c - 0x30);
  }
  return value;
}

std::string key_line(const std::string& key, const std::string& value) {
  return key + ":" + value + ";";
}

Bytes encode_reply(const Reply& reply, const std::string& tag) {
  std::string text = reply.echo + tag + "\n" + reply.status + checksum(reply.status) + "\n";
  for (const std::string& line : reply.lines) {
    const bool is_key = is_key_line(reply.echo, line);
    text += line + checksum(is_key ? line.substr(0, line.size() - 1) : line) + "\n";
  }
  text += "\n";
  return {text.begin(), text.end()};
}

void ReplyParser::push(std::span<const uint8_t> bytes) {
  buffer_.erase(0, head_);
  head_ = 0;
  buffer_.append(bytes.begin(), bytes.end());
}

void ReplyParser::clear() {
  buffer_.clear();
  head_ = 0;
  lines_.clear();
  bytes_ = 0;
}

std::optional<Reply> ReplyParser::next() {
  while (true) {
    const std::size_t end = buffer_.find('\n', head_);
    if (end == std::string::npos) {
      if (buffer_.size() - head_ > kMaxReplyLine) {
        garbage_bytes_ += static_cast<int64_t>(buffer_.size() - head_ + bytes_);
        clear();
      }
      return std::nullopt;
    }
    std::string line = buffer_.substr(head_, end - head_);
    bytes_ += line.size() + 1;
    head_ = end + 1;
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (!line.empty()) {
      lines_.push_back(std::move(line));
      if (lines_.size() <= kMaxReplyLines) continue;
    }
    if (auto reply = finish()) return reply;
  }
}

std::optional<Reply> ReplyParser::finish() {
  const std::vector<std::string> lines = std::exchange(lines_, {});
  const std::size_t bytes = std::exchange(bytes_, 0);
  if (lines.empty()) return std::nullopt;
  Reply reply;
  // A reply whose end was lost has the next one behind it: the last echo with a status counts.
  std::size_t first = 0;
  bool good = false;
  for (std::size_t i = 0; i + 1 < lines.size() && !good; ++i) {
    good = is_printable(lines[i]) && lines[i].size() >= 2 && lines[i + 1].size() == 3 &&
           std::all_of(lines.begin() + static_cast<std::ptrdiff_t>(i) + 1, lines.end(),
                       [&](const std::string& line) { return sum_fits(lines[i], line); });
    if (good) first = i;
  }
  if (!good) {
    garbage_bytes_ += static_cast<int64_t>(bytes);
    bad_checksums_ += lines.size() >= 2 ? 1 : 0;
    return std::nullopt;
  }
  for (std::size_t i = 0; i < first; ++i) {
    garbage_bytes_ += static_cast<int64_t>(lines[i].size()) + 1;
  }
  reply.echo = lines[first].substr(0, lines[first].find(';'));
  reply.status = lines[first + 1].substr(0, 2);
  for (std::size_t i = first + 2; i < lines.size(); ++i) {
    reply.lines.push_back(lines[i].substr(0, lines[i].size() - 1));
  }
  return reply;
}

std::string ScanRequest::line() const {
  const char kind = stream ? (all_echoes ? 'N' : 'M') : (all_echoes ? 'H' : 'G');
  const char code = intensities ? 'E' : characters == 3 ? 'D' : 'S';
  if (stream) {
    return format("%c%c%04d%04d%02d%01d%02d", kind, code, first_step, last_step, cluster, skip,
                  count);
  }
  return format("%c%c%04d%04d%02d", kind, code, first_step, last_step, cluster);
}

std::optional<ScanRequest> parse_scan_request(std::string_view line) {
  constexpr std::string_view kKinds = "MGNH", kCodes = "DSE";
  if (line.size() < 12 || kKinds.find(line[0]) == kKinds.npos) return std::nullopt;
  if (kCodes.find(line[1]) == kCodes.npos) return std::nullopt;
  ScanRequest request;
  request.stream = line[0] == 'M' || line[0] == 'N';
  request.all_echoes = line[0] == 'N' || line[0] == 'H';
  request.characters = line[1] == 'S' ? 2 : 3;
  request.intensities = line[1] == 'E';
  if (line.size() != (request.stream ? 15u : 12u)) return std::nullopt;
  const auto first = number_at(line, 2, 4);
  const auto last = number_at(line, 6, 4);
  const auto cluster = number_at(line, 10, 2);
  const auto skip = request.stream ? number_at(line, 12, 1) : 0;
  const auto count = request.stream ? number_at(line, 13, 2) : 1;
  if (!first || !last || !cluster || !skip || !count || *last < *first) return std::nullopt;
  request.first_step = *first;
  request.last_step = *last;
  request.cluster = std::max(1, *cluster);
  request.skip = *skip;
  request.count = *count;
  return request;
}

Reply encode_measurement(const ScanRequest& request, int remaining, const Measurement& scan) {
  ScanRequest echoed = request;
  echoed.count = remaining;
  Reply reply{echoed.line(), request.stream ? "99" : "00", {}};
  reply.lines.push_back(encode_number(scan.timestamp_ms & 0xFFFFFF, 4));
  std::string data;
  for (std::size_t i = 0; i < scan.values_mm.size(); ++i) {
    data += encode_number(scan.values_mm[i], request.characters);
    if (request.intensities) data += encode_number(scan.intensities.at(i), request.characters);
  }
  for (std::size_t at = 0; at < data.size(); at += kBlock) {
    reply.lines.push_back(data.substr(at, kBlock));
  }
  return reply;
}

std::optional<Measurement> decode_measurement(const Reply& reply, const ScanRequest& request) {
  // The echo has no checksum: it must be the very request, but for the count that runs down.
  const std::string asked = request.line();
  const std::size_t fixed = request.stream ? 13 : 12;
  if (reply.echo.size() != asked.size() || reply.echo.compare(0, fixed, asked, 0, fixed) != 0) {
    return std::nullopt;
  }
  if (reply.status != (request.stream ? "99" : "00") || reply.lines.empty()) return std::nullopt;
  const auto timestamp = decode_number(reply.lines[0]);
  if (reply.lines[0].size() != 4 || !timestamp) return std::nullopt;
  const auto characters = static_cast<std::size_t>(request.characters);
  const std::size_t each = characters * (request.intensities ? 2 : 1);
  const std::size_t size = static_cast<std::size_t>(request.values()) * each;
  if (reply.lines.size() != 1 + (size + kBlock - 1) / kBlock) return std::nullopt;
  std::string data;
  data.reserve(size);
  for (std::size_t i = 1; i < reply.lines.size(); ++i) {
    const bool last = i + 1 == reply.lines.size();
    if (!last && reply.lines[i].size() != kBlock) return std::nullopt;
    data += reply.lines[i];
  }
  if (data.size() != size) return std::nullopt;
  Measurement scan;
  scan.timestamp_ms = *timestamp;
  scan.values_mm.reserve(static_cast<std::size_t>(request.values()));
  for (std::size_t at = 0; at < size; at += each) {
    const auto value = decode_number(std::string_view(data).substr(at, characters));
    if (!value) return std::nullopt;
    scan.values_mm.push_back(*value);
    if (!request.intensities) continue;
    const auto intensity =
        decode_number(std::string_view(data).substr(at + characters, characters));
    if (!intensity) return std::nullopt;
    scan.intensities.push_back(*intensity);
  }
  return scan;
}

Reply encode_parameters(const Parameters& parameters) {
  const auto line = [](const char* key, int value) { return key_line(key, std::to_string(value)); };
  return {"PP",
          "00",
          {key_line("MODL", parameters.model), line("DMIN", parameters.range_min_mm),
           line("DMAX", parameters.range_max_mm), line("ARES", parameters.steps_per_turn),
           line("AMIN", parameters.first_step), line("AMAX", parameters.last_step),
           line("AFRT", parameters.front_step), line("SCAN", parameters.rpm)}};
}

std::optional<Parameters> decode_parameters(const Reply& reply) {
  if (reply.command() != "PP" || !reply.done()) return std::nullopt;
  Parameters parameters;
  int known = 0;
  for (const std::string& line : reply.lines) {
    if (line.size() < 6 || line[4] != ':') continue;
    const std::string key = line.substr(0, 4);
    const std::string value = line.substr(5, line.find_last_of(';') - 5);
    if (key == "MODL") parameters.model = value;
    const auto number = number_at(value, 0, value.size());
    if (!number) continue;
    const auto take = [&](const char* name, int& into) {
      if (key != name) return;
      into = *number;
      ++known;
    };
    take("DMIN", parameters.range_min_mm);
    take("DMAX", parameters.range_max_mm);
    take("ARES", parameters.steps_per_turn);
    take("AMIN", parameters.first_step);
    take("AMAX", parameters.last_step);
    take("AFRT", parameters.front_step);
    take("SCAN", parameters.rpm);
  }
  const bool sane = known == 7 && parameters.steps_per_turn > 0 && parameters.rpm > 0 &&
                    parameters.first_step <= parameters.last_step && parameters.last_step < 10'000;
  return sane ? std::optional(parameters) : std::nullopt;
}

}  // namespace marco::drivers::hokuyo
