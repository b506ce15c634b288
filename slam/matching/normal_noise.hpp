#pragma once

#include "common/pose2.hpp"

namespace marco::slam {

/// Standard deviation of a surface normal's direction [rad]. Of 11 points with 1.5 cm of noise it
/// is 0.03 to 0.08, by how far apart they lie (see NormalOptions). Such noise makes a bare corridor
/// look constrained along itself.
inline constexpr double kNormalSigma = 0.06;

/// A scan's normals, less what only noise says of the direction that they constrain least. Of a
/// scan that sees nothing but parallel walls, all come to stand exactly across these; of one that
/// sees a room, hardly anything changes. What is kept is a Wiener filter: its square is the part of
/// sum (n . along)^2 that kNormalSigma^2 sum (n . across)^2 does not explain. Normals off by more
/// than three standard deviations are no noise, and stay.
/// @param normals  2xN, unit length. @returns the same
Points2 without_noise(Points2 normals);

}  // namespace marco::slam
