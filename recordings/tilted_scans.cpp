#include "recordings/tilted_scans.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <istream>
#include <map>
#include <sstream>
#include <string>

#include "common/files/text_fields.hpp"
#include "common/pose2.hpp"
#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/readable.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "lcmtypes/channels.hpp"

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

/// Whether the points of a uos file (x right, y up, z ahead) lie in rows of a laser that is tilted,
/// by the first few thousand; a file of one row does.
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

namespace fs = std::filesystem;

constexpr double kPauseS = 5.0;  // between two scans, while the robot is moved
constexpr const char* kUnreadablePoint = "unreadable point";

enum class Kind { ranges_mm, uos_points, polar, unknown };

struct Row {
  double tilt_rad = 0.0;
  double first_bearing_rad = 0.0;
  double step_rad = 0.0;
  std::vector<float> ranges_m;
};

Kind kind_of(const fs::path& path) {
  constexpr int kLines = 5;
  constexpr std::size_t kLongestLine = 200000;
  std::istringstream file(first_bytes(path, kLines * (kLongestLine + 1)));
  std::string line;
  for (int i = 0; i < kLines && read_line(file, line); ++i) {
    if (line.size() > kLongestLine) return Kind::unknown;
    if (line.rfind("# line,tilt_deg", 0) == 0) return Kind::polar;
    if (line.rfind('#', 0) == 0) continue;
    TextFields fields(line);
    int numbers = 0;
    while (fields.number<double>()) ++numbers;
    const bool all_numbers = fields.next().empty();
    if (!all_numbers) return Kind::unknown;
    if (path.extension() == ".3d" && numbers >= 3) {
      std::ifstream points = open_readable(path);
      return lies_in_tilted_rows(points) ? Kind::uos_points : Kind::unknown;
    }
    if (numbers > 50 && line.find(',') != std::string::npos) return Kind::ranges_mm;
    if (numbers == 4 && line.find(',') != std::string::npos) return Kind::polar;
    return Kind::unknown;
  }
  return Kind::unknown;
}

std::string stem_of(const fs::path& path) {
  const std::string stem = path.stem().string();
  return (path.parent_path() / stem.substr(0, stem.find("_tilt_ranges"))).string();
}

// Calls `read_line` with each line that is no comment; it returns why the line cannot be used, or
// nullptr.
template <class ReadLine>
void for_each_line(const fs::path& path, InputReport& report, const ReadLine& read_line_fields) {
  std::ifstream file = open_readable(path);
  std::string line;
  for (int number = 1; read_line(file, line); ++number) {
    if (line.rfind('#', 0) == 0) continue;
    TextFields fields(line);
    const char* fault = read_line_fields(fields);
    if (fault != nullptr) report.drop(fault, path.string() + ":" + std::to_string(number));
  }
}

std::vector<Row> read_ranges_mm(const fs::path& path, InputReport& report) {
  std::vector<Row> rows;
  for_each_line(path, report, [&rows](TextFields& fields) -> const char* {
    const auto tilt_deg = fields.number<double>();
    Row row{0.0, deg_to_rad(-90.0), deg_to_rad(0.5), {}};
    while (const auto range_mm = fields.number<double>()) {
      row.ranges_m.push_back(static_cast<float>(*range_mm * 1e-3));
    }
    if (!tilt_deg || row.ranges_m.size() < 2) return "unreadable row";
    row.tilt_rad = deg_to_rad(*tilt_deg);
    rows.push_back(std::move(row));
    return nullptr;
  });
  return rows;
}

std::vector<Row> read_uos_points(const fs::path& path, InputReport& report) {
  std::vector<Row> rows;
  Row row;
  double last_bearing_rad = 0.0, up = 0.0, ahead = 0.0;
  const auto finish_row = [&] {
    if (row.ranges_m.size() >= 2) {
      row.tilt_rad = std::atan2(up, ahead);
      row.step_rad =
          (last_bearing_rad - row.first_bearing_rad) / static_cast<double>(row.ranges_m.size() - 1);
      rows.push_back(std::move(row));
    }
    row = {};
    up = ahead = 0.0;
  };
  for_each_line(path, report, [&](TextFields& fields) -> const char* {
    const auto x = fields.number<double>(), y = fields.number<double>(),
               z = fields.number<double>();
    if (!x || !y || !z) return kUnreadablePoint;
    const double bearing_rad = std::atan2(-*x, std::hypot(*y, *z));
    const bool back_to_the_right =
        !row.ranges_m.empty() && bearing_rad < last_bearing_rad - deg_to_rad(90);
    if (back_to_the_right || row.ranges_m.size() >= kMaxBeams) finish_row();
    if (row.ranges_m.empty()) row.first_bearing_rad = bearing_rad;
    last_bearing_rad = bearing_rad;
    row.ranges_m.push_back(static_cast<float>(0.01 * std::hypot(*x, *y, *z)));
    up += *y;
    ahead += *z;
    return nullptr;
  });
  finish_row();
  return rows;
}

// Beams lie on a grid of whole degrees, which shifts from line to line. A missing beam had no
// return.
std::vector<Row> read_polar(const fs::path& path, InputReport& report) {
  std::vector<Row> rows;
  double last_line = -1.0;
  std::size_t width = 0;
  for_each_line(path, report, [&](TextFields& fields) -> const char* {
    const auto index = fields.number<double>(), tilt_deg = fields.number<double>(),
               bearing_deg = fields.number<double>(), range_m = fields.number<double>();
    if (!index || !tilt_deg || !bearing_deg || !range_m || std::abs(*bearing_deg) > 180.0) {
      return kUnreadablePoint;
    }
    if (*index != last_line) {
      last_line = *index;
      const double shift_deg = *bearing_deg - std::floor(*bearing_deg);
      rows.push_back({deg_to_rad(*tilt_deg), deg_to_rad(-90.0 + shift_deg), deg_to_rad(1.0), {}});
    }
    Row& row = rows.back();
    const double column =
        std::round((deg_to_rad(*bearing_deg) - row.first_bearing_rad) / row.step_rad);
    if (column < 0.0 || column > 360.0) return "point outside the half circle";
    const auto at = static_cast<std::size_t>(column);
    width = std::max(width, at + 1);
    if (row.ranges_m.size() <= at) row.ranges_m.resize(at + 1, 0.0F);
    row.ranges_m[at] = static_cast<float>(*range_m);
    return nullptr;
  });
  for (Row& row : rows) row.ranges_m.resize(width, 0.0F);  // a scene is a grid of rows and columns
  return rows;
}

// Left-handed x right, y up, z ahead [cm], turned about y by the second angle [deg], clockwise from
// above.
Pose2 read_pose(const fs::path& path, InputReport& report) {
  std::error_code ignored;
  if (!fs::exists(path, ignored)) return {};
  std::string text = read_whole_file(path);
  std::replace(text.begin(), text.end(), '\n', ' ');
  TextFields fields(text);
  double values[6] = {};
  for (double& value : values) {
    const auto number = fields.number<double>();
    if (!number || !std::isfinite(*number)) {
      report.drop("unreadable pose", path.string());
      return {};
    }
    value = *number;
  }
  return {0.01 * values[2], -0.01 * values[0], normalize_angle(-deg_to_rad(values[4]))};
}

using ReadRows = std::vector<Row> (*)(const fs::path&, InputReport&);
ReadRows reader_of(Kind kind) {
  if (kind == Kind::ranges_mm) return read_ranges_mm;
  return kind == Kind::uos_points ? read_uos_points : read_polar;
}

class TiltedScanReader : public QueuedReader {
 public:
  explicit TiltedScanReader(const std::vector<fs::path>& paths) {
    std::map<std::string, fs::path> files;  // by stem: a .csv before a .3d
    for (const fs::path& path : paths) {
      if (!fs::is_directory(path)) {
        add_file(path, files);
        continue;
      }
      for (const auto& entry : fs::directory_iterator(path)) {
        if (entry.is_regular_file()) add_file(entry.path(), files);
      }
    }
    for (const auto& [stem, path] : files) report_.paths.push_back(path.string());
    require(!fs::exists(paths.front() / "map.yaml"),
            paths.front().string() +
                ": this is a map folder: pass it to --extend or --localize together with a "
                "recording, or several of one building to --merge");
    require(!files.empty(), paths.front().string() +
                                ": no 3D scan in it (*_tilt_ranges_mm.csv, *.3d or "
                                "scan_polar.csv)");
    report_.format = "3D scans of a tilted laser";
    note("no stamps: assuming 0.1 s per row");
  }

  double progress() const override {
    return static_cast<double>(file_) / static_cast<double>(report_.paths.size());
  }

 private:
  static void add_file(const fs::path& path, std::map<std::string, fs::path>& files) {
    const Kind kind = kind_of(path);
    if (kind == Kind::unknown) return;
    const auto [entry, is_new] = files.try_emplace(stem_of(path), path);
    if (!is_new && kind == Kind::ranges_mm) entry->second = path;
  }

  bool read_piece() override {
    if (file_ == report_.paths.size()) return false;
    const fs::path path = report_.paths[file_++];
    const Kind kind = kind_of(path);
    std::vector<Row> rows = reader_of(kind)(path, report_);
    if (rows.empty()) {
      report_.drop("scan without a row", path.string());
      return true;
    }
    if (!announced_) announce(kind);
    const Pose2 pose = read_pose(stem_of(path) + ".pose", report_);
    for (Row& row : rows) {
      const Utime now = Utime::from_seconds(time_s_);
      queue_odometry(now, pose);
      PanTiltState state;
      state.utime = now;
      state.tilt_rad = row.tilt_rad;
      queue(state);
      LaserScan scan;
      scan.utime = now;
      scan.first_bearing_rad = row.first_bearing_rad;
      scan.bearing_step_rad = row.step_rad;
      scan.ranges_m = std::move(row.ranges_m);
      queue(std::move(scan));
      time_s_ += kUntimedScanPeriodS;
      ++report_.given["scans"];
    }
    ++report_.given["3D scans"];
    time_s_ += kPauseS;
    return true;
  }

  void announce(Kind kind) {
    announced_ = true;
    SensorInfo base;
    base.channel = channels::kPanTiltState;
    SensorInfo laser;
    laser.mount = SensorInfo::Mount::pantilt;
    laser.range_min_m = 0.48;  // nearer is the robot itself
    laser.range_max_m = 32.0;  // codes of the 32 m millimetre mode lie above
    laser.range_sigma_m = 0.01;
    if (kind == Kind::polar) {
      base.parent_from_sensor.translation().z() = 0.340;
      laser.parent_from_sensor.translation().z() = 0.160;
    } else {
      note("the height of the laser is unknown: z = 0 is the tilt axis");
    }
    queue(base);
    queue(laser);
  }

  std::size_t file_ = 0;  // the next of report_.paths
  double time_s_ = 0.0;
  bool announced_ = false;
};

}  // namespace

std::unique_ptr<SampleReader> open_tilted_scans(const std::vector<std::filesystem::path>& paths) {
  require(!paths.empty(), "open_tilted_scans: no path given");
  return std::make_unique<TiltedScanReader>(paths);
}

bool is_tilted_scan(const std::filesystem::path& path) { return kind_of(path) != Kind::unknown; }

}  // namespace marco::files
