#pragma once

#include <deque>

#include "lcm_tools/base/utime.hpp"

namespace marco::drivers {

/// Turns a device's own clock into this host's. A reading arrives late by a time that is never
/// below the line's and jitters above it, so the arrivals, over device time, lie above a straight
/// line, which is sought: the edge of their lower convex hull below the middle of the last window
/// (Zhang, Liu and Xia, "Clock synchronization algorithms for network measurements", INFOCOM 2002).
/// Its slope is the drift, its distance below an arrival that arrival's delay.
class ClockFilter {
 public:
  /// @param max_drift  by how much the device's seconds may differ from ours, e.g. 0.01
  explicit ClockFilter(double max_drift = 0.01, std::size_t window = 400)
      : max_drift_(max_drift), window_(window) {}

  /// @param device_s  device time, growing; any origin.
  /// @param arrival   on this host, known delays (line time) already taken off.
  /// @returns when, on this host, the device's clock showed device_s; never after `arrival`.
  Utime update(double device_s, Utime arrival);

  /// Device seconds per host second, less one; 0 until enough has come to tell.
  double drift() const { return slope_ > 0.0 ? 1.0 / slope_ - 1.0 : 0.0; }
  /// Standard deviation and maximum of the delays removed, over the window.
  double jitter_s() const;
  double max_delay_s() const;

  /// The device's clock started anew.
  void reset();

 private:
  struct Reading {
    double device_s;
    double arrival_s;  ///< after origin_
    double delay_s = 0.0;
  };
  void fit();

  double max_drift_;
  std::size_t window_;
  std::deque<Reading> readings_;
  Utime origin_;
  double slope_ = 1.0;     ///< host seconds per device second
  double anchor_s_ = 0.0;  ///< a point of the line, after origin_
  double anchor_device_s_ = 0.0;
};

/// Counts the turns of a mirror that says nothing but that a turn is over: the device clock of a
/// laser whose telegrams carry no time.
class TurnCounter {
 public:
  explicit TurnCounter(double turn_s) : turn_s_(turn_s) {}

  /// What may lie between a scan and the one before it.
  enum class Gap {
    any,   ///< scans were lost: only the time between arrivals tells how many turns
    none,  ///< the laser sends every turn, or every n-th where its line is slow (n is learnt): a
           ///< late scan is late, until those behind it come no sooner
  };

  /// @param end  of a scan by its arrival. @returns turns since the first, as whole turns of
  /// nominal length: a device time for ClockFilter [s]. Where a turn was missed after all, the
  /// scans until the next that comes in time are counted too low.
  double update(Utime end, Gap gap = Gap::any);
  void reset();

 private:
  int64_t turns_since(double elapsed, Gap gap);
  void learn(int64_t turns);

  double turn_s_;
  int64_t turns_ = -1;
  int64_t usual_ = 0;          ///< turns from scan to scan; 0 = not known yet
  std::deque<int64_t> steps_;  ///< of the last scans that came in time
  double behind_ = 0.0;        ///< turns by which the last scan came late, or that were missed
  Utime last_;
};

}  // namespace marco::drivers
