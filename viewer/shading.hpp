#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>

namespace marco::viewer {

/// Colours of heights from the floor up, 0..1 each; the shaders and the vector export share them.
inline constexpr std::array<std::array<double, 3>, 5> kHeightColors{{{0.60, 0.69, 0.82},
                                                                     {0.62, 0.81, 0.82},
                                                                     {0.91, 0.91, 0.80},
                                                                     {0.97, 0.84, 0.64},
                                                                     {0.90, 0.63, 0.53}}};

/// Light::room: everywhere, more for what faces up, and from a lamp over the left shoulder.
inline constexpr double kRoomAmbient = 0.66;
inline constexpr double kRoomSky = 0.09;
inline constexpr double kRoomLamp = 0.30;

/// Light::thesis (thesis B, app. C): ambient and diffuse of 30 % each on 95 % grey.
inline constexpr double kThesisAmbient = 0.30;
inline constexpr double kThesisDiffuse = 0.30;
inline constexpr double kThesisGrey = 0.95;

/// The direction of the room's lamp in the camera's frame, unit length.
inline Eigen::Vector3d lamp_in_camera() { return Eigen::Vector3d(-0.5, 0.6, 0.6).normalized(); }

/// @param part 0 = floor, 1 = top; beyond is clamped.
inline Eigen::Vector3d height_color(double part) {
  const double place = std::min(std::max(part, 0.0), 1.0) * (kHeightColors.size() - 1);
  const std::size_t stop = std::min<std::size_t>(static_cast<std::size_t>(place), 3);
  const Eigen::Map<const Eigen::Vector3d> low(kHeightColors[stop].data());
  const Eigen::Map<const Eigen::Vector3d> high(kHeightColors[stop + 1].data());
  return low + (place - static_cast<double>(stop)) * (high - low);
}

}  // namespace marco::viewer
