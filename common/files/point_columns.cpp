#include "common/files/point_columns.hpp"

#include <algorithm>
#include <cctype>
#include <vector>

namespace marco::files {
namespace {

using Names = std::vector<std::string>;

std::optional<std::size_t> column_named(const Names& names,
                                        std::initializer_list<const char*> any) {
  for (const char* wanted : any) {
    const auto found = std::find(names.begin(), names.end(), wanted);
    if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
  }
  return std::nullopt;
}

std::optional<std::array<std::size_t, 3>> columns_named(const Names& names,
                                                        const std::array<const char*, 3>& wanted) {
  std::array<std::size_t, 3> columns{};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto column = column_named(names, {wanted[i]});
    if (!column) return std::nullopt;
    columns[i] = *column;
  }
  return columns;
}

}  // namespace

PointColumns find_point_columns(std::span<const std::string> names) {
  Names lower(names.begin(), names.end());
  for (std::string& name : lower) {
    for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  PointColumns columns;
  columns.xyz = columns_named(lower, {"x", "y", "z"});
  columns.intensity = column_named(lower, {"intensity", "i", "reflectance", "reflectivity",
                                           "scalar_intensity", "scalar_reflectance"});
  columns.rgb = columns_named(lower, {"red", "green", "blue"});
  if (!columns.rgb) columns.rgb = columns_named(lower, {"r", "g", "b"});
  if (!columns.rgb) {
    columns.rgb = columns_named(lower, {"diffuse_red", "diffuse_green", "diffuse_blue"});
  }
  columns.normal = columns_named(lower, {"nx", "ny", "nz"});
  return columns;
}

}  // namespace marco::files
