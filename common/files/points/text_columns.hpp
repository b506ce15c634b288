#pragma once

#include <array>

#include "common/files/point_columns.hpp"
#include "common/files/points/point_collector.hpp"
#include "common/files/scalar_types.hpp"
#include "common/files/text_fields.hpp"

namespace marco::files {

constexpr std::size_t kMaxTextColumns = 16;
using TextNumbers = std::array<double, kMaxTextColumns>;

/// What the columns of lines of points mean.
struct TextColumns {
  std::array<std::size_t, 3> xyz = {0, 1, 2};
  std::optional<std::size_t> intensity;
  std::optional<std::array<std::size_t, 3>> rgb;
  Scalar rgb_type = Scalar::uint8;  ///< or float32: 0..1
  std::size_t count = 3;            ///< that a line must have

  /// Reads the row's line. @throws std::invalid_argument naming it where it has fewer numbers.
  TextNumbers numbers(const TextRows& row) const;
  /// Adds a line's point, in metres, and what its numbers say of it.
  void add(const TextNumbers& numbers,
           const Eigen::Vector3d& point_m,
           PointCollector& points) const;
};

/// By how many numbers the next line has (4: an intensity; 6: a colour; 7: both; more are ignored),
/// and by what they are: three numbers that are neither all whole and 0..255 nor all 0..1 in a
/// hundred lines are not a colour.
TextColumns find_text_columns(TextRows rows);

/// As above, but by a line of names, which `rows` stands at.
TextColumns find_named_columns(const TextRows& rows);

}  // namespace marco::files
