#include "viewer/cell_areas.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <utility>

namespace marco::viewer {
namespace {

cv::Mat view_of(CellMask& mask) {
  return {mask.height(), mask.width(), CV_8U, mask.cells().data()};
}

// Cells beyond the mask count as not set.
CellMask changed_by(CellMask mask, cv::MorphTypes operation) {
  if (mask.cells().empty()) return mask;
  cv::Mat view = view_of(mask);
  cv::morphologyEx(view, view, operation, cv::Mat::ones(3, 3, CV_8U), {-1, -1}, 1,
                   cv::BORDER_CONSTANT, cv::Scalar(0));
  return mask;
}

bool whole_run(const CellMask& mask, int from_x, int end_x, int y) {
  for (int x = from_x; x < end_x; ++x)
    if (!mask.at(x, y)) return false;
  return true;
}

}  // namespace

std::vector<CellArea> connected_areas(CellMask mask) {
  if (mask.cells().empty()) return {};
  cv::Mat labels;
  constexpr int kCornersToo = 8;
  const int count = cv::connectedComponents(view_of(mask), labels, kCornersToo, CV_32S);
  std::vector<CellArea> areas(static_cast<std::size_t>(count - 1));  // label 0: the rest
  for (int y = 0; y < labels.rows; ++y)
    for (int x = 0; x < labels.cols; ++x)
      if (const int label = labels.at<int>(y, x); label > 0)
        areas[static_cast<std::size_t>(label - 1)].emplace_back(x, y);
  return areas;
}

CellMask opened(CellMask mask) { return changed_by(std::move(mask), cv::MORPH_OPEN); }

CellMask closed(CellMask mask) {
  std::vector<uint8_t> before = mask.cells();
  CellMask result = changed_by(std::move(mask), cv::MORPH_CLOSE);
  std::transform(before.begin(), before.end(), result.cells().begin(), result.cells().begin(),
                 [](uint8_t a, uint8_t b) { return std::max(a, b); });
  return result;
}

std::vector<CellRectangle> cover_by_rectangles(CellMask mask) {
  std::vector<CellRectangle> rectangles;
  for (int y = 0; y < mask.height(); ++y) {
    for (int x = 0; x < mask.width(); ++x) {
      if (!mask.at(x, y)) continue;
      int end_x = x, end_y = y;
      while (mask.at(end_x, y)) ++end_x;
      while (whole_run(mask, x, end_x, end_y)) ++end_y;
      for (int taken_y = y; taken_y < end_y; ++taken_y)
        for (int taken_x = x; taken_x < end_x; ++taken_x) mask.set(taken_x, taken_y, false);
      rectangles.push_back({{x, y}, {end_x, end_y}});
    }
  }
  return rectangles;
}

}  // namespace marco::viewer
