#include "core/mapper.hpp"

#include <utility>

namespace marco {
namespace {

std::string channel_itself(std::string_view channel) { return std::string(channel); }

}  // namespace

Mapper::Mapper() : Mapper(Options()) {}

Mapper::Mapper(const Options& options)
    : options_(options.slam),
      input_(options.input,
             ChannelNames{kPanTilt, channel_itself},
             [this](const std::string& cause) { ++ignored_[cause]; }),
      slam_(options.slam) {}

void Mapper::add(const SensorInfo& laser) { input_.add(laser); }

void Mapper::add(const OdometrySample& odometry) {
  input_.add(odometry);
  map_complete_scans();
}

void Mapper::add(const ImuSample& imu) {
  input_.add(imu);
  map_complete_scans();
}

void Mapper::add(const PanTiltState& head) {
  input_.add(head);
  map_complete_scans();
}

void Mapper::add(LaserScan scan) {
  input_.add(std::move(scan));
  map_complete_scans();
}

std::optional<PoseEstimate> Mapper::next_pose() {
  if (poses_.empty()) return std::nullopt;
  const PoseEstimate pose = poses_.front();
  poses_.pop_front();
  return pose;
}

void Mapper::finish() {
  input_.complete_all();
  map_complete_scans();
  slam_.finish();
}

void Mapper::map_complete_scans() {
  while (const std::optional<SynchronizedScan> scan = input_.next()) map_scan(*scan);
}

void Mapper::map_scan(const SynchronizedScan& scan) {
  const slam::SlamInput input =
      slam::slam_input(scan, slam_.velocity_during(scan.odometry_step, scan.duration_s));
  const slam::SlamUpdate update = slam_.process(input);
  input_.note_misfits(scan, update.misfits_m2);
  counted_.count(input.scan.beams - input.scan.no_return, input.level,
                 update.status == slam::SlamUpdate::Status::matched, options_.gates.min_points);
  if (scan.motion.odom_from_robot) {
    odometry_.push_back({scan.scan.utime, *scan.motion.odom_from_robot});
  }
  poses_.push_back(
      {scan.scan.utime, update.world_from_robot, update.covariance, update.status, update.overlap});
}

slam::Diagnosis Mapper::verdict() const {
  slam::MapEvidence evidence = counted_;
  evidence.keys = slam_.keys();
  evidence.edges = slam_.edges();
  evidence.loops = slam_.loops();
  evidence.paths = {{path(), odometry_}};
  return slam::examine(evidence);
}

}  // namespace marco
