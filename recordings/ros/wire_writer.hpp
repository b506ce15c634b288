#pragma once

#include <cstdint>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace marco::ros {

/// Writes the fields of one message in their order, as WireReader reads them: ROS 1's packed form,
/// or CDR as ROS 2 writes it (XCDR1, little endian, with its header of four bytes).
class WireWriter {
 public:
  /// @param encoding "ros1" or "cdr"
  explicit WireWriter(std::string_view encoding) : is_cdr_(encoding == "cdr") {
    if (is_cdr_) bytes_ = {0, 1, 0, 0};
  }

  template <class Number>
  void number(Number value) {
    static_assert(std::is_arithmetic_v<Number>);
    while (is_cdr_ && (bytes_.size() - kHeader) % sizeof value != 0) bytes_.push_back(0);
    const auto* raw = reinterpret_cast<const uint8_t*>(&value);
    bytes_.insert(bytes_.end(), raw, raw + sizeof value);
  }
  void count(std::size_t elements) { number(static_cast<uint32_t>(elements)); }
  void string(std::string_view text) {
    count(text.size() + (is_cdr_ ? 1 : 0));
    bytes_.insert(bytes_.end(), text.begin(), text.end());
    if (is_cdr_) bytes_.push_back(0);
  }
  bool is_cdr() const { return is_cdr_; }
  std::vector<uint8_t> take() { return std::move(bytes_); }

 private:
  static constexpr std::size_t kHeader = 4;  // offsets count from behind it
  std::vector<uint8_t> bytes_;
  bool is_cdr_;
};

}  // namespace marco::ros
