#include "common/files/points/text_columns.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace marco::files {
namespace {

void set_count(TextColumns& columns) {
  const auto include = [&](std::size_t column) {
    columns.count = std::max(columns.count, column + 1);
  };
  columns.count = 0;
  for (const std::size_t column : columns.xyz) include(column);
  if (columns.intensity) include(*columns.intensity);
  for (std::size_t i = 0; columns.rgb && i < 3; ++i) include((*columns.rgb)[i]);
}

// Black lines say nothing of the scale: a hundred others are looked at.
void find_color_scale(TextRows rows, TextColumns& columns) {
  if (!columns.rgb) return;
  bool bytes = true, fractions = true;
  TextNumbers numbers{};
  for (int colored = 0; colored < 100 && rows.next();) {
    if (rows.numbers(std::span(numbers).first(columns.count)) < columns.count) continue;
    bool is_black = true;
    for (const std::size_t column : *columns.rgb) {
      const double value = numbers[column];
      bytes = bytes && value >= 0.0 && value <= 255.0 && value == std::floor(value);
      fractions = fractions && value >= 0.0 && value <= 1.0;
      is_black = is_black && value == 0.0;
    }
    if (!is_black) ++colored;
  }
  if (!bytes && fractions) columns.rgb_type = Scalar::float32;
  if (!bytes && !fractions) columns.rgb.reset();
}

}  // namespace

TextNumbers TextColumns::numbers(const TextRows& row) const {
  TextNumbers numbers{};
  const std::size_t found = row.numbers(std::span(numbers).first(count));
  if (found < count) {
    row.fail("expected " + std::to_string(count) + " numbers, found " + std::to_string(found));
  }
  return numbers;
}

void TextColumns::add(const TextNumbers& numbers,
                      const Eigen::Vector3d& point_m,
                      PointCollector& points) const {
  points.add(point_m);
  if (intensity) points.cloud.intensities.push_back(static_cast<float>(numbers[*intensity]));
  if (!rgb) return;
  const auto byte = [&](std::size_t i) { return color_byte(numbers[(*rgb)[i]], rgb_type); };
  points.cloud.colors_rgb.push_back({byte(0), byte(1), byte(2)});
}

TextColumns find_text_columns(TextRows rows) {
  const TextRows first = rows;
  TextColumns columns;
  TextNumbers numbers{};
  const std::size_t count = rows.next() ? rows.numbers(numbers) : 0;
  if (count >= 4 && count != 6) columns.intensity = 3;
  if (count == 6) columns.rgb = {3, 4, 5};
  if (count >= 7) columns.rgb = {4, 5, 6};
  set_count(columns);
  find_color_scale(first, columns);
  set_count(columns);
  return columns;
}

TextColumns find_named_columns(const TextRows& rows) {
  std::vector<std::string> names;
  TextFields fields(rows.line());
  for (auto field = fields.next(); !field.empty(); field = fields.next()) {
    names.emplace_back(field);
    std::erase(names.back(), '"');
  }
  names.resize(std::min(names.size(), kMaxTextColumns));
  const PointColumns named = find_point_columns(names);
  if (!named.xyz) return find_text_columns(rows);
  TextColumns columns;
  columns.xyz = *named.xyz;
  columns.intensity = named.intensity;
  columns.rgb = named.rgb;
  set_count(columns);
  find_color_scale(rows, columns);
  set_count(columns);
  return columns;
}

}  // namespace marco::files
