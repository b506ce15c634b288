#include "recordings/text_formats.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>

#include "lcm_tools/base/check.hpp"
#include "recordings/no_return_range.hpp"
#include "recordings/text_reader.hpp"

namespace marco::files {
namespace {

struct LaserKeyword {
  std::string_view word;
  bool rear;
  bool says_geometry;  // its own first bearing, step and maximum range
};
constexpr std::array<LaserKeyword, 4> kLaserKeywords{{{"FLASER", false, false},
                                                      {"RLASER", true, false},
                                                      {"ROBOTLASER1", false, true},
                                                      {"ROBOTLASER2", true, true}}};

const LaserKeyword* laser_keyword(std::string_view word) {
  const auto found = std::find_if(kLaserKeywords.begin(), kLaserKeywords.end(),
                                  [&](const LaserKeyword& known) { return known.word == word; });
  return found == kLaserKeywords.end() ? nullptr : &*found;
}

struct LaserLine {
  double first_bearing_rad = 0.0;
  double step_rad = 0.0;
  double range_max_m = 0.0;  // 0: unknown
  std::vector<float> ranges_m;
  Pose2 laser;  // may be nan
  Pose2 robot;
  double ipc_time_s = 0.0;
};

void skip(TextFields& fields, int count) {
  for (int i = 0; i < count; ++i) fields.next();
}

bool read_geometry(TextFields& fields, LaserLine& line) {
  skip(fields, 1);  // the laser's type
  const auto start = fields.number<double>();
  skip(fields, 1);  // field of view
  const auto step = fields.number<double>(), range_max = fields.number<double>();
  skip(fields, 2);  // accuracy, remission mode
  if (!start || !step || !range_max) return false;
  line.first_bearing_rad = *start;
  line.step_rad = *step;
  line.range_max_m = *range_max;
  return true;
}

// An even number of beams leaves out the last beam of the half circle.
void assume_geometry(LaserLine& line) {
  const std::size_t count = line.ranges_m.size();
  const double fov_deg = count == 401 ? 100.0 : 180.0;
  const std::size_t intervals = count % 2 == 0 ? count : count - 1;
  line.first_bearing_rad = deg_to_rad(-0.5 * fov_deg);
  line.step_rad = intervals > 0 ? deg_to_rad(fov_deg) / static_cast<double>(intervals) : 0.0;
}

/// @param fields  behind the keyword. @returns nothing for a line that cannot be read.
std::optional<LaserLine> parse(const LaserKeyword& keyword, TextFields fields) {
  LaserLine line;
  if (keyword.says_geometry && !read_geometry(fields, line)) return std::nullopt;
  if (!read_ranges(fields, line.ranges_m)) return std::nullopt;
  if (!keyword.says_geometry) assume_geometry(line);
  std::vector<float> remissions;
  if (keyword.says_geometry && !read_ranges(fields, remissions)) return std::nullopt;
  const auto laser = read_pose(fields), robot = read_pose(fields);
  constexpr int kVelocitiesAndSafety = 5;
  if (keyword.says_geometry) skip(fields, kVelocitiesAndSafety);
  const auto time_s = fields.number<double>();
  if (!laser || !robot || !time_s || !is_finite(*robot) || !std::isfinite(*time_s)) {
    return std::nullopt;
  }
  line.laser = *laser;
  line.robot = *robot;
  line.ipc_time_s = *time_s;
  return line;
}

class CarmenReader : public TextReader {
 public:
  explicit CarmenReader(const std::filesystem::path& path) : TextReader(path, "CARMEN log") {
    int64_t lines = 0;
    NoReturnRange no_return;
    survey([&](TextFields fields) {
      const LaserKeyword* keyword = laser_keyword(fields.next());
      const auto line = keyword == nullptr ? std::nullopt : parse(*keyword, fields);
      if (!line) return;
      ++lines;
      no_return.add(line->ranges_m);
    });
    require(lines > 0, path.string() +
                           ": no readable laser line (FLASER, RLASER or ROBOTLASER1): one with as "
                           "many ranges as it declares, at most 100000");
    no_return_m_ = no_return.range_m(kFarthestLaserM);
    note_no_return(no_return_m_);
  }

 private:
  void read_line(TextFields fields) override {
    const std::string_view word = fields.next();
    if (word == "ODOM") ++odometry_lines_;
    const LaserKeyword* keyword = laser_keyword(word);
    if (keyword == nullptr) return;
    std::optional<LaserLine> line = parse(*keyword, fields);
    if (!line) {
      drop_line("unreadable laser line");
    } else if (line->ranges_m.size() < 2) {
      drop_line("scan of fewer than 2 beams");
    } else {
      queue_scan(*keyword, *line);
    }
  }

  void queue_scan(const LaserKeyword& keyword, LaserLine& line) {
    LaserScan scan;
    scan.utime = Utime::from_seconds(line.ipc_time_s);
    scan.channel = keyword.rear ? "LIDAR_REAR" : "LIDAR";
    scan.first_bearing_rad = line.first_bearing_rad;
    scan.bearing_step_rad = line.step_rad;
    if (announced_.insert(scan.channel).second) queue(sensor_info(keyword, line, scan));
    if (scan.utime < last_utime_) ++backward_stamps_;
    last_utime_ = scan.utime;
    scan.ranges_m = std::move(line.ranges_m);
    const Pose2& robot = line.robot;
    queue_odometry(scan.utime, {robot.x_m, robot.y_m, normalize_angle(robot.theta_rad)});
    queue(std::move(scan));
    ++report_.given["scans"];
    ++report_.given["odometry"];
  }

  SensorInfo sensor_info(const LaserKeyword& keyword,
                         const LaserLine& line,
                         const LaserScan& scan) const {
    SensorInfo info;
    info.utime = scan.utime;
    info.channel = scan.channel;
    info.range_min_m = 0.02;
    info.range_max_m =
        line.range_max_m > 0.0 ? std::min(no_return_m_, line.range_max_m) : no_return_m_;
    // A SICK's mirror turns 75 times a second, half a turn a scan of whole degrees.
    info.scan_duration_s = std::abs(line.step_rad) > deg_to_rad(0.75) ? 0.00667 : 0.02;
    constexpr double kLargestRobotM = 1.5;
    const Pose2 offset = between(line.robot, line.laser);
    if (keyword.says_geometry && offset.translation_m().norm() < kLargestRobotM) {
      info.parent_from_sensor = lift(offset);
    } else if (keyword.rear) {
      info.parent_from_sensor = lift({0.0, 0.0, deg_to_rad(180)});
    }
    return info;
  }

  void finish_report() override {
    if (backward_stamps_ > 0) {
      note("%lld stamps step backwards: scans are used in the order of the file",
           static_cast<long long>(backward_stamps_));
    }
    if (odometry_lines_ > 0) {
      note("%lld ODOM lines skipped: each laser line has its own odometry",
           static_cast<long long>(odometry_lines_));
    }
  }

  double no_return_m_ = 0.0;
  std::set<std::string> announced_;  // channels whose SensorInfo is queued
  Utime last_utime_;
  int64_t backward_stamps_ = 0;
  int64_t odometry_lines_ = 0;
};

}  // namespace

std::unique_ptr<SampleReader> open_carmen(const std::filesystem::path& path) {
  return std::make_unique<CarmenReader>(path);
}

}  // namespace marco::files
