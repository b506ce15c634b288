#include "viewer/shaders.hpp"

namespace marco::viewer::shaders {

const char* const kSurfaceVertex = R"(
layout(location = 0) in vec3 position_m;
layout(location = 1) in vec4 normal;
layout(location = 2) in vec4 color;
uniform mat4 clip_from_world;
uniform float cut_height_m;
uniform float point_size_px;
uniform vec3 eye_m;
uniform vec3 view_direction;
uniform float perspective;
uniform vec3 lamp_direction;
uniform float low_m;
uniform float high_m;
out vec3 surface_normal;
out vec3 own_color;
out float facing;
out float lamp;
#if defined(COLOR_HEIGHT)
out float stop;
#endif
#if defined(LIGHT_THESIS)
out vec3 world_m;
out vec3 towards_eye;
#endif
void main() {
  vec3 to_eye = mix(-view_direction, eye_m - position_m, perspective);
#if defined(COLOR_HEIGHT)
  stop = 4.0 * (position_m.z - low_m) / max(high_m - low_m, 1e-3);
#endif
#if defined(LIGHT_THESIS)
  world_m = position_m;
  towards_eye = to_eye;
#endif
  surface_normal = normal.xyz;
  own_color = color.rgb;
  facing = dot(normal.xyz, to_eye);
  lamp = dot(normal.xyz, lamp_direction);
  gl_Position = clip_from_world * vec4(position_m, 1.0);
  gl_PointSize = point_size_px;
  gl_ClipDistance[0] = cut_height_m - position_m.z;
}
)";

// LIGHT_THESIS is thesis B, app. C: one lamp at the sensor's height at the origin, both sides lit.
// LIGHT_ROOM makes faces of different direction differ. HEIGHT_COLORS, ROOM_LIGHT and THESIS_LIGHT
// come from shading.hpp.
// What is done for each pixel is half of a frame's cost: one root, and no division, where the look
// allows it; few inputs; and constants, for a software driver checks each use of a uniform.
const char* const kSurfaceFragment = R"(
in vec3 surface_normal;
in vec3 own_color;
in float facing;
in float lamp;
#if defined(COLOR_HEIGHT)
in float stop;
#endif
#if defined(LIGHT_THESIS)
in vec3 world_m;
in vec3 towards_eye;
uniform vec3 lamp_m;
#endif
out vec4 shown;

// Piecewise linear: to add up what the slope changes by at all stops costs less than to look the
// stop up.
vec3 height_color(float stop) {
  const vec3 colors[5] = HEIGHT_COLORS;
  float at = clamp(stop, 0.0, 4.0);
  vec3 slope = colors[1] - colors[0];
  vec3 color = colors[0] + at * slope;
  for (int i = 1; i < 4; ++i) {
    vec3 next = colors[i + 1] - colors[i];
    color += max(at - float(i), 0.0) * (next - slope);
    slope = next;
  }
  return color;
}

void main() {
#if defined(FAINT_BACKS)
  // One sample of four: a quarter of the colour once samples are averaged. The even samples, which
  // the shadows look at, see what lies behind.
  if (!gl_FrontFacing && (int(gl_FragCoord.x) & int(gl_FragCoord.y) & 1) == 0) discard;
#endif
  float square = dot(surface_normal, surface_normal);
  bool loose = square == 0.0;  // points and lines have no normal
  float per_length = inversesqrt(max(square, 1e-12));
  float scale = facing < 0.0 ? -per_length : per_length;
  vec3 n = surface_normal * scale;
#if defined(COLOR_HEIGHT)
  vec3 base = height_color(stop);
#elif defined(COLOR_NORMAL)
  vec3 base = 0.62 + 0.34 * n;
#elif defined(COLOR_GREY)
  vec3 base = vec3(THESIS_LIGHT.z);
#else
  vec3 base = own_color;
#endif
#if defined(LIGHT_THESIS)
  if (loose) n = normalize(towards_eye);
  float light = THESIS_LIGHT.x + THESIS_LIGHT.y * max(dot(n, normalize(lamp_m - world_m)), 0.0);
#elif defined(LIGHT_ROOM)
  float light = ROOM_LIGHT.x + ROOM_LIGHT.y * n.z + ROOM_LIGHT.z * max(lamp * scale, 0.0);
  if (loose) light = 1.0;
#else
  float light = 1.0;
#endif
  shown = vec4(base * light, 1.0);
}
)";

const char* const kScreenVertex = R"(
void main() {
  vec2 corner = vec2(float((gl_VertexID << 1) & 2), float(gl_VertexID & 2));
  gl_Position = vec4(corner * 2.0 - 1.0, 0.0, 1.0);
}
)";

// McGuire, Mara, Luebke: Scalable Ambient Obscurance (HPG 2012), eq. 9 and 10; the normal comes
// from the nearer neighbour on each axis, so that it is right next to edges, too.
const char* const kOcclusion = R"(
uniform sampler2D depth;
uniform mat4 camera_from_clip;
uniform vec2 size_px;
uniform float radius_m;
uniform float px_per_m_at_1m;
uniform float perspective;
uniform float stride;
out vec4 openness;
const int kSamples = 14;

vec3 position_at(ivec2 px) {
  px = clamp(px, ivec2(0), ivec2(size_px) - 1);
  float d = texelFetch(depth, px, 0).r;
  vec4 p = camera_from_clip * vec4((vec2(px) + 0.5) / size_px * 2.0 - 1.0, d * 2.0 - 1.0, 1.0);
  return p.xyz / p.w;
}

vec3 smaller(vec3 a, vec3 b) { return abs(a.z) < abs(b.z) ? a : b; }

void main() {
  ivec2 px = ivec2(gl_FragCoord.xy) * int(stride);
  if (texelFetch(depth, px, 0).r >= 1.0) { openness = vec4(1.0); return; }
  vec3 here = position_at(px);
  vec3 across = smaller(position_at(px + ivec2(1, 0)) - here, here - position_at(px - ivec2(1, 0)));
  vec3 upward = smaller(position_at(px + ivec2(0, 1)) - here, here - position_at(px - ivec2(0, 1)));
  vec3 n = normalize(cross(across, upward));
  float reach_px = radius_m * px_per_m_at_1m / mix(1.0, max(-here.z, 0.01), perspective);
  reach_px = clamp(reach_px, 3.0, 0.25 * size_px.y);
  float turn = 6.2831853 * fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
  float r2 = radius_m * radius_m;
  float bias = 0.05 * radius_m + 0.002 * abs(here.z);
  float sum = 0.0;
  for (int i = 0; i < kSamples; ++i) {
    float part = (float(i) + 0.5) / float(kSamples);
    float angle = part * 5.0 * 6.2831853 + turn;
    vec3 v = position_at(px + ivec2(part * reach_px * vec2(cos(angle), sin(angle)))) - here;
    float vv = dot(v, v);
    float near = max(r2 - vv, 0.0);
    sum += near * near * near * max((dot(v, n) - bias) / (vv + 0.02 * r2), 0.0);
  }
  float open = 1.0 - 2.2 * radius_m * sum / (r2 * r2 * r2 * float(kSamples));
  openness = vec4(clamp(open, 0.3, 1.0));
}
)";

// The openness map holds every stride-th pixel of the depth. Its samples count by how near they lie
// to this pixel in depth, so that nothing bleeds over an edge.
const char* const kBlur = R"(
uniform sampler2D openness_map;
uniform sampler2D depth;
uniform sampler2D colors;
uniform vec2 direction;
uniform vec2 size_px;
uniform float stride;
uniform mat4 camera_from_clip;
out vec4 shown;

float distance_at(ivec2 px) {
  vec4 p = camera_from_clip * vec4(0.0, 0.0, texelFetch(depth, px, 0).r * 2.0 - 1.0, 1.0);
  return -p.z / p.w;
}

void main() {
#if defined(COMPOSE)
  ivec2 px = ivec2(gl_FragCoord.xy);
#else
  ivec2 px = ivec2(gl_FragCoord.xy) * int(stride);
#endif
  ivec2 sample_px = px / int(stride);
  ivec2 last = ivec2(size_px) / int(stride) - 1;
  float here = distance_at(px);
  float sum = 0.0, weights = 0.0;
  for (int i = -4; i <= 4; ++i) {
    ivec2 at = clamp(sample_px + ivec2(direction) * i, ivec2(0), last);
    float gap = abs(distance_at(at * int(stride)) - here) / max(abs(here), 0.001);
    float weight = exp(-0.08 * float(i * i)) * max(0.001, 1.0 - 25.0 * gap);
    sum += weight * texelFetch(openness_map, at, 0).r;
    weights += weight;
  }
  float open = sum / weights;
#if defined(COMPOSE)
  if (texelFetch(depth, px, 0).r >= 1.0) open = 1.0;
  shown = vec4(texelFetch(colors, px, 0).rgb * open, 1.0);
#else
  shown = vec4(open);
#endif
}
)";

}  // namespace marco::viewer::shaders
