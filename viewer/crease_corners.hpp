#pragma once

#include "viewer/scene_geometry.hpp"

namespace marco::viewer {

/// A vertex at a crease has a normal between those of its faces. On triangles of some centimetres
/// that is a soft edge; one of a metre is shaded wrong all over. Such a corner gets a vertex of its
/// own, with the normal of the faces around it that lie the same way; the vertices that were there
/// stay.
/// @param surfaces  triangles; their places do not change
void split_creases(Geometry& surfaces);

}  // namespace marco::viewer
