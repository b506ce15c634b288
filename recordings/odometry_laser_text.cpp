#include "recordings/odometry_laser_text.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <fstream>

#include "common/files/text_fields.hpp"
#include "lcm_tools/base/check.hpp"

namespace marco::files {
namespace {

class OdometryLaserReader : public SampleReader {
 public:
  explicit OdometryLaserReader(const std::filesystem::path& path)
      : file_(path), path_(path.string()) {
    std::error_code ignored;
    size_ = static_cast<double>(std::filesystem::file_size(path, ignored));
    report_.format = "text log of Odometry and Laser lines";
    report_.paths = {path_};
    survey();
    file_.clear();
    file_.seekg(0);
    read_bytes_ = 0.0;
  }

  std::optional<Sample> next() override {
    while (pending_.empty() && read_line()) {
    }
    if (pending_.empty()) return std::nullopt;
    Sample sample = std::move(pending_.front());
    pending_.pop_front();
    return sample;
  }
  const InputReport& report() const override { return report_; }
  double progress() const override { return size_ > 0 ? std::min(1.0, read_bytes_ / size_) : 1.0; }

 private:
  static bool read_ranges(TextFields& fields, std::vector<float>& ranges_m) {
    const auto count = fields.number<int>();
    if (!count || *count < 0 || static_cast<std::size_t>(*count) > kMaxBeams) return false;
    ranges_m.resize(static_cast<std::size_t>(*count));
    for (float& range_m : ranges_m) {
      const auto value = fields.number<float>();
      if (!value) return false;
      range_m = *value;
    }
    return true;
  }

  void survey() {
    float largest_m = 0.0F;
    int64_t scans = 0;
    while (files::read_line(file_, text_)) {
      TextFields fields(text_);
      std::vector<float> ranges_m;
      if (fields.next() != "Laser" || !read_ranges(fields, ranges_m)) continue;
      ++scans;
      for (const float range_m : ranges_m) {
        if (std::isfinite(range_m)) largest_m = std::max(largest_m, range_m);
      }
    }
    require(scans > 0, path_ + ": no line 'Laser n r1 .. rn' that can be read");
    constexpr double kMargin = 0.999;
    info_.range_max_m = std::max(0.1, kMargin * static_cast<double>(largest_m));
    info_.range_min_m = 0.02;
    info_.scan_duration_s = 0.00667;  // half a turn of a mirror at 75 Hz
    char note[120];
    std::snprintf(note, sizeof note, "ranges of %.3f m and more are taken for no return",
                  info_.range_max_m);
    report_.notes.emplace_back(note);
    report_.notes.emplace_back("no stamps: 0.1 s a scan is assumed");
  }

  bool read_line() {
    if (!files::read_line(file_, text_)) return false;
    ++line_number_;
    read_bytes_ += static_cast<double>(text_.size()) + 1.0;
    TextFields fields(text_);
    const std::string_view keyword = fields.next();
    const std::string place = "line " + std::to_string(line_number_);
    if (keyword == "Odometry") {
      const auto x = fields.number<double>(), y = fields.number<double>(),
                 theta = fields.number<double>();
      if (!x || !y || !theta || !is_finite(Pose2{*x, *y, *theta})) {
        report_.drop("odometry line that cannot be read", place);
      } else {
        odometry_ = Pose2{*x, *y, normalize_angle(*theta)};
      }
    } else if (keyword == "Laser") {
      LaserScan scan;
      if (!read_ranges(fields, scan.ranges_m)) {
        report_.drop("laser line that cannot be read", place);
      } else if (scan.ranges_m.size() < 2) {
        report_.drop("scan of fewer than 2 beams", place);
      } else {
        emit(std::move(scan));
      }
    }
    return true;
  }

  void emit(LaserScan scan) {
    scan.utime = Utime::from_seconds(kUntimedScanPeriodS * static_cast<double>(scans_++));
    const double intervals = static_cast<double>(scan.size() - 1);
    scan.first_bearing_rad = deg_to_rad(-90.0);
    scan.bearing_step_rad = deg_to_rad(180.0) / intervals;
    info_.utime = scan.utime;
    if (scans_ == 1) pending_.emplace_back(info_);
    if (odometry_) {
      OdometrySample sample;
      sample.utime = scan.utime;
      sample.odom_from_robot = *odometry_;
      pending_.emplace_back(sample);
      ++report_.given["odometry"];
    }
    pending_.emplace_back(std::move(scan));
    ++report_.given["scans"];
  }

  std::ifstream file_;
  std::string path_;
  std::string text_;
  double size_ = 0.0;
  double read_bytes_ = 0.0;
  int64_t line_number_ = 0;
  int64_t scans_ = 0;
  SensorInfo info_;
  std::optional<Pose2> odometry_;
  std::deque<Sample> pending_;
  InputReport report_;
};

}  // namespace

std::unique_ptr<SampleReader> open_odometry_laser_text(const std::filesystem::path& path) {
  return std::make_unique<OdometryLaserReader>(path);
}

}  // namespace marco::files
