#include "recordings/tilted_rows.hpp"

#include <cmath>
#include <string>

#include "common/files/text_fields.hpp"
#include "common/pose2.hpp"

namespace marco::files {
namespace {

// Whether points lie in rows of a laser that is tilted about its y: of a row all have one slope.
// Other scanners sort theirs otherwise, or not at all.
class TiltedRows {
 public:
  void add(double x, double y, double z) {
    const double bearing_rad = std::atan2(-x, std::hypot(y, z));
    const bool is_new_row = bearing_rad < last_bearing_rad_ - deg_to_rad(90);
    // Beams to the side have no slope.
    const bool has_slope = std::abs(bearing_rad) < deg_to_rad(60);
    if (has_slope && !is_new_row && has_last_) {
      ++compared_;
      const double step_rad = normalize_angle(std::atan2(y, z) - last_tilt_rad_);
      even_ += std::abs(step_rad) < deg_to_rad(1.0) ? 1 : 0;
      rising_ += bearing_rad > last_bearing_rad_ ? 1 : 0;
    }
    if (has_slope) last_tilt_rad_ = std::atan2(y, z);
    has_last_ = has_slope;
    last_bearing_rad_ = bearing_rad;
  }
  bool found() const {
    constexpr double kMost = 0.9;  // of a hundred beams a few are mixed ranges
    return compared_ == 0 || (even_ > kMost * compared_ && rising_ > kMost * compared_);
  }

 private:
  double last_bearing_rad_ = 0.0, last_tilt_rad_ = 0.0;
  bool has_last_ = false;
  int compared_ = 0, even_ = 0, rising_ = 0;
};

}  // namespace

bool lies_in_tilted_rows(std::istream& lines) {
  constexpr int kPoints = 3000;
  TiltedRows rows;
  std::string line;
  for (int i = 0; i < kPoints && read_line(lines, line); ++i) {
    if (line.rfind('#', 0) == 0) continue;
    TextFields fields(line);
    const auto x = fields.number<double>(), y = fields.number<double>(),
               z = fields.number<double>();
    if (x && y && z) rows.add(*x, *y, *z);
  }
  return rows.found();
}

}  // namespace marco::files
