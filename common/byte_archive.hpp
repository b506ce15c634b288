#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <deque>
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

/// Values as bytes and back, for files that only we write: one function `archive(Archive&, Value&)`
/// lists the fields once, for both directions. Numbers are little-endian, as the machines we run on
/// have them; lists carry their length as 8 bytes. Not thread-safe.
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

/// Trusts nothing: a length is believed only when so many bytes are left, before anything is
/// allocated. @throws std::invalid_argument "is cut short".
class ByteReader {
 public:
  static constexpr bool kReads = true;

  explicit ByteReader(std::string_view bytes) : bytes_(bytes) {}
  void raw(void* to, std::size_t count) {
    require(count <= bytes_.size(), "is cut short");
    if (count > 0) std::memcpy(to, bytes_.data(), count);
    bytes_.remove_prefix(count);
  }
  std::size_t length(std::size_t, std::size_t element_bytes);
  std::size_t left() const { return bytes_.size(); }

 private:
  std::string_view bytes_;
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

/// @param element_bytes  the fewest bytes an element takes
template <class Archive, class List>
void archive_list(Archive& bytes, List& list, std::size_t element_bytes) {
  list.resize(bytes.length(list.size(), element_bytes));
  for (auto& element : list) archive(bytes, element);
}

uint32_t crc32(std::string_view bytes);

/// An envelope about the bytes: `name` (8 letters), version, length, the payload, its CRC-32.
std::string seal(std::string_view name, uint32_t version, std::string_view payload);

/// The payload of an envelope. @throws std::invalid_argument "is no NAME file", "is of version N
/// ...", "is cut short" or "is damaged".
std::string_view unseal(std::string_view name, uint32_t version, std::string_view sealed);

}  // namespace marco
