#pragma once

#include <cstdint>
#include <vector>

namespace marco::testing {

/// A message of a type that lcm-gen made, as it goes over the wire.
template <class Message>
std::vector<uint8_t> encoded(const Message& message) {
  std::vector<uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

}  // namespace marco::testing
