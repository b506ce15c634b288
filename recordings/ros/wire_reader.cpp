#include "recordings/ros/wire_reader.hpp"

#include <algorithm>

namespace marco::ros {

namespace {

void append_utf8(std::string& text, uint32_t point) {
  if (point < 0x80) {
    text += static_cast<char>(point);
  } else if (point < 0x800) {
    text += static_cast<char>(0xC0 | (point >> 6));
    text += static_cast<char>(0x80 | (point & 0x3F));
  } else if (point < 0x10000) {
    text += static_cast<char>(0xE0 | (point >> 12));
    text += static_cast<char>(0x80 | ((point >> 6) & 0x3F));
    text += static_cast<char>(0x80 | (point & 0x3F));
  } else {
    text += static_cast<char>(0xF0 | ((point >> 18) & 0x07));
    text += static_cast<char>(0x80 | ((point >> 12) & 0x3F));
    text += static_cast<char>(0x80 | ((point >> 6) & 0x3F));
    text += static_cast<char>(0x80 | (point & 0x3F));
  }
}

}  // namespace

WireReader WireReader::cdr(std::span<const uint8_t> bytes) {
  expect(bytes.size() >= 4, "shorter than CDR's header");
  expect(bytes[0] == 0, "not CDR");
  WireReader reader(bytes.subspan(4));
  switch (bytes[1]) {
    case 0x00:
    case 0x01:
      reader.most_alignment_ = 8;
      break;
    case 0x06:
    case 0x07:
    case 0x10:
    case 0x11:
      reader.most_alignment_ = 4;
      break;
    default:
      throw WireError("CDR of type " + std::to_string(bytes[1]) +
                      " (delimited or parameter list) is not supported");
  }
  const bool is_little = (bytes[1] & 1) != 0;
  reader.is_swapped_ = is_little != (std::endian::native == std::endian::little);
  return reader;
}

WireReader WireReader::of(std::string_view encoding, std::span<const uint8_t> bytes) {
  if (encoding == "cdr") return cdr(bytes);
  expect(encoding == "ros1", "neither ros1 nor cdr");
  return ros1(bytes);
}

std::string WireReader::string() {
  const uint32_t length = count();
  expect(length <= left(), "a string is longer than the message");
  std::string text(reinterpret_cast<const char*>(bytes_.data() + at_), length);
  at_ += length;
  if (is_cdr() && !text.empty() && text.back() == '\0') text.pop_back();
  return text;
}

std::string WireReader::wide_string() {
  std::string text;
  for (const uint32_t point : numbers<uint32_t>(count())) append_utf8(text, point);
  return text;
}

std::span<const uint8_t> WireReader::blob() {
  const uint32_t length = count();
  expect(length <= left(), "an array is longer than the message");
  const auto bytes = bytes_.subspan(at_, length);
  at_ += length;
  return bytes;
}

uint32_t WireReader::count_of(std::size_t least_bytes) {
  const uint32_t elements = count();
  expect(elements <= left() / std::max<std::size_t>(1, least_bytes),
         "an array is longer than the message");
  return elements;
}

void WireReader::finish() const {
  expect(left() <= (is_cdr() ? 3 : 0), "bytes are left over: the definition does not fit");
}

}  // namespace marco::ros
