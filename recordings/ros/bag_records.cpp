#include "recordings/ros/bag_records.hpp"

#include <cstring>

namespace marco::ros {
namespace {

std::optional<uint32_t> length_at(std::span<const uint8_t> bytes, std::size_t at) {
  uint32_t length = 0;
  if (bytes.size() < at + sizeof length) return std::nullopt;
  std::memcpy(&length, bytes.data() + at, sizeof length);
  if (length > bytes.size() - at - sizeof length) return std::nullopt;
  return length;
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
    if (!length_at(rest, 0)) return std::nullopt;
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

std::optional<BagRecord> parse_bag_record(std::span<const uint8_t> bytes) {
  const auto header_length = length_at(bytes, 0);
  if (!header_length) return std::nullopt;
  const std::size_t data_at = 4 + *header_length;
  const auto data_length = length_at(bytes, data_at);
  auto header = BagHeader::parse(bytes.subspan(4, *header_length));
  if (!data_length || !header) return std::nullopt;
  const auto op = header->u8("op");
  if (!op || *op < 2 || *op > 7) return std::nullopt;
  return BagRecord{static_cast<BagOp>(*op), std::move(*header),
                   bytes.subspan(data_at + 4, *data_length), data_at + 4 + *data_length};
}

}  // namespace marco::ros
