#pragma once

#include <bit>
#include <cstdint>
#include <string>
#include <type_traits>
#include <vector>

namespace marco::testing {

/// The bytes of a message written down by hand, after the rules of LCM: the type's fingerprint,
/// then the fields in order, big endian, without padding; a string is its length with the final
/// NUL, then its characters and the NUL.
class Wire {
 public:
  explicit Wire(int64_t fingerprint) { (*this)(fingerprint); }

  /// int8_t .. int64_t, float and double, each with its own size.
  template <class Number, class... More>
  Wire& operator()(Number number, More... more) {
    if constexpr (std::is_same_v<Number, double>) {
      append(std::bit_cast<uint64_t>(number), 8);
    } else if constexpr (std::is_same_v<Number, float>) {
      append(std::bit_cast<uint32_t>(number), 4);
    } else {
      append(static_cast<uint64_t>(number), sizeof number);
    }
    if constexpr (sizeof...(More) > 0) (*this)(more...);
    return *this;
  }
  Wire& text(const std::string& characters) {
    (*this)(static_cast<int32_t>(characters.size() + 1));
    bytes_.insert(bytes_.end(), characters.begin(), characters.end());
    return (*this)(int8_t{0});
  }
  const std::vector<uint8_t>& bytes() const { return bytes_; }

 private:
  void append(uint64_t value, std::size_t count) {
    for (std::size_t i = count; i-- > 0;) bytes_.push_back(static_cast<uint8_t>(value >> (8 * i)));
  }
  std::vector<uint8_t> bytes_;
};

}  // namespace marco::testing
