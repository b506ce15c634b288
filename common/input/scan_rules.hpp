#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "common/input/beam_order.hpp"
#include "common/input/odometry_track.hpp"
#include "common/input/own_body.hpp"
#include "common/input/range_units.hpp"
#include "common/input/rate_watch.hpp"
#include "common/input/sensor_calibration.hpp"
#include "common/input/stamp_repair.hpp"
#include "common/samples.hpp"

namespace marco {

/// A scan that waits for odometry and pan-tilt.
struct WaitingScan {
  LaserScan scan;
  Utime repaired;
  double period_s = 0.0;
  double off_beat = 0.0;
  std::optional<Pose2> own_odometry;  ///< see OdometryTrack
  BeamVerdict beam_order;

  OdometryTrack::AtScan at() const { return {scan.utime, repaired, period_s, own_odometry}; }

  template <class Visitor>
  void visit(Visitor& v) {
    v("scan", scan);
    v("repaired", repaired);
    v("period_s", period_s);
    v("off_beat", off_beat);
    v("own_odometry", own_odometry);
    v("beam_order", beam_order);
  }
};

/// What a rule may ask for, and where it reports.
struct RuleContext {
  const SensorInfo* info;  ///< of the scan's laser; nullptr: not announced yet
  std::string lidar;       ///< LIDAR_FRONT for LIDAR_RAW_FRONT
  const SensorCalibration& calibration;
  const std::function<void(const std::string& cause)>& report;
};

/// What a rule did so far.
struct RuleCount {
  int64_t scans = 0;    ///< not used
  int64_t returns = 0;  ///< taken out of scans that are used
};

/// Each rule has a name, its own state, and `apply`, which changes the scan or returns false: the
/// scan is not used. It reports the cause, unless the cause is an ordinary one. Rules of the third
/// kind, `blank`, return how many returns they took out of the scan.
namespace scan_rules {

struct Announced {
  static constexpr const char* kName = "announced";
  bool apply(const WaitingScan& in, const RuleContext& context) const;
};

/// A scan with the stamp and ranges of the last one comes from a log of two recorders.
struct NotRepeated {
  static constexpr const char* kName = "not repeated";
  std::map<std::string, LaserScan> last;  ///< by channel
  bool apply(const WaitingScan& in, const RuleContext& context);
};

/// Of a laser whose scans come on two channels, as LIDAR and with beam times as LIDAR_RAW, the raw
/// ones are used, and each scan once. Planar ones are used until the first raw one comes, and again
/// when none has come for a second of message time.
struct OneChannelOfTwo {
  static constexpr const char* kName = "one channel of two";
  struct Laser {
    std::optional<Utime> newest_raw;
    std::optional<Utime> newest_planar;  ///< that was used
  };
  std::map<std::string, Laser> lasers;
  bool apply(const WaitingScan& in, const RuleContext& context);
};

struct OneSender {
  static constexpr const char* kName = "one sender";
  RateWatch rates;
  bool apply(const WaitingScan& in, const RuleContext& context);
};

struct RangesInMetres {
  static constexpr const char* kName = "ranges in metres";
  RangeUnits units;
  std::string fault = {};  ///< of the last scan that was not used
  bool apply(const WaitingScan& in, const RuleContext& context);
};

struct BeamsCalibrated {
  static constexpr const char* kName = "beams calibrated";
  bool apply(WaitingScan& in, const RuleContext& context) const;
};

/// Of a calibration: parts of the robot in view.
struct WithoutKnownBody {
  static constexpr const char* kName = "without known body";
  std::size_t blank(LaserScan& scan, const RuleContext& context) const;
};

struct WithoutFloor {
  static constexpr const char* kName = "without floor";
  std::size_t blank(LaserScan& scan, const RuleContext& context) const;
};

/// Only of a laser on the robot: one on a pan-tilt sees the robot elsewhere in every scan.
struct WithoutOwnBody {
  static constexpr const char* kName = "without own body";
  std::map<std::string, OwnBody> bodies;  ///< by channel
  std::size_t blank(LaserScan& scan, const RuleContext& context);
};

struct StampRepaired {
  static constexpr const char* kName = "stamp repaired";
  std::map<std::string, StampRepair> lasers;  ///< by channel
  bool apply(WaitingScan& in, const RuleContext& context);
};

struct BeamTimesRepaired {
  static constexpr const char* kName = "beam times repaired";
  std::set<std::string> reported;  ///< channels
  bool apply(WaitingScan& in, const RuleContext& context);
};

/// Not of a laser that says how long its scan takes: the times of its beams are known.
struct BeamsOrdered {
  static constexpr const char* kName = "beams ordered";
  std::map<std::string, BeamOrderJudge> judges;  ///< by channel
  bool apply(WaitingScan& in, const RuleContext& context);
};

}  // namespace scan_rules

/// Conditions each scan that comes in. A rule relies on those above it.
class ScanRules {
 public:
  /// @returns whether the scan is used.
  bool apply(WaitingScan& in, const RuleContext& context);

  template <class Rule>
  Rule& get() {
    return std::get<Counted<Rule>>(rules_).rule;
  }
  template <class Rule>
  const Rule& get() const {
    return std::get<Counted<Rule>>(rules_).rule;
  }
  /// In the order of the rules.
  std::vector<std::pair<std::string, RuleCount>> counts() const;

 private:
  template <class Rule>
  struct Counted {
    Rule rule;
    RuleCount count;
    bool apply(WaitingScan& in, const RuleContext& context);
  };
  template <class... Rules>
  using List = std::tuple<Counted<Rules>...>;

  List<scan_rules::Announced,
       scan_rules::NotRepeated,
       scan_rules::OneChannelOfTwo,
       scan_rules::OneSender,
       scan_rules::RangesInMetres,
       scan_rules::BeamsCalibrated,
       scan_rules::WithoutKnownBody,
       scan_rules::WithoutFloor,
       scan_rules::WithoutOwnBody,
       scan_rules::StampRepaired,
       scan_rules::BeamTimesRepaired,
       scan_rules::BeamsOrdered>
      rules_;
};

}  // namespace marco
