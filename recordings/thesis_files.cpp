#include "recordings/text_formats.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/files/text_fields.hpp"
#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "lcmtypes/channels.hpp"

namespace marco::files {
namespace {

constexpr std::size_t kPointsA = 133;
constexpr std::size_t kNumbersA = 2 * kPointsA + 3;
constexpr std::size_t kBeamsB = 361;
constexpr std::size_t kNumbersB = 2 * kBeamsB + 4;
constexpr std::uintmax_t kMaxFileBytes = 512U << 20U;

// B's pairs begin with bearings that grow by half a degree.
bool fits_b(const std::vector<double>& numbers) {
  return numbers.size() >= kNumbersB && std::abs(numbers[2] - numbers[0] - 0.5) < 0.01 &&
         std::abs(numbers[4] - numbers[2] - 0.5) < 0.01;
}
bool fits_a(const std::vector<double>& numbers) {
  return numbers.size() >= kNumbersA && numbers.size() % kNumbersA == 0;
}

// All numbers of the file; nothing where there is anything else in it, or they fit neither thesis.
std::optional<std::vector<double>> read_numbers(const std::filesystem::path& path) {
  std::error_code ignored;
  if (std::filesystem::file_size(path, ignored) > kMaxFileBytes || ignored) return std::nullopt;
  std::string text = read_whole_file(path);
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == '\n' || c == '\v'; }, ' ');
  TextFields fields(text);
  std::vector<double> numbers;
  while (true) {
    TextFields here = fields;
    const auto number = fields.number<double>();
    if (number) {
      numbers.push_back(*number);
      continue;
    }
    const bool fits = here.next().empty() && (fits_a(numbers) || fits_b(numbers));
    return fits ? std::optional(numbers) : std::nullopt;
  }
}

class ThesisReader : public QueuedReader {
 public:
  explicit ThesisReader(const std::filesystem::path& path) {
    auto numbers = read_numbers(path);
    require(
        numbers.has_value(),
        path.string() + ": its numbers are neither scans of 133 points nor sweeps of 361 beams");
    numbers_ = std::move(*numbers);
    is_b_ = fits_b(numbers_);
    report_.paths = {path.string()};
    report_.format = is_b_ ? "thesis B sweeps" : "thesis A scans";
    note("no stamps: assuming 0.1 s per scan");
    SensorInfo info;
    info.range_min_m = 0.02;
    info.range_max_m = is_b_ ? 32.0 : 50.0;
    if (is_b_) {
      drop_repeated_end();
      SensorInfo base;
      base.channel = channels::kPanTiltState;
      queue(base);
      info.mount = SensorInfo::Mount::pantilt;
      info.parent_from_sensor = make_pose3({0.045, 0.0, 0.008});  // thesis B, app. D
    }
    queue(info);
  }

  double progress() const override {
    return static_cast<double>(at_) / static_cast<double>(numbers_.size());
  }

 private:
  bool read_piece() override {
    const std::size_t size = is_b_ ? kNumbersB : kNumbersA;
    if (at_ + size > numbers_.size()) {
      if (at_ < numbers_.size()) report_.drop("incomplete sweep", "its end");
      at_ = numbers_.size();
      return false;
    }
    LaserScan scan = is_b_ ? read_sweep(&numbers_[at_]) : read_points(&numbers_[at_]);
    scan.utime = now();
    queue(std::move(scan));
    at_ += size;
    ++report_.given["scans"];
    time_s_ += kUntimedScanPeriodS;
    return true;
  }

  Utime now() const { return Utime::from_seconds(time_s_); }

  void drop_repeated_end() {
    const std::size_t size = numbers_.size();
    if (size < 2 * kNumbersB || size % kNumbersB != 0) return;
    const auto last = numbers_.end() - static_cast<std::ptrdiff_t>(kNumbersB);
    if (!std::equal(last, numbers_.end(), last - static_cast<std::ptrdiff_t>(kNumbersB))) return;
    numbers_.erase(last, numbers_.end());
    report_.drop("last sweep written twice", "its end");
  }

  LaserScan read_points(const double* values) {
    LaserScan scan;
    for (std::size_t i = 0; i < kPointsA; ++i) {
      const double x = values[2 * i], y = values[2 * i + 1];
      scan.ranges_m.push_back(static_cast<float>(std::hypot(x, y)));
      scan.bearings_rad.push_back(static_cast<float>(std::atan2(y, x)));
      scan.time_offsets_s.push_back(0.0F);
    }
    const double* pose = values + 2 * kPointsA;
    queue_odometry(now(), {0.01 * pose[0], 0.01 * pose[1], normalize_angle(pose[2])});
    return scan;
  }

  LaserScan read_sweep(const double* values) {
    const double* moves = values + 2 * kBeamsB;
    pose_ = pose_ * Pose2{0.001 * moves[0], 0.0, 0.0} * Pose2{0.0, 0.0, deg_to_rad(moves[1])};
    queue_odometry(now(), pose_);
    PanTiltState state;
    state.utime = now();
    state.tilt_rad = deg_to_rad(moves[2]);
    state.pan_rad = deg_to_rad(moves[3]);
    queue(state);
    LaserScan scan;
    scan.first_bearing_rad = deg_to_rad(values[0]);
    scan.bearing_step_rad = deg_to_rad(0.5);
    for (std::size_t i = 0; i < kBeamsB; ++i) {
      scan.ranges_m.push_back(static_cast<float>(0.001 * values[2 * i + 1]));
    }
    return scan;
  }

  std::vector<double> numbers_;
  bool is_b_ = false;
  std::size_t at_ = 0;  // the next number
  double time_s_ = 0.0;
  Pose2 pose_;  // of B
};

}  // namespace

std::unique_ptr<SampleReader> open_thesis_file(const std::filesystem::path& path) {
  return std::make_unique<ThesisReader>(path);
}

bool is_thesis_file(const std::filesystem::path& path) { return read_numbers(path).has_value(); }

}  // namespace marco::files
