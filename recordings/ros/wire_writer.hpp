#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <string_view>
#include <type_traits>
#include <vector>

namespace marco::ros {

/// Writes the fields of one message in their order, in ROS 1's packed form or in CDR as ROS 2
/// writes it (XCDR1, little endian): the counterpart of WireReader.
class WireWriter {
 public:
  /// @param encoding "ros1" or "cdr". @throws std::invalid_argument for another one.
  explicit WireWriter(std::string_view encoding);

  template <class Number>
  void number(Number value) {
    static_assert(std::is_arithmetic_v<Number>);
    numbers(std::span<const Number>(&value, 1));
  }
  void boolean(bool value) { number<uint8_t>(value ? 1 : 0); }
  void count(std::size_t elements) { number(static_cast<uint32_t>(elements)); }
  void string(std::string_view text);

  /// One behind the other, without their count.
  template <class Number>
  void numbers(std::span<const Number> values) {
    if (values.empty()) return;  // CDR pads before an element only
    align(sizeof(Number));
    const auto* bytes = reinterpret_cast<const uint8_t*>(values.data());
    bytes_.insert(bytes_.end(), bytes, bytes + values.size_bytes());
  }
  template <class Number>
  void sequence(std::span<const Number> values) {
    count(values.size());
    numbers(values);
  }
  template <class Number>
  void sequence(const std::vector<Number>& values) {
    sequence(std::span<const Number>(values));
  }

  /// seconds and nanoseconds; times before 1970 become 0.
  void time(int64_t ns);
  /// std_msgs/Header.
  void header(int64_t stamp_ns, std::string_view frame);

  bool is_cdr() const { return header_bytes_ > 0; }
  const std::vector<uint8_t>& bytes() const { return bytes_; }

 private:
  void align(std::size_t size) {
    if (!is_cdr()) return;
    const std::size_t past = (bytes_.size() - header_bytes_) % size;
    if (past > 0) bytes_.resize(bytes_.size() + size - past);
  }

  std::vector<uint8_t> bytes_;
  std::size_t header_bytes_ = 0;  ///< CDR's own, after which alignment counts
};

}  // namespace marco::ros
