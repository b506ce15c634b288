#include "drivers/base/surroundings.hpp"

#include <algorithm>
#include <cmath>

#include "common/pose3.hpp"
#include "lcmtypes/channels.hpp"

namespace marco::drivers {
namespace {

constexpr double kExtrapolatedS = 0.2;
constexpr double kNoEchoM = 2.0;  // so far a sonar without an echo saw nothing

}  // namespace

void Surroundings::on_odometry(const OdometrySample& sample) {
  const Pose2 step = between(odom_from_robot_, sample.odom_from_robot);
  if (step.translation_m().norm() > kJumpM) map_.clear();
  odom_from_robot_ = sample.odom_from_robot;
  odometry_.add(sample.utime, odom_from_robot_);
  map_.on_body(body_, odom_from_robot_, now_);
}

/// In the robot's frame.
SeenBeam Surroundings::beam_of(const SensorInfo& laser,
                               const Pose3& robot_from_laser,
                               double bearing_rad,
                               double range_m) const {
  using End = SeenBeam::End;
  SeenBeam beam{robot_from_laser.translation(),
                robot_from_laser.linear() *
                    Eigen::Vector3d(std::cos(bearing_rad), std::sin(bearing_rad), 0.0),
                range_m, End::nothing};
  if (range_m >= laser.range_max_m) {
    beam.end = End::far;
  } else if (!(range_m > 0.0)) {
    beam.end = End::no_answer;
  } else if (range_m > laser.range_min_m && body_.distance_m(beam.tip_m().head<2>()) >= 0.0) {
    beam.end = End::hit;
  }
  return beam;
}

/// In the odom frame.
std::vector<SeenBeam> Surroundings::beams_of(const LaserScan& scan,
                                             const SensorInfo& laser,
                                             const Pose3& robot_from_laser,
                                             const Pose2& odom_from_robot) const {
  const bool has_times = !scan.time_offsets_s.empty();
  const Duration lasts = Duration::from_seconds(
      has_times ? static_cast<double>(scan.time_offsets_s.back()) : laser.scan_duration_s);
  const Duration reach = Duration::from_seconds(kExtrapolatedS);
  const auto begin = odometry_.at(scan.utime, reach), end = odometry_.at(scan.utime + lasts, reach);
  const bool is_known = begin && end;
  std::vector<SeenBeam> beams;
  beams.reserve(scan.size());
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const double part = static_cast<double>(i) / static_cast<double>(scan.size());
    const Pose2 at = is_known ? interpolate(*begin, *end, part) : odom_from_robot;
    SeenBeam beam = beam_of(laser, robot_from_laser, scan.bearing_rad(i),
                            static_cast<double>(scan.ranges_m[i]));
    beam.from_m.head<2>() = at * Eigen::Vector2d(beam.from_m.head<2>());
    beam.along.head<2>() = at.rotation() * beam.along.head<2>();
    beams.push_back(beam);
  }
  return beams;
}

void Surroundings::on_scan(const LaserScan& scan, const Pose2& odom_from_robot, Utime now) {
  now_ = now;
  const std::string name = channels::lidar_of(scan.channel);
  if (!watch_.on_reading(name, scan.utime, now)) return;
  const SensorInfo* laser = watch_.info_of(name);
  const auto robot_from_laser =
      laser != nullptr ? watch_.robot_from(*laser, now) : std::optional<Pose3>();
  if (!robot_from_laser) return;
  const std::vector<SeenBeam> beams = beams_of(scan, *laser, *robot_from_laser, odom_from_robot);
  const Heights counted = watch_.counted(*robot_from_laser);
  const bool sees = std::any_of(beams.begin(), beams.end(), [&](const SeenBeam& beam) {
    return beam.end == SeenBeam::End::hit && counted.contain(beam.tip_m().z());
  });
  if (!sees) return;  // it may be covered
  watch_.on_useful(name, now);
  map_.on_beams(beams, counted, now);
}

void Surroundings::on_sonar(const SonarRing& ring,
                            const Pose2& odom_from_robot,
                            Utime now,
                            Sonars read) {
  now_ = now;
  if (read == Sonars::always) watch_.on_reading(SensorWatch::kSonars, ring.utime, now);
  sonar_ = {now, {}};
  for (const SonarReading& reading : ring.readings) {
    const bool has_echo = reading.range_m > 0.0;
    const Pose2 odom_from_sonar = odom_from_robot * reading.robot_from_sonar;
    // Somewhere on the cone's arc: its middle and half way to its rims.
    for (const double part : {-0.25, 0.0, 0.25}) {
      const double bearing_rad = part * ring.cone_rad;
      const Eigen::Vector2d tip = (has_echo ? reading.range_m : kNoEchoM) *
                                  Eigen::Vector2d(std::cos(bearing_rad), std::sin(bearing_rad));
      map_.on_ray(odom_from_sonar.translation_m(), odom_from_sonar * tip, now);
      if (!has_echo || body_.distance_m(reading.robot_from_sonar * tip) < 0.0) continue;
      sonar_.in_odom.push_back(odom_from_sonar * tip);
    }
  }
}

std::string Surroundings::forget() {
  map_.clear();
  sonar_ = {};
  return watch_.forget();
}

std::vector<Eigen::Vector2d> Surroundings::points_within(double reach_m) const {
  std::vector<Eigen::Vector2d> points = map_.points_about(odom_from_robot_, reach_m, now_);
  if ((now_ - sonar_.when).seconds() > LocalMap::kRememberedS) return points;
  const Pose2 robot_from_odom = odom_from_robot_.inverse();
  for (const Eigen::Vector2d& point : sonar_.in_odom) points.push_back(robot_from_odom * point);
  return points;
}

}  // namespace marco::drivers
