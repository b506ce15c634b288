#include "tools/log/export_carmen.hpp"

#include <charconv>
#include <cmath>
#include <deque>
#include <map>

#include "common/pose_buffer.hpp"
#include "common/regular_scan.hpp"
#include "lcm_tools/base/format.hpp"

namespace marco::logs {
namespace {

constexpr const char* kHost = "marco";

void append(std::string& line, float value) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, value).ptr;
  line += ' ';
  line.append(text, end);
}

void append(std::string& line, double value) {
  char text[40];
  const auto end = std::to_chars(text, text + sizeof text, value).ptr;
  line += ' ';
  line.append(text, end);
}

void append(std::string& line, const Pose2& pose) {
  append(line, pose.x_m);
  append(line, pose.y_m);
  append(line, pose.theta_rad);
}

void append_time(std::string& line, Utime time, double logger_s) {
  line += format(" %.6f %s %.6f\n", time.seconds(), kHost, logger_s);
}

// How CARMEN's old laser lines spread their beams (recordings/text_formats.hpp).
bool lies_as_old_lines_imply(const LaserScan& scan) {
  const std::size_t count = scan.size();
  if (count < 2 || count == 401) return false;
  const std::size_t intervals = count % 2 == 0 ? count : count - 1;
  const double step_rad = deg_to_rad(180.0) / static_cast<double>(intervals);
  constexpr double kFloatRad = 1e-6;  // rad0 and radstep travel as floats
  return std::abs(scan.first_bearing_rad - deg_to_rad(-90.0)) < kFloatRad &&
         std::abs(scan.bearing_step_rad - step_rad) < kFloatRad;
}

bool is_at(const Pose3& robot_from_sensor, double yaw_rad) {
  return robot_from_sensor.isApprox(lift({0.0, 0.0, yaw_rad}), 1e-6);
}

class CarmenWriter {
 public:
  CarmenWriter(OutputFile& out, OutputFile* truth) : out_(out), truth_(truth) {}

  void add(const Sample& sample) {
    if (const auto* info = std::get_if<SensorInfo>(&sample)) {
      infos_[info->channel] = *info;
    } else if (const auto* odometry = std::get_if<OdometrySample>(&sample)) {
      write_odometry(*odometry);
    } else if (const auto* scan = std::get_if<LaserScan>(&sample)) {
      waiting_.push_back(*scan);
    } else if (const auto* pose = std::get_if<TruePose>(&sample)) {
      write_truth(*pose);
    }
    // A scan waits for the odometry behind it, but not for ever.
    constexpr std::size_t kPatience = 50;
    while (!waiting_.empty() && (waiting_.size() > kPatience || is_due(waiting_.front()))) {
      write_scan();
    }
  }
  CarmenResult finish() {
    while (!waiting_.empty()) write_scan();
    return result_;
  }

 private:
  bool is_due(const LaserScan& scan) const {
    return !odometry_.empty() && scan.utime <= odometry_.newest();
  }
  void write_odometry(const OdometrySample& sample) {
    odometry_.add(sample.utime, sample.odom_from_robot);
    start(sample.utime);
    line_ = "ODOM";
    append(line_, sample.odom_from_robot);
    append(line_, sample.velocity_m_per_s);
    append(line_, sample.yaw_rate_rad_per_s);
    append(line_, 0.0);
    finish_line(sample.utime);
    ++result_.odometry;
  }
  void write_truth(const TruePose& pose) {
    ++result_.true_poses;
    if (truth_ == nullptr) return;
    const Pose2& p = pose.world_from_robot;
    truth_->write(format("%.6f %.9g %.9g 0 0 0 %.9g %.9g\n", pose.utime.seconds(), p.x_m, p.y_m,
                         std::sin(0.5 * p.theta_rad), std::cos(0.5 * p.theta_rad)));
  }
  void write_scan();
  void write_old_line(const LaserScan& scan, const Pose2& robot, bool second);
  void write_new_line(const LaserScan& scan,
                      const Pose2& robot,
                      const SensorInfo& info,
                      bool second);
  Pose2 robot_at(Utime utime) {
    constexpr Duration kReach = Duration::from_us(200000);
    if (const auto pose = odometry_.at(utime, kReach)) return *pose;
    ++result_.without_odometry;
    return odometry_.empty() ? Pose2{} : odometry_.newest_pose();
  }
  void start(Utime utime) {
    if (first_) return;
    first_ = utime;
    out_.write("# written by marco-log\n");
  }
  void finish_line(Utime utime) {
    append_time(line_, utime, (utime - *first_).seconds());
    out_.write(std::string_view(line_));
  }

  OutputFile& out_;
  OutputFile* truth_;
  std::map<std::string, SensorInfo> infos_;
  std::map<std::string, bool> lasers_;  // channel -> whether it is the second
  PoseBuffer odometry_;
  std::deque<LaserScan> waiting_;
  std::optional<Utime> first_;
  std::string line_;
  CarmenResult result_;
};

void CarmenWriter::write_scan() {
  LaserScan scan = std::move(waiting_.front());
  waiting_.pop_front();
  if (!lasers_.contains(scan.channel)) {
    // LIDAR_REAR is the second even if it arrives first.
    const bool rear = scan.channel.find("REAR") != std::string::npos;
    const bool taken[2] = {
        std::any_of(lasers_.begin(), lasers_.end(), [](auto& laser) { return !laser.second; }),
        std::any_of(lasers_.begin(), lasers_.end(), [](auto& laser) { return laser.second; })};
    if (taken[0] && taken[1]) {
      ++result_.of_more_lasers;
      return;
    }
    lasers_[scan.channel] = taken[rear ? 1 : 0] ? !rear : rear;
  }
  const bool second = lasers_[scan.channel];
  const SensorInfo info = infos_[scan.channel];
  if (!scan.bearings_rad.empty()) {
    scan = make_regular(scan, static_cast<float>(info.range_max_m));
    ++result_.resampled;
  }
  start(scan.utime);
  const Pose2 robot = robot_at(scan.utime);
  const bool old_line = lies_as_old_lines_imply(scan) &&
                        is_at(info.parent_from_sensor, second ? deg_to_rad(180.0) : 0.0);
  if (old_line) {
    write_old_line(scan, robot, second);
  } else {
    write_new_line(scan, robot, info, second);
  }
  ++result_.scans;
}

void CarmenWriter::write_old_line(const LaserScan& scan, const Pose2& robot, bool second) {
  line_ = second ? "RLASER " : "FLASER ";
  line_ += std::to_string(scan.size());
  for (const float range_m : scan.ranges_m) append(line_, range_m);
  append(line_, second ? robot * Pose2{0.0, 0.0, deg_to_rad(180.0)} : robot);
  append(line_, robot);
  finish_line(scan.utime);
}

void CarmenWriter::write_new_line(const LaserScan& scan,
                                  const Pose2& robot,
                                  const SensorInfo& info,
                                  bool second) {
  line_ = second ? "ROBOTLASER2 0" : "ROBOTLASER1 0";
  append(line_, scan.first_bearing_rad);
  append(line_, scan.bearing_step_rad * static_cast<double>(scan.size() - 1));
  append(line_, scan.bearing_step_rad);
  append(line_, info.range_max_m);
  append(line_, info.range_sigma_m);
  line_ += " 0 " + std::to_string(scan.size());
  for (const float range_m : scan.ranges_m) append(line_, range_m);
  line_ += " 0";
  const Eigen::Vector3d ahead = info.parent_from_sensor.linear().col(0);
  const Pose2 robot_from_laser{info.parent_from_sensor.translation().x(),
                               info.parent_from_sensor.translation().y(),
                               std::atan2(ahead.y(), ahead.x())};
  append(line_, robot * robot_from_laser);
  append(line_, robot);
  line_ += " 0 0 0 0 0";
  finish_line(scan.utime);
}

}  // namespace

CarmenResult export_carmen(files::SampleReader& recording,
                           OutputFile& out,
                           OutputFile* truth,
                           const OnProgress& on_progress) {
  CarmenWriter writer(out, truth);
  constexpr int64_t kSamplesBetweenProgress = 256;
  for (int64_t samples = 1; const auto sample = recording.next(); ++samples) {
    writer.add(*sample);
    if (samples % kSamplesBetweenProgress == 0) on_progress(recording.progress());
  }
  return writer.finish();
}

}  // namespace marco::logs
