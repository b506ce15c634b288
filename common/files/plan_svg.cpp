#include "common/files/plan_svg.hpp"

#include "common/files/metre_svg.hpp"

namespace marco::files {

std::string plan_svg(const std::vector<std::vector<Eigen::Vector2d>>& chains) {
  MetreSvg::Points in_view;
  for (const auto& chain : chains) in_view.insert(in_view.end(), chain.begin(), chain.end());
  MetreSvg svg(in_view, "polyline{fill:none;stroke:#222;stroke-width:0.03;stroke-linejoin:round}");
  for (const auto& chain : chains) svg.polyline(chain);
  return svg.finish();
}

}  // namespace marco::files
