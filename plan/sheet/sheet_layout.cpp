#include "plan/sheet/sheet_layout.hpp"

#include <array>
#include <stdexcept>
#include <string>
#include <vector>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/base/format.hpp"

namespace marco::plan {
namespace {

using Vector = Eigen::Vector2d;
using Layout = SheetLayout;

constexpr std::array<Paper, 5> kPapers{
    {{"A4", 297, 210}, {"A3", 420, 297}, {"A2", 594, 420}, {"A1", 841, 594}, {"A0", 1189, 841}}};
constexpr std::array kScales{50, 100, 200, 500, 1000, 2000};

bool fits(const Layout& layout, const Vector& size_m) {
  const Vector size_mm = size_m * (1000.0 / layout.scale);
  return size_mm.x() <= layout.free_width() && size_mm.y() <= layout.free_height();
}

}  // namespace

SheetLayout choose_layout(const SheetWish& wish, const Vector& size_m) {
  std::vector<Paper> papers(kPapers.begin(), kPapers.begin() + (wish.scale == 0 ? 3 : 5));
  if (!wish.paper.empty()) {
    papers.clear();
    for (const Paper& paper : kPapers) {
      if (wish.paper == paper.name) papers.push_back(paper);
    }
    require(!papers.empty(), "paper '" + wish.paper + "' is unknown: A4, A3, A2, A1 or A0");
  }
  std::vector<int> scales{wish.scale};
  if (wish.scale == 0) {
    const std::size_t first = wish.paper.empty() ? 1 : 0;
    scales.assign(kScales.begin() + static_cast<long>(first), kScales.end());
  }
  for (const int scale : scales) {
    for (const Paper& paper : papers) {
      for (const bool upright : {false, true}) {
        const Layout layout{paper, upright, scale};
        if (fits(layout, size_m)) return layout;
      }
    }
  }
  std::string advice = "no standard scale fits";
  for (const int scale : kScales) {
    if (fits({papers.back(), false, scale}, size_m) || fits({papers.back(), true, scale}, size_m)) {
      advice = "1:" + std::to_string(scale) + " fits";
      break;
    }
  }
  throw std::invalid_argument(
      format("a plan of %.1f x %.1f m does not fit on ", size_m.x(), size_m.y()) +
      papers.back().name + " at 1:" + std::to_string(wish.scale) + "; " + advice);
}

}  // namespace marco::plan
