#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <deque>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "common/pose2.hpp"
#include "lcm_tools/base/check.hpp"
#include "lcm_tools/base/utime.hpp"

namespace marco {

/// Values as bytes and back, for files that only we write. `archive(bytes, value)` does both
/// directions. A struct lists its fields once, in a member
/// `template <class Visitor> void visit(Visitor& v) { v("name", field); ... }`; their order is the
/// file's format, the names are for people. Numbers are little-endian, lists carry their length as
/// 8 bytes. Not thread-safe.
class ByteWriter {
 public:
  static constexpr bool kReads = false;

  /// An empty list has no address.
  void raw(void* from, std::size_t count) {
    if (count > 0) bytes_.append(static_cast<const char*>(from), count);
  }
  /// @param element_bytes  the fewest bytes an element takes
  std::size_t length(std::size_t count, std::size_t element_bytes);
  std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

/// Trusts nothing: a length is believed only when that many bytes are left, before anything is
/// allocated. @throws std::invalid_argument "is truncated".
class ByteReader {
 public:
  static constexpr bool kReads = true;
  static constexpr uint32_t kNewest = std::numeric_limits<uint32_t>::max();

  /// @param layout  of the file's fields, see ArchiveVisitor
  explicit ByteReader(std::string_view bytes, uint32_t layout = kNewest)
      : bytes_(bytes), layout_(layout) {}
  uint32_t layout() const { return layout_; }
  void raw(void* to, std::size_t count) {
    require(count <= bytes_.size(), "is truncated");
    if (count > 0) std::memcpy(to, bytes_.data(), count);
    bytes_.remove_prefix(count);
  }
  std::size_t length(std::size_t, std::size_t element_bytes);
  std::size_t left() const { return bytes_.size(); }

 private:
  std::string_view bytes_;
  uint32_t layout_;
};

/// Counts the bytes that a ByteWriter would append.
class ByteCounter {
 public:
  static constexpr bool kReads = false;

  void raw(const void*, std::size_t count) { count_ += count; }
  std::size_t length(std::size_t count, std::size_t) {
    count_ += sizeof(uint64_t);
    return count;
  }
  std::size_t count() const { return count_; }

 private:
  std::size_t count_ = 0;
};

template <class Archive, class T>
requires std::is_arithmetic_v<T>
void archive(Archive& bytes, T& value) {
  if constexpr (std::is_same_v<T, bool>) {
    auto byte = static_cast<uint8_t>(value);
    bytes.raw(&byte, 1);
    value = byte != 0;
  } else {
    bytes.raw(&value, sizeof(T));
    if constexpr (Archive::kReads && std::is_floating_point_v<T>) {
      require(std::isfinite(value), "holds a number that is not finite");
    }
  }
}

template <class Archive, class T>
requires std::is_enum_v<T>
void archive(Archive& bytes, T& value) {
  auto number = static_cast<std::underlying_type_t<T>>(value);
  archive(bytes, number);
  value = static_cast<T>(number);
}

template <class Archive>
void archive(Archive& bytes, Utime& utime) {
  archive(bytes, utime.us);
}

template <class Archive>
void archive(Archive& bytes, Pose2& pose) {
  archive(bytes, pose.x_m);
  archive(bytes, pose.y_m);
  archive(bytes, pose.theta_rad);
}

template <class Archive>
void archive(Archive& bytes, std::string& text) {
  text.resize(bytes.length(text.size(), 1));
  bytes.raw(text.data(), text.size());
}

/// Matrices of doubles: fixed sizes as they are, others with their number of columns.
template <class Archive, int kRows, int kColumns>
void archive(Archive& bytes, Eigen::Matrix<double, kRows, kColumns>& matrix) {
  if constexpr (kColumns == Eigen::Dynamic) {
    const auto columns = static_cast<std::size_t>(matrix.cols());
    matrix.resize(kRows, static_cast<Eigen::Index>(bytes.length(columns, kRows * sizeof(double))));
  }
  bytes.raw(matrix.data(), static_cast<std::size_t>(matrix.size()) * sizeof(double));
  if constexpr (Archive::kReads) {
    require(matrix.allFinite(), "holds a number that is not finite");
  }
}

template <class Archive, class T>
void archive(Archive& bytes, std::optional<T>& value) {
  bool known = value.has_value();
  archive(bytes, known);
  if (known && !value) value.emplace();
  if (known) archive(bytes, *value);
}

/// Passes each field that a visit() lists to archive(). Files of an older layout lack the fields
/// that came since, and hold some that are gone.
template <class Archive>
class ArchiveVisitor {
 public:
  explicit ArchiveVisitor(Archive& bytes) : bytes_(&bytes) {}
  template <class Field>
  void operator()(const char*, Field& field) {
    archive(*bytes_, field);
  }
  /// A field that files have from this layout on; of older ones it keeps its default.
  template <class Field>
  void since(uint32_t layout, const char*, Field& field) {
    if (!is_older_than(layout)) archive(*bytes_, field);
  }
  /// A field that files had before this layout.
  template <class Field>
  void before(uint32_t layout, const char*) {
    Field gone{};
    if (is_older_than(layout)) archive(*bytes_, gone);
  }

 private:
  bool is_older_than(uint32_t layout) const {
    if constexpr (Archive::kReads) return bytes_->layout() < layout;
    return false;
  }
  Archive* bytes_;
};

template <class Archive, class T>
requires requires(T& value, ArchiveVisitor<Archive>& visitor) { value.visit(visitor); }
void archive(Archive& bytes, T& value) {
  ArchiveVisitor<Archive> visitor(bytes);
  value.visit(visitor);
}

/// Bytes that a T takes whose lists and optional values are empty.
template <class T>
std::size_t fewest_bytes() {
  T value{};
  ByteCounter counter;
  archive(counter, value);
  return counter.count();
}

/// @param element_bytes  the fewest bytes an element takes
template <class Archive, class List>
void archive_list(Archive& bytes, List& list, std::size_t element_bytes) {
  list.resize(bytes.length(list.size(), element_bytes));
  for (auto& element : list) archive(bytes, element);
}

template <class Archive, class T>
void archive(Archive& bytes, std::vector<T>& list) {
  archive_list(bytes, list, fewest_bytes<T>());
}

template <class Archive, class T>
void archive(Archive& bytes, std::deque<T>& list) {
  archive_list(bytes, list, fewest_bytes<T>());
}

/// As zlib's.
uint32_t crc32(std::string_view bytes);

/// An envelope about the bytes: `name` (8 letters), version, length, the payload, its CRC-32.
std::string seal(std::string_view name, uint32_t version, std::string_view payload);

/// The payload of an envelope of this version. @throws std::invalid_argument "is no NAME file", "is
/// of version N ...", "is truncated" or "is damaged".
std::string_view unseal(std::string_view name, uint32_t version, std::string_view sealed);

/// The same of any version from the oldest to the newest.
struct Unsealed {
  std::string_view payload;
  uint32_t version;
};
Unsealed unseal(std::string_view name, uint32_t oldest, uint32_t newest, std::string_view sealed);

}  // namespace marco
