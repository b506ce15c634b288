#include "plan/drawing/drawing.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace marco::plan {

int DrawingBuilder::layer(const std::string& name) {
  constexpr std::size_t kLongest = 80, kMost = 5000;
  std::string plain = name.substr(0, kLongest);
  for (char& letter : plain) {
    const auto byte = static_cast<unsigned char>(letter);
    if (byte < 0x20 || byte == 0x7F) letter = '?';
  }
  const auto [place, is_new] = index_.emplace(plain, static_cast<int>(drawing.layers.size()));
  if (is_new) {
    require(drawing.layers.size() < kMost, "has more than 5000 layers");
    drawing.layers.push_back(plain);
  }
  return place->second;
}

void DrawingBuilder::line(const Eigen::Vector2d& from,
                          const Eigen::Vector2d& to,
                          int layer,
                          bool curved) {
  require(from.allFinite() && to.allFinite() && from.cwiseAbs().maxCoeff() <= kFarthest &&
              to.cwiseAbs().maxCoeff() <= kFarthest,
          "contains a point farther away than 1e9 units");
  if (from == to) return;
  require(drawing.lines.size() < kMostLines, "has more than two million lines");
  drawing.lines.push_back({from, to, layer, shape_, curved});
}

int chords_of_span(double span_rad) {
  constexpr double kChordRad = 2.5 * std::numbers::pi / 180.0;
  return std::clamp(static_cast<int>(std::ceil(std::abs(span_rad) / kChordRad - 1e-9)), 1, 144);
}

Drawing read_drawing(const std::string& text) {
  require(!text.starts_with("AC10"), "is a DWG file: save it as DXF");
  require(!text.starts_with("AutoCAD Binary DXF"), "is a binary DXF file: save it as text");
  require(!text.starts_with("%PDF"), "is a PDF file: export the plan as DXF or SVG");
  const std::size_t first = text.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
  require(first != std::string::npos, "is empty");
  return text[first] == '<' ? read_svg(text) : read_dxf(text);
}

}  // namespace marco::plan
