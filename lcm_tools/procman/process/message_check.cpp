#include "lcm_tools/procman/process/message_check.hpp"

#include <string_view>

namespace marco::procman {
namespace {

constexpr std::size_t kFingerprintBytes = 8;

class Walker {
 public:
  explicit Walker(std::span<const uint8_t> bytes) : bytes_(bytes) {}

  /// @returns false where the bytes are not of this layout.
  bool walk(std::string_view layout) {
    for (std::size_t at = 0; at < layout.size(); ++at) {
      if (layout[at] == '{') {
        const std::size_t end = layout.find('}', at);
        for (int64_t n = 0; n < count_; ++n) {
          if (!walk(layout.substr(at + 1, end - at - 1))) return false;
        }
        at = end;
      } else if (!take(layout[at])) {
        return false;
      }
    }
    return true;
  }
  bool at_end() const { return bytes_.empty(); }

 private:
  bool take(char field) {
    switch (field) {
      case 'b':
        return skip(1);
      case 'h':
        return skip(2);
      case 'i':
      case 'f':
        return skip(4);
      case 'l':
        return skip(8);
      case 'H':
        return take_number(2, count_) && count_ >= 0;
      case 'I':
        return take_number(4, count_) && count_ >= 0;
      default:
        break;
    }
    int64_t length = 0;
    if (!take_number(4, length) || length < 1) return false;
    const auto last = static_cast<std::size_t>(length) - 1;
    return last < bytes_.size() && bytes_[last] == 0 && skip(last + 1);
  }

  bool skip(std::size_t size) {
    if (size > bytes_.size()) return false;
    bytes_ = bytes_.subspan(size);
    return true;
  }

  bool take_number(std::size_t size, int64_t& value) {
    if (size > bytes_.size()) return false;
    value = bytes_[0] < 0x80 ? 0 : -1;
    for (std::size_t i = 0; i < size; ++i) value = value * 256 + bytes_[i];
    return skip(size);
  }

  std::span<const uint8_t> bytes_;
  int64_t count_ = 0;
};

}  // namespace

bool is_well_formed(std::span<const uint8_t> bytes, const char* layout) {
  if (bytes.size() < kFingerprintBytes) return false;
  Walker walker(bytes.subspan(kFingerprintBytes));
  return walker.walk(layout) && walker.at_end();
}

}  // namespace marco::procman
