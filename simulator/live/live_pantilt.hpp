#pragma once

#include "drivers/hcs12/pantilt_emulator.hpp"
#include "simulator/live/faults.hpp"
#include "simulator/live/motion_history.hpp"
#include "simulator/live/robot_spec.hpp"

namespace marco::sim {

/// Where the robot's pan-tilt really points, with the faults `wrong` and `stuck`.
class LivePanTilt {
 public:
  /// @param board, faults  outlive it.
  LivePanTilt(const LivePanTiltSpec& spec,
              const drivers::hcs12::PanTiltEmulator& board,
              const FaultBoard& faults)
      : spec_(spec), board_(board), faults_(faults) {}

  static drivers::hcs12::PanTiltEmulatorOptions board_options(const LivePanTiltSpec& spec);
  /// Sets the angles of a moment.
  void look(MotionHistory::Moment& moment);

 private:
  LivePanTiltSpec spec_;
  const drivers::hcs12::PanTiltEmulator& board_;
  const FaultBoard& faults_;
  double last_pan_rad_ = 0.0;
  double last_tilt_rad_ = 0.0;
};

}  // namespace marco::sim
