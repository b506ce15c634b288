#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/files/scalar_types.hpp"
#include "common/pose3.hpp"

namespace marco::files {

struct PcdField {
  std::string name;
  Scalar type = Scalar::float32;
  std::size_t count = 1;   ///< numbers of this name
  std::size_t column = 0;  ///< of the first, among all numbers of a point
  std::size_t offset = 0;  ///< of its first byte in a point

  std::size_t bytes() const { return count * size_of(type); }
};

/// The lines before the points of a PCD file.
struct PcdHeader {
  enum class Data : uint8_t { text, binary, compressed };

  std::vector<PcdField> fields;
  std::size_t points = 0;
  std::size_t rows = 0;  ///< 0: the points are in no order
  std::optional<Pose3> world_from_scanner;
  Data data = Data::text;
  std::size_t bytes = 0;        ///< of the header
  std::size_t point_bytes = 0;  ///< of a binary point
  std::size_t columns = 0;      ///< numbers of a point
};

/// Of a file's content. @throws std::invalid_argument beginning with `name`.
PcdHeader read_pcd_header(const std::string& content, const std::string& name);

}  // namespace marco::files
