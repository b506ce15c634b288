#pragma once

#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "common/pose2.hpp"

/// What differs between the robots that speak P2OS, ARCOS and SH2: units and sonars. Factors and
/// places are those of ARIA's parameter files. Pioneer 1, Seekur, wheelchair and Pioneer LX are not
/// here: they know no MOVE, and turn in other units.
namespace marco::drivers::p2os {

struct Model {
  double mm_per_distance = 1.0;      ///< DistConvFactor
  double mm_per_range = 1.0;         ///< RangeConvFactor, of a sonar
  double rad_per_mm_per_s = 0.0056;  ///< DiffConvFactor: yaw rate from half the wheels' difference
  double mm_per_s_per_velocity = 1.0;                  ///< VelConvFactor, of what it reports
  std::vector<std::optional<Pose2>> robot_from_sonar;  ///< by number; nothing: not fitted
};
/// Of the subtype that a robot names, in any case, whatever laser it names behind
/// ("p3dx-sh-lms1xx").
/// @returns nothing for an unknown one.
std::optional<Model> model_of(const std::string& subtype);

inline constexpr double kRadPerHeading = 2.0 * std::numbers::pi / 4096.0;

}  // namespace marco::drivers::p2os
