#pragma once

namespace marco::viewer {

/// The renderer's GLSL texts, without their `#version` line. Each .frag says which `#define` lines
/// it takes.
namespace shaders {
extern const char* const kSurfaceVertex;  ///< vertices of the world
/// COLOR_*, LIGHT_*, FAINT_BACKS, HEIGHT_COLORS, ROOM_LIGHT, THESIS_LIGHT.
extern const char* const kSurfaceFragment;
extern const char* const kScreenVertex;  ///< one triangle over the whole target
extern const char* const kOcclusion;     ///< depth -> how open each pixel's surroundings are
extern const char* const kBlur;          ///< smooths that, not across edges; COMPOSE: and darkens
}  // namespace shaders

}  // namespace marco::viewer
