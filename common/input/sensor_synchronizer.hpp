#pragma once

#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/input/odometry_units.hpp"
#include "common/input/scan_rules.hpp"
#include "common/input/synchronized_scan.hpp"
#include "lcm_tools/base/options.hpp"

namespace marco {

struct SynchronizerOptions {
  double patience_s = 0.5;  ///< how long a scan waits for odometry and pan-tilt, in message time
  double level_tilt_limit_deg = 1.0;   ///< of a pan-tilt: a scan tilted more is not level
  double pan_in_scan_limit_deg = 0.1;  ///< nor is one during which the laser panned more
  double pantilt_gap_s = 1.0;          ///< longest gap between angles that is interpolated
  double pantilt_reach_s = 0.1;        ///< how far angles are extrapolated beyond the newest
  double pantilt_late_s = 0.0;         ///< PanTiltCorrection::late_s, no setting of its own
  SensorCalibration calibration;       ///< from `--calibration FILE`, no setting of its own

  template <class Visitor>
  void visit(Visitor& v) {
    v.advanced("patience_s", patience_s, Limits{0.0, 10.0},
               "How long a scan waits for its odometry and pan-tilt angle, in message time. More "
               "if they arrive late; poses are delayed as much.");
    v.advanced("level_tilt_limit_deg", level_tilt_limit_deg, Limits{0.0, 90.0},
               "Scans tilted more do not enter the 2D map. More for a pan-tilt that cannot hold "
               "its zero.");
    v.advanced("pantilt_gap_s", pantilt_gap_s, Limits{0.0, 60.0},
               "Longest gap between two pan-tilt angles that is interpolated. More for a pan-tilt "
               "that reports less often.");
  }
};

/// What a SensorSynchronizer knows: resumed from it, it continues as if it had never stopped.
struct SynchronizerState {
  std::map<std::string, SensorInfo> sensors;  ///< by channel
  OdometryCorrector odometry_corrector;
  OdometryTrack odometry;   ///< corrected
  PoseBuffer gyro_heading;  ///< integrated yaw rate as a pose's heading
  PanTiltTrack pantilt;
  ScanRules rules;  ///< a checkpoint keeps what they learnt of stamps, beam orders and bodies
  std::deque<WaitingScan> waiting;
  Utime newest;                     ///< the last scan's repaired stamp
  bool odometry_restarted = false;  ///< and no scan has come since
  bool pantilt_is_silent = false;   ///< a scan timed out waiting for it

  template <class Visitor>
  void visit(Visitor& v) {
    v("sensors", sensors);
    v("odometry_corrector", odometry_corrector);
    v("odometry", odometry);
    v("gyro_heading", gyro_heading);
    v("pantilt", pantilt);
    v("stamps", rules.get<scan_rules::StampRepaired>().lasers);
    v("beam_orders", rules.get<scan_rules::BeamsOrdered>().judges);
    v("own_bodies", rules.get<scan_rules::WithoutOwnBody>().bodies);
    v("waiting", waiting);
    v("newest", newest);
    v("odometry_restarted", odometry_restarted);
    v("pantilt_is_silent", pantilt_is_silent);
  }
};

/// Names of channels, so that this room needs no message types.
struct ChannelNames {
  std::string pantilt;  ///< whose SENSOR_INFO is that of the pan-tilt itself
  std::string (*lidar_of)(std::string_view channel);
};

/// Brings a robot's sensors together: samples in, in any order; scans out, in order of arrival,
/// each with odometry, gyro and pan-tilt at its time. A scan waits until these are known, if they
/// come at all, for `patience_s` at most. Scans are conditioned once, here (ScanRules).
///
/// Depends on the samples' order and stamps alone, never on a clock. Memory is bounded: 64
/// channels, 200 waiting scans, some thousand samples of each other sensor. Not thread-safe.
class SensorSynchronizer {
 public:
  /// Told of each scan or sample that is not used, with the cause, and once of what is wrong with a
  /// laser's channel: a second sender, beam times that were repaired. May be empty.
  using CountDrop = std::function<void(const std::string& cause)>;

  SensorSynchronizer(const SynchronizerOptions& options, ChannelNames names, CountDrop drop);

  /// @throws std::invalid_argument when more than 64 channels are announced.
  void add(const SensorInfo& info);
  void add(const OdometrySample& raw);
  void add(const ImuSample& raw);
  void add(PanTiltState state);
  void add(LaserScan scan);

  /// The oldest complete scan that was not taken yet.
  std::optional<SynchronizedScan> next();
  /// What a scan has shown of the order of its laser's beams, see BeamOrderJudge.
  /// @returns the order from now on, when this changes it.
  std::optional<BeamOrder> note_misfits(const SynchronizedScan& scan,
                                        const std::vector<double>& misfits_m2);
  /// No more samples will come: what still waits is completed by what is known.
  void complete_all();
  /// What follows was recorded at another time, and perhaps with other sensors.
  void start_session();

  /// The SENSOR_INFO that holds for a channel: its own, or its laser's. nullptr: none yet.
  const SensorInfo* sensor_of(const std::string& channel) const;
  const SensorInfo* pantilt_base() const { return sensor_of(names_.pantilt); }
  const std::map<std::string, SensorInfo>& sensors() const { return state_.sensors; }
  const ScanRules& rules() const { return state_.rules; }
  /// Why odometry is not used: its unit (OdometryUnits).
  const std::optional<std::string>& odometry_fault() const { return odometry_units_.verdict(); }
  /// For a person: what is wrong with a sensor now, "" = nothing.
  std::string notice() const { return rules().get<scan_rules::OneSender>().rates.notice(); }
  /// All but scans that are complete and were not taken.
  const SynchronizerState& state() const { return state_; }
  void restore(SynchronizerState state);

 private:
  void advance();
  bool is_complete(const WaitingScan& scan) const;
  void complete_first();
  SynchronizedScan synchronized(WaitingScan waiting);
  bool has_level_laser() const;
  void look_up_pantilt(SynchronizedScan& scan) const;

  SynchronizerOptions options_;
  ChannelNames names_;
  CountDrop drop_;
  SynchronizerState state_;
  OdometryUnits odometry_units_;
  std::deque<SynchronizedScan> complete_;
};

/// The heading at `sample`, by its yaw rate since `last`. @returns nothing across a gap, or when
/// the stamp steps back: the rate is not known there.
std::optional<double> integrated_heading_rad(const StampedPose2& last, const ImuSample& sample);

/// Time from the first beam to the last, by the scan's own beam times or by `info`.
double duration_of(const LaserScan& scan, const SensorInfo& info);

}  // namespace marco
