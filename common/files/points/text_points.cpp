// Text of a line a point: XYZ, PTS, and uos.
#include "common/files/points/point_formats.hpp"
#include "common/files/points/text_columns.hpp"

namespace marco::files {
namespace {

Eigen::Vector3d metres_of(const TextNumbers& numbers, const TextColumns& columns) {
  const auto& [x, y, z] = columns.xyz;
  return {numbers[x], numbers[y], numbers[z]};
}

// Blocks may differ in what their lines hold: what all have is kept.
void keep_what_all_points_have(PointCloud& cloud) {
  if (cloud.intensities.size() != cloud.points_m.size()) cloud.intensities.clear();
  if (cloud.colors_rgb.size() != cloud.points_m.size()) cloud.colors_rgb.clear();
}

std::size_t point_count(const TextRows& rows) {
  constexpr std::size_t kShortestLine = 6;  // three digits, two blanks, an end
  std::array<double, 2> numbers{};
  const bool is_count =
      rows.numbers(numbers) == 1 && numbers[0] >= 0.0 && numbers[0] == std::floor(numbers[0]);
  if (!is_count) rows.fail("expected a number of points");
  if (numbers[0] > static_cast<double>((rows.bytes_left() + 1) / kShortestLine)) {
    rows.fail("declares more points than the file contains");
  }
  return static_cast<std::size_t>(numbers[0]);
}

}  // namespace

PointCloud read_xyz(const std::string& content, const std::string& name) {
  return collect_points([&](PointCollector& points) {
    TextRows rows(content, name);
    TextRows first = rows;
    std::array<double, 1> number{};
    const bool has_names = first.next() && first.numbers(number) == 0;
    if (has_names) rows = first;
    const TextColumns columns = has_names ? find_named_columns(rows) : find_text_columns(rows);
    while (rows.next()) {
      const TextNumbers numbers = columns.numbers(rows);
      columns.add(numbers, metres_of(numbers, columns), points);
    }
  });
}

PointCloud read_pts(const std::string& content, const std::string& name) {
  return collect_points([&](PointCollector& points) {
    TextRows rows(content, name);
    while (rows.next()) {
      const std::size_t count = point_count(rows);
      const TextColumns columns = find_text_columns(rows);
      for (std::size_t i = 0; i < count; ++i) {
        if (!rows.next()) rows.fail("ends before the last of " + std::to_string(count) + " points");
        const TextNumbers numbers = columns.numbers(rows);
        columns.add(numbers, metres_of(numbers, columns), points);
      }
    }
    keep_what_all_points_have(points.cloud);
  });
}

PointCloud read_uos(const std::string& content, const std::string& name) {
  return collect_points([&](PointCollector& points) {
    TextRows rows(content, name);
    TextRows first = rows;
    std::array<double, 3> numbers_of_header{};
    if (first.next() && first.numbers(numbers_of_header) == 2) rows = first;  // rows and columns
    const TextColumns columns = find_text_columns(rows);
    while (rows.next()) {
      const TextNumbers numbers = columns.numbers(rows);
      columns.add(numbers, 0.01 * Eigen::Vector3d(numbers[2], -numbers[0], numbers[1]), points);
    }
  });
}

}  // namespace marco::files
