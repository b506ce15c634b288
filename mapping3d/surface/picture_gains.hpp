#pragma once

#include <vector>

#include "mapping3d/surface/surface_looks.hpp"

namespace marco::mapping3d {

/// Exposure and white balance of pictures, compensated: a gain for each picture and channel, by
/// which its values are multiplied. Least squares of the logarithms over pairs of pictures that see
/// the same points, with a prior towards 1, as in Brown and Lowe, Automatic Panoramic Image
/// Stitching, IJCV 2007, equation (29), section 6. What differs: logarithms, so that a common
/// factor changes nothing and each channel is separate; a pair is described by the median of its
/// ratios, so that moving things do not count; pairs that contradict the others weigh less (Huber).
/// Only ratios are observable: the mean logarithm of pictures that are connected stays 0, and a
/// picture that shares nothing keeps gain 1. Values below 16 and above 245 are not used. Not in the
/// model: vignetting (borders fade out, see TextureView), and tone curves that are not a power (a
/// gain of the light is a gain of the values of any gamma, of another size).
/// @returns one a view; 1/4 to 4
std::vector<Eigen::Vector3f> picture_gains(const SurfaceLooks& seen, std::size_t views);

}  // namespace marco::mapping3d
