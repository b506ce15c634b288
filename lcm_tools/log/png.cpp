#include "lcm_tools/log/png.hpp"

#include <algorithm>
#include <string_view>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/log/mcap_writer.hpp"

namespace marco::logs {
namespace {

void put_big_endian(std::string& to, uint32_t value) {
  for (const unsigned shift : {24U, 16U, 8U, 0U}) to += static_cast<char>(value >> shift);
}

void add_part(std::string& png, const std::string& name, const std::string& content) {
  put_big_endian(png, static_cast<uint32_t>(content.size()));
  png += name + content;
  put_big_endian(png, crc32(content, crc32(name)));
}

uint32_t adler32(std::string_view bytes) {
  constexpr uint32_t kModulus = 65521;
  constexpr std::size_t kBeforeOverflow = 5552;
  uint32_t a = 1, b = 0;
  while (!bytes.empty()) {
    for (const char byte : bytes.substr(0, kBeforeOverflow)) {
      a += static_cast<uint8_t>(byte);
      b += a;
    }
    a %= kModulus;
    b %= kModulus;
    bytes.remove_prefix(std::min(kBeforeOverflow, bytes.size()));
  }
  return b << 16U | a;
}

// A zlib stream of stored blocks.
std::string store(std::string_view bytes) {
  constexpr std::size_t kLargestBlock = 65535;
  std::string stream("\x78\x01", 2);
  const uint32_t checksum = adler32(bytes);
  do {
    const std::string_view block = bytes.substr(0, kLargestBlock);
    bytes.remove_prefix(block.size());
    const auto size = static_cast<uint16_t>(block.size());
    stream += static_cast<char>(bytes.empty() ? 1 : 0);
    stream += static_cast<char>(size & 0xFFU);
    stream += static_cast<char>(size >> 8U);
    stream += static_cast<char>(~size & 0xFFU);
    stream += static_cast<char>((~size >> 8U) & 0xFFU);
    stream += block;
  } while (!bytes.empty());
  put_big_endian(stream, checksum);
  return stream;
}

}  // namespace

std::string to_png(std::span<const uint8_t> pixels, int width_px, int pixel_bytes) {
  require(width_px > 0 && (pixel_bytes == 1 || pixel_bytes == 3), "a PNG of 1 or 3 bytes a pixel");
  const auto row_bytes = static_cast<std::size_t>(width_px) * static_cast<std::size_t>(pixel_bytes);
  require(!pixels.empty() && pixels.size() % row_bytes == 0, "a PNG of whole rows");
  std::string rows;
  rows.reserve(pixels.size() + pixels.size() / row_bytes);
  for (std::size_t at = 0; at < pixels.size(); at += row_bytes) {
    rows += '\0';  // no filter
    rows.append(reinterpret_cast<const char*>(pixels.data()) + at, row_bytes);
  }
  std::string header;
  put_big_endian(header, static_cast<uint32_t>(width_px));
  put_big_endian(header, static_cast<uint32_t>(pixels.size() / row_bytes));
  header += '\x08';                              // bits a channel
  header += pixel_bytes == 1 ? '\x00' : '\x02';  // gray, colour
  header += std::string(3, '\0');
  std::string png("\x89PNG\r\n\x1a\n", 8);
  add_part(png, "IHDR", header);
  add_part(png, "IDAT", store(rows));
  add_part(png, "IEND", "");
  return png;
}

}  // namespace marco::logs
