#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>

namespace marco::files {

/// Which columns of a file are what, as their names say.
struct PointColumns {
  std::optional<std::array<std::size_t, 3>> xyz;
  std::optional<std::size_t> intensity;
  std::optional<std::array<std::size_t, 3>> rgb;
  std::optional<std::array<std::size_t, 3>> normal;
};

/// @param names  of the columns, in any case: x y z; intensity, i, reflectance, reflectivity,
/// scalar_intensity; red green blue, r g b, diffuse_red and so on; nx ny nz.
PointColumns find_point_columns(std::span<const std::string> names);

}  // namespace marco::files
