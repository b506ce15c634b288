#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace marco::ros {

/// What a record of a bag is (format 2.0).
enum class BagOp : uint8_t {
  message = 2,
  file_header = 3,
  index = 4,
  chunk = 5,
  chunk_info = 6,
  connection = 7
};

/// The `name=value` fields before a record's data; they stay where they are in memory.
class BagHeader {
 public:
  /// @returns nothing unless the bytes are fields from the first to the last.
  static std::optional<BagHeader> parse(std::span<const uint8_t> bytes);

  /// nullopt where the field is missing or of another size.
  std::optional<uint8_t> u8(std::string_view name) const;
  std::optional<uint32_t> u32(std::string_view name) const;
  std::optional<uint64_t> u64(std::string_view name) const;
  /// Seconds and nanoseconds of 32 bits each, as nanoseconds.
  std::optional<int64_t> time_ns(std::string_view name) const;
  /// "" where it is missing.
  std::string text(std::string_view name) const;

 private:
  explicit BagHeader(std::span<const uint8_t> bytes) : bytes_(bytes) {}
  template <class Number>
  std::optional<Number> number(std::string_view name) const;
  std::optional<std::string_view> find(std::string_view name) const;

  std::span<const uint8_t> bytes_;
};

/// What stands before a record's data.
struct BagRecordHead {
  BagOp op;
  BagHeader fields;
  std::size_t size;    ///< with the length of the data
  uint32_t data_size;  ///< of the data, which follows
};

/// How many bytes of a record have to be there to read its head: 4 tell how many.
std::size_t bag_head_bytes(std::span<const uint8_t> bytes);

/// The head of the record at the start of `bytes`; nothing where it is not whole, or none.
std::optional<BagRecordHead> parse_bag_head(std::span<const uint8_t> bytes);

}  // namespace marco::ros
