#include "recordings/carmen.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <fstream>
#include <limits>

#include "common/files/text_fields.hpp"
#include "lcm_tools/base/check.hpp"

namespace marco::files {
namespace {

constexpr double kCodeMargin = 0.99;  // codes of one device lie close together: 81.83, 81.91
constexpr int64_t kCodeRepeats = 20;

// One laser line of either kind.
struct LaserLine {
  bool rear = false;
  bool has_geometry = false;  // ROBOTLASER: says its own start, resolution and maximum
  double first_bearing_rad = 0.0;
  double step_rad = 0.0;
  double range_max_m = 0.0;
  std::vector<float> ranges_m;
  Pose2 laser;
  Pose2 robot;
  double ipc_time_s = 0.0;
};

std::optional<Pose2> read_pose(TextFields& fields) {
  const auto x = fields.number<double>(), y = fields.number<double>(),
             theta = fields.number<double>();
  if (!x || !y || !theta) return std::nullopt;
  return Pose2{*x, *y, *theta};
}

bool read_ranges(TextFields& fields, std::vector<float>& ranges_m) {
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

bool read_poses_and_time(TextFields& fields, LaserLine& line, int fields_between) {
  const auto laser = read_pose(fields), robot = read_pose(fields);
  for (int i = 0; i < fields_between; ++i) fields.next();
  const auto time_s = fields.number<double>();
  if (!laser || !robot || !time_s || !is_finite(*robot) || !std::isfinite(*time_s)) return false;
  line.laser = *laser;
  line.robot = *robot;
  line.ipc_time_s = *time_s;
  return true;
}

// nothing: no laser line; a line with empty ranges and `broken`: one that cannot be read.
struct Parsed {
  bool is_laser = false;
  bool whole = false;
  LaserLine line;
};

Parsed parse(const std::string& text) {
  Parsed parsed;
  TextFields fields(text);
  const std::string_view keyword = fields.next();
  LaserLine& line = parsed.line;
  line.rear = keyword == "RLASER" || keyword == "ROBOTLASER2";
  if (keyword == "FLASER" || keyword == "RLASER") {
    parsed.is_laser = true;
    parsed.whole = read_ranges(fields, line.ranges_m) && read_poses_and_time(fields, line, 0);
  } else if (keyword == "ROBOTLASER1" || keyword == "ROBOTLASER2") {
    parsed.is_laser = true;
    line.has_geometry = true;
    fields.next();  // the laser's type
    const auto start = fields.number<double>();
    fields.next();  // field of view
    const auto step = fields.number<double>(), range_max = fields.number<double>();
    fields.next();  // accuracy
    fields.next();  // remission mode
    if (!start || !step || !range_max || !read_ranges(fields, line.ranges_m)) return parsed;
    line.first_bearing_rad = *start;
    line.step_rad = *step;
    line.range_max_m = *range_max;
    std::vector<float> remissions;
    constexpr int kVelocitiesAndSafety = 5;
    parsed.whole =
        read_ranges(fields, remissions) && read_poses_and_time(fields, line, kVelocitiesAndSafety);
  }
  return parsed;
}

void set_old_geometry(LaserLine& line) {
  const std::size_t count = line.ranges_m.size();
  // An even count leaves the last beam of the half circle out.
  const double fov_deg = count == 401 ? 100.0 : 180.0;
  const std::size_t intervals = count % 2 == 0 ? count : count - 1;
  line.first_bearing_rad = deg_to_rad(-0.5 * fov_deg);
  line.step_rad = intervals > 0 ? deg_to_rad(fov_deg) / static_cast<double>(intervals) : 0.0;
}

class CarmenReader : public SampleReader {
 public:
  explicit CarmenReader(const std::filesystem::path& path) : file_(path), path_(path.string()) {
    std::error_code ignored;
    size_ = static_cast<double>(std::filesystem::file_size(path, ignored));
    report_.format = "CARMEN log";
    report_.paths = {path_};
    survey();
    file_.clear();
    file_.seekg(0);
    read_bytes_ = 0.0;
  }

  std::optional<Sample> next() override {
    while (pending_.empty() && read_line()) {
    }
    if (pending_.empty()) {
      finish_report();
      return std::nullopt;
    }
    Sample sample = std::move(pending_.front());
    pending_.pop_front();
    return sample;
  }
  const InputReport& report() const override { return report_; }
  double progress() const override { return size_ > 0 ? std::min(1.0, read_bytes_ / size_) : 1.0; }

 private:
  // Reads the whole file once: how many laser lines, and which range means that nothing came back.
  void survey() {
    int64_t lines = 0;
    std::map<float, int64_t> largest;  // the largest few values and how often each was met
    constexpr std::size_t kLargest = 8;
    float least = -std::numeric_limits<float>::infinity();
    while (files::read_line(file_, text_)) {
      const Parsed parsed = parse(text_);
      if (!parsed.is_laser || !parsed.whole) continue;
      ++lines;
      for (const float range_m : parsed.line.ranges_m) {
        if (range_m < least || !std::isfinite(range_m)) continue;
        ++largest[range_m];
        if (largest.size() > kLargest) largest.erase(largest.begin());
        if (largest.size() == kLargest) least = largest.begin()->first;
      }
    }
    require(lines > 0, path_ + ": no laser line (FLASER, RLASER or ROBOTLASER1) that can be read");
    for (const auto& [range_m, count] : largest) {
      if (count >= kCodeRepeats) no_return_m_ = kCodeMargin * static_cast<double>(range_m);
    }
    constexpr double kFarthestLaserM = 80.0;
    if (!(no_return_m_ > 0.0)) no_return_m_ = kFarthestLaserM;
    char note[120];
    std::snprintf(note, sizeof note, "ranges of %.2f m and more are taken for no return",
                  no_return_m_);
    report_.notes.emplace_back(note);
  }

  bool read_line() {
    if (!files::read_line(file_, text_)) return false;
    ++line_number_;
    read_bytes_ += static_cast<double>(text_.size()) + 1.0;
    if (text_.rfind("ODOM ", 0) == 0) ++odometry_lines_;
    Parsed parsed = parse(text_);
    if (!parsed.is_laser) return true;
    const std::string place = "line " + std::to_string(line_number_);
    if (!parsed.whole) {
      report_.drop("laser line that cannot be read", place);
    } else if (parsed.line.ranges_m.size() < 2) {
      report_.drop("scan of fewer than 2 beams", place);
    } else {
      emit(parsed.line);
    }
    return true;
  }

  void emit(LaserLine& line) {
    if (!line.has_geometry) set_old_geometry(line);
    LaserScan scan;
    scan.utime = Utime::from_seconds(line.ipc_time_s);
    scan.channel = line.rear ? "LIDAR_REAR" : "LIDAR";
    scan.first_bearing_rad = line.first_bearing_rad;
    scan.bearing_step_rad = line.step_rad;
    if (!infos_.contains(scan.channel)) announce(line, scan);
    if (scan.utime < last_utime_) ++backward_stamps_;
    last_utime_ = scan.utime;
    scan.ranges_m = std::move(line.ranges_m);
    OdometrySample odometry;
    odometry.utime = scan.utime;
    odometry.odom_from_robot = line.robot;
    odometry.odom_from_robot.theta_rad = normalize_angle(line.robot.theta_rad);
    pending_.emplace_back(odometry);
    pending_.emplace_back(std::move(scan));
    ++report_.given["scans"];
    ++report_.given["odometry"];
  }

  void announce(const LaserLine& line, const LaserScan& scan) {
    SensorInfo info;
    info.utime = scan.utime;
    info.channel = scan.channel;
    info.range_min_m = 0.02;
    info.range_max_m = line.has_geometry && line.range_max_m > 0.0
                           ? std::min(no_return_m_, line.range_max_m)
                           : no_return_m_;
    // A SICK's mirror turns 75 times a second, half a turn a scan of whole degrees.
    info.scan_duration_s = std::abs(line.step_rad) > deg_to_rad(0.75) ? 0.00667 : 0.02;
    const Pose2 offset = between(line.robot, line.laser);
    constexpr double kLargestRobotM = 1.5;
    if (line.has_geometry && offset.translation_m().norm() < kLargestRobotM) {
      info.parent_from_sensor = lift(offset);
    } else if (line.rear) {
      info.parent_from_sensor = lift({0.0, 0.0, deg_to_rad(180)});
    }
    infos_[scan.channel] = info;
    pending_.emplace_back(info);
  }

  void finish_report() {
    if (finished_) return;
    finished_ = true;
    if (backward_stamps_ > 0) {
      report_.notes.push_back(std::to_string(backward_stamps_) +
                              " stamps step backwards: scans are used in the order of the file");
    }
    if (odometry_lines_ > 0) {
      report_.notes.push_back(std::to_string(odometry_lines_) +
                              " ODOM lines passed by: each laser line has its own odometry");
    }
  }

  std::ifstream file_;
  std::string path_;
  std::string text_;
  double size_ = 0.0;
  double read_bytes_ = 0.0;
  int64_t line_number_ = 0;
  int64_t backward_stamps_ = 0;
  int64_t odometry_lines_ = 0;
  double no_return_m_ = 0.0;
  Utime last_utime_;
  bool finished_ = false;
  std::map<std::string, SensorInfo> infos_;
  std::deque<Sample> pending_;
  InputReport report_;
};

}  // namespace

std::unique_ptr<SampleReader> open_carmen(const std::filesystem::path& path) {
  return std::make_unique<CarmenReader>(path);
}

}  // namespace marco::files
