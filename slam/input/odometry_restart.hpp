#pragma once

#include "common/pose_buffer.hpp"
#include "common/samples.hpp"

namespace marco::slam {

/// Whether this odometry is counted from another beginning than what the buffer holds, since the
/// base's driver or board was begun anew: no robot goes so far between two samples (1 m and 5 m/s,
/// or 1 rad and 7 rad/s, of 10 s at most), nor stands at zero to the millimetre after it was
/// elsewhere. What was counted before and after must not be compared, nor interpolated.
bool odometry_began_anew(const PoseBuffer& odometry, const OdometrySample& sample);

}  // namespace marco::slam
