#include "recordings/ros/bag_records.hpp"

#include <cstring>

namespace marco::ros {
namespace {

std::optional<uint32_t> number_at(std::span<const uint8_t> bytes, std::size_t at) {
  uint32_t number = 0;
  if (bytes.size() < at + sizeof number) return std::nullopt;
  std::memcpy(&number, bytes.data() + at, sizeof number);
  return number;
}

// The field at the start of checked bytes.
std::string_view first_field(std::span<const uint8_t> bytes) {
  uint32_t length = 0;
  std::memcpy(&length, bytes.data(), sizeof length);
  return {reinterpret_cast<const char*>(bytes.data()) + sizeof length, length};
}

}  // namespace

std::optional<BagHeader> BagHeader::parse(std::span<const uint8_t> bytes) {
  for (auto rest = bytes; !rest.empty(); rest = rest.subspan(4 + first_field(rest).size())) {
    const auto length = number_at(rest, 0);
    if (!length || *length > rest.size() - sizeof *length) return std::nullopt;
    const std::size_t equals = first_field(rest).find('=');
    if (equals == 0 || equals == std::string_view::npos) return std::nullopt;
  }
  return BagHeader(bytes);
}

std::optional<std::string_view> BagHeader::find(std::string_view name) const {
  for (auto rest = bytes_; !rest.empty(); rest = rest.subspan(4 + first_field(rest).size())) {
    const std::string_view field = first_field(rest);
    if (field.size() > name.size() && field.starts_with(name) && field[name.size()] == '=') {
      return field.substr(name.size() + 1);
    }
  }
  return std::nullopt;
}

template <class Number>
std::optional<Number> BagHeader::number(std::string_view name) const {
  const auto field = find(name);
  if (!field || field->size() != sizeof(Number)) return std::nullopt;
  Number value;
  std::memcpy(&value, field->data(), sizeof value);
  return value;
}

std::optional<uint8_t> BagHeader::u8(std::string_view name) const { return number<uint8_t>(name); }
std::optional<uint32_t> BagHeader::u32(std::string_view name) const {
  return number<uint32_t>(name);
}
std::optional<uint64_t> BagHeader::u64(std::string_view name) const {
  return number<uint64_t>(name);
}

std::optional<int64_t> BagHeader::time_ns(std::string_view name) const {
  constexpr int64_t kSecondNs = 1'000'000'000;
  const auto both = number<uint64_t>(name);
  if (!both) return std::nullopt;
  return static_cast<int64_t>(*both & 0xFFFFFFFF) * kSecondNs + static_cast<int64_t>(*both >> 32);
}

std::string BagHeader::text(std::string_view name) const {
  return std::string(find(name).value_or(""));
}

std::size_t bag_head_bytes(std::span<const uint8_t> bytes) {
  constexpr std::size_t kMost = 1 << 14;
  const auto length = number_at(bytes, 0);
  return length && *length <= kMost ? 4 + *length + 4 : 0;
}

std::optional<BagRecordHead> parse_bag_head(std::span<const uint8_t> bytes) {
  const std::size_t size = bag_head_bytes(bytes);
  if (size == 0 || size > bytes.size()) return std::nullopt;
  const auto fields = BagHeader::parse(bytes.subspan(4, size - 8));
  const auto op = fields ? fields->u8("op") : std::nullopt;
  if (!op || *op < 2 || *op > 7) return std::nullopt;
  return BagRecordHead{static_cast<BagOp>(*op), *fields, size, *number_at(bytes, size - 4)};
}

}  // namespace marco::ros
