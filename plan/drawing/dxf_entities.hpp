#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace marco::plan {

/// An entity of a DXF file, as its pairs say.
struct DxfEntity {
  struct Corner {
    Eigen::Vector2d at = {0, 0};
    double bulge = 0.0;  ///< tangent of a quarter of the arc to the next corner
  };

  std::string type, layer = "0", name;
  std::map<int, double> numbers;  ///< the first of each group code
  std::vector<Corner> corners;    ///< of a polyline

  double number(int code, double otherwise = 0.0) const {
    const auto found = numbers.find(code);
    return found != numbers.end() ? found->second : otherwise;
  }
  bool has_flag(int flag) const { return (static_cast<int64_t>(number(70)) & flag) != 0; }
  Eigen::Vector2d point(int code) const { return {number(code), number(code + 10)}; }
};

/// A DXF file as its entities, before blocks are inserted.
struct DxfFile {
  struct Block {
    Eigen::Vector2d base = {0, 0};
    std::vector<DxfEntity> entities;
  };

  std::vector<DxfEntity> entities;
  std::map<std::string, Block> blocks;
  std::set<std::string> hidden_layers;
  std::optional<double> unit_m;         ///< of $INSUNITS
  std::map<std::string, int> left_out;  ///< on paper space, or invisible
};

/// @throws std::invalid_argument saying what is wrong, to be put behind the file's name.
DxfFile parse_dxf(const std::string& text);

}  // namespace marco::plan
