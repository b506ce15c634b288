#include "slam/line_slam/lines/line_extractor.hpp"

namespace marco::slam {

LineExtractor::LineExtractor(const LineExtractorOptions& options)
    : points_(options), split_and_merge_(options), fitter_(options) {
  validate(options, "line_extractor");
}

const std::vector<ObservedWall>& LineExtractor::extract(const ScanInRobot& scan) {
  walls_.clear();
  points_.take(scan);
  const std::vector<LinePiece>& pieces = split_and_merge_.find(points_);
  for (std::size_t i = 0; i < pieces.size(); ++i) fitter_.fit(points_, pieces, i, walls_);
  return walls_;
}

}  // namespace marco::slam
