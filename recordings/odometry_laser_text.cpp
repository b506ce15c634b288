#include "recordings/text_formats.hpp"

#include "lcm_tools/base/check.hpp"
#include "recordings/no_return_range.hpp"
#include "recordings/text_reader.hpp"

namespace marco::files {
namespace {

class OdometryLaserReader : public TextReader {
 public:
  explicit OdometryLaserReader(const std::filesystem::path& path)
      : TextReader(path, "text log of Odometry and Laser lines") {
    int64_t scans = 0;
    NoReturnRange no_return;
    survey([&](TextFields fields) {
      std::vector<float> ranges_m;
      if (fields.next() != "Laser" || !read_ranges(fields, ranges_m)) return;
      ++scans;
      no_return.add(ranges_m);
    });
    require(scans > 0, path.string() + ": no readable line 'Laser n r1 .. rn'");
    info_.range_max_m = no_return.range_m(kFarthestLaserM);
    info_.range_min_m = 0.02;
    info_.scan_duration_s = 0.00667;  // half a turn of a mirror at 75 Hz
    note_no_return(info_.range_max_m);
    note("no stamps: assuming 0.1 s per scan");
  }

 private:
  void read_line(TextFields fields) override {
    const std::string_view keyword = fields.next();
    if (keyword == "Odometry") {
      const auto pose = read_pose(fields);
      if (pose && is_finite(*pose)) {
        odometry_ = {pose->x_m, pose->y_m, normalize_angle(pose->theta_rad)};
      } else {
        drop_line("unreadable odometry line");
      }
    } else if (keyword == "Laser") {
      LaserScan scan;
      if (!read_ranges(fields, scan.ranges_m)) {
        drop_line("unreadable laser line");
      } else if (scan.size() < 2) {
        drop_line("scan of fewer than 2 beams");
      } else {
        queue_scan(std::move(scan));
      }
    }
  }

  void queue_scan(LaserScan scan) {
    int64_t& scans = report_.given["scans"];
    scan.utime = Utime::from_seconds(kUntimedScanPeriodS * static_cast<double>(scans));
    scan.first_bearing_rad = deg_to_rad(-90.0);
    scan.bearing_step_rad = deg_to_rad(180.0) / static_cast<double>(scan.size() - 1);
    info_.utime = scan.utime;
    if (++scans == 1) queue(info_);
    if (odometry_) {
      queue_odometry(scan.utime, *odometry_);
      ++report_.given["odometry"];
    }
    queue(std::move(scan));
  }

  SensorInfo info_;
  std::optional<Pose2> odometry_;
};

}  // namespace

std::unique_ptr<SampleReader> open_odometry_laser_text(const std::filesystem::path& path) {
  return std::make_unique<OdometryLaserReader>(path);
}

}  // namespace marco::files
