#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "lcm_tools/schema/built_in_sources.hpp"
#include "lcm_tools/schema/decoder.hpp"

namespace marco::spy {

/// The built-in types and those of tests/types, compiled once for all tests.
inline const lcm_schema::Decoder& test_decoder() {
  static const lcm_schema::Schema kSchema([] {
    std::vector<lcm_schema::Problem> problems;
    std::vector<lcm_schema::Source> sources = lcm_schema::read_sources("tests/types", problems);
    // Without Marco's own types, which have the fingerprints of those in tests/types.
    std::vector<lcm_schema::Source> all = built_in_sources();
    std::erase_if(all, [](const lcm_schema::Source& source) {
      return source.name.starts_with("built-in/marco/") &&
             !source.name.ends_with("_status_t.lcm") && !source.name.ends_with("_stop_t.lcm");
    });
    all.insert(all.end(), sources.begin(), sources.end());
    return all;
  }());
  static const lcm_schema::Decoder kDecoder(kSchema);
  return kDecoder;
}

template <class Message>
std::vector<uint8_t> encoded(const Message& message) {
  std::vector<uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

inline void append_big_endian(std::vector<uint8_t>& bytes, uint64_t value, unsigned count) {
  for (unsigned i = count; i > 0; --i)
    bytes.push_back(static_cast<uint8_t>(value >> (8 * (i - 1))));
}

/// What liblcm puts on the wire for a small message.
inline std::vector<uint8_t> short_datagram(uint32_t sequence,
                                           const std::string& channel,
                                           const std::vector<uint8_t>& data) {
  std::vector<uint8_t> bytes = {'L', 'C', '0', '2'};
  append_big_endian(bytes, sequence, 4);
  bytes.insert(bytes.end(), channel.begin(), channel.end());
  bytes.push_back(0);
  bytes.insert(bytes.end(), data.begin(), data.end());
  return bytes;
}

/// The fragments of a large one, `step` bytes of data each.
inline std::vector<std::vector<uint8_t>> fragment_datagrams(uint32_t sequence,
                                                            const std::string& channel,
                                                            const std::vector<uint8_t>& data,
                                                            std::size_t step) {
  std::vector<std::vector<uint8_t>> result;
  const std::size_t count = (data.size() + step - 1) / step;
  for (std::size_t i = 0; i < count; ++i) {
    std::vector<uint8_t> bytes = {'L', 'C', '0', '3'};
    append_big_endian(bytes, sequence, 4);
    append_big_endian(bytes, data.size(), 4);
    append_big_endian(bytes, i * step, 4);
    append_big_endian(bytes, i, 2);
    append_big_endian(bytes, count, 2);
    if (i == 0) {
      bytes.insert(bytes.end(), channel.begin(), channel.end());
      bytes.push_back(0);
    }
    const auto first = data.begin() + static_cast<std::ptrdiff_t>(i * step);
    bytes.insert(bytes.end(), first,
                 data.begin() + static_cast<std::ptrdiff_t>(std::min(data.size(), (i + 1) * step)));
    result.push_back(std::move(bytes));
  }
  return result;
}

}  // namespace marco::spy
