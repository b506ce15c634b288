#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "lcm_tools/base/check.hpp"

namespace marco::ros {

/// A message's bytes do not fit its definition.
struct WireError : std::invalid_argument {
  using std::invalid_argument::invalid_argument;
};

/// Reads the fields of one serialized message in their order, in ROS 1's packed form or in CDR as
/// ROS 2 writes it (OMG DDSI-RTPS 10: XCDR1 and plain XCDR2, both byte orders). Every count is held
/// against the bytes that are left before anything is allocated. @throws WireError from every
/// reading function.
class WireReader {
 public:
  static WireReader ros1(std::span<const uint8_t> bytes) { return WireReader(bytes); }
  /// With CDR's header of four bytes, which decides byte order and alignment.
  static WireReader cdr(std::span<const uint8_t> bytes);
  /// @param encoding "ros1" or "cdr"
  static WireReader of(std::string_view encoding, std::span<const uint8_t> bytes);

  template <class Number>
  Number number() {
    static_assert(std::is_arithmetic_v<Number>);
    align(sizeof(Number));
    Number value;
    copy(&value, 1);
    return value;
  }
  bool boolean() { return number<uint8_t>() != 0; }
  uint32_t count() { return number<uint32_t>(); }

  std::string string();
  /// ROS 2: four bytes a character, no end mark. As UTF-8.
  std::string wide_string();

  /// This many numbers, one behind the other.
  template <class Number>
  std::vector<Number> numbers(uint32_t count) {
    if (count == 0) return {};  // CDR pads before an element only
    align(sizeof(Number));
    expect(count <= left() / sizeof(Number), "an array is longer than the message");
    std::vector<Number> values(count);
    copy(values.data(), count);
    return values;
  }
  template <class Number>
  std::vector<Number> sequence() {
    return numbers<Number>(count());
  }
  /// The bytes of a `uint8[]` where they stand.
  std::span<const uint8_t> blob();

  /// A count of elements of which each takes at least `least_bytes`.
  uint32_t count_of(std::size_t least_bytes);

  bool is_cdr() const { return most_alignment_ > 1; }
  std::size_t left() const { return bytes_.size() - at_; }
  /// @throws WireError when more is left than padding: the definition does not fit.
  void finish() const;

 private:
  explicit WireReader(std::span<const uint8_t> bytes) : bytes_(bytes) {}

  static void expect(bool holds, const char* what) {
    if (!holds) throw WireError(what);
  }
  void align(std::size_t size) {
    const std::size_t step = size < most_alignment_ ? size : most_alignment_;
    const std::size_t padded = (at_ + step - 1) / step * step;
    expect(padded <= bytes_.size(), "the message ends too early");
    at_ = padded;
  }
  template <class Number>
  void copy(Number* values, std::size_t count) {
    expect(count <= left() / sizeof(Number), "the message ends too early");
    std::memcpy(values, bytes_.data() + at_, count * sizeof(Number));
    at_ += count * sizeof(Number);
    if (is_swapped_) {
      for (std::size_t i = 0; i < count; ++i) {
        auto* bytes = reinterpret_cast<uint8_t*>(values + i);
        for (std::size_t k = 0; k < sizeof(Number) / 2; ++k)
          std::swap(bytes[k], bytes[sizeof(Number) - 1 - k]);
      }
    }
  }

  std::span<const uint8_t> bytes_;  // behind CDR's header
  std::size_t at_ = 0;
  std::size_t most_alignment_ = 1;  // 1 packed, 8 XCDR1, 4 XCDR2
  bool is_swapped_ = false;         // the message's byte order is not ours
};

}  // namespace marco::ros
