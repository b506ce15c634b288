#include "simulator/ray_caster.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <stdexcept>

#include "embree.hpp"  // of embree3/ or embree4/, as CMake finds it

namespace marco::sim {
namespace {

// Nearest point of a triangle (Ericson, Real-Time Collision Detection, 5.1.5).
Eigen::Vector3f nearest_point(const Eigen::Vector3f& p,
                              const Eigen::Vector3f& a,
                              const Eigen::Vector3f& b,
                              const Eigen::Vector3f& c) {
  const Eigen::Vector3f ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const float d1 = ab.dot(ap), d2 = ac.dot(ap), d3 = ab.dot(bp), d4 = ac.dot(bp);
  const float d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d1 <= 0 && d2 <= 0) return a;
  if (d3 >= 0 && d4 <= d3) return b;
  if (d6 >= 0 && d5 <= d6) return c;
  const float vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + d1 / (d1 - d3) * ab;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + d2 / (d2 - d6) * ac;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    return b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b);
  }
  const float scale = 1.0F / (va + vb + vc);
  return a + ab * (vb * scale) + ac * (vc * scale);
}

struct PointQuery {
  const World* world;
  NearestSurface best;
};

bool on_candidate(RTCPointQueryFunctionArguments* arguments) {
  auto* query = static_cast<PointQuery*>(arguments->userPtr);
  const World& world = *query->world;
  const auto& triangle = world.triangles[arguments->primID];
  const Eigen::Vector3f point(arguments->query->x, arguments->query->y, arguments->query->z);
  const Eigen::Vector3f nearest =
      nearest_point(point, world.vertices_m[triangle[0]], world.vertices_m[triangle[1]],
                    world.vertices_m[triangle[2]]);
  const float distance = (nearest - point).norm();
  if (distance >= query->best.distance_m) return false;
  query->best = {distance, nearest, arguments->primID};
  arguments->query->radius = distance;
  return true;  // the radius shrank
}

}  // namespace

struct RayCaster::Scene {
  World world;
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;

  ~Scene() {
    if (scene != nullptr) rtcReleaseScene(scene);
    if (device != nullptr) rtcReleaseDevice(device);
  }
};

RayCaster::RayCaster(const World& world) : scene_(std::make_unique<Scene>()) {
  scene_->world = world;
  // One thread: the batch simulator shares its machine with the job it feeds.
  scene_->device = rtcNewDevice("threads=1");
  if (scene_->device == nullptr) throw std::runtime_error("Embree could not be started");
  RTCGeometry geometry = rtcNewGeometry(scene_->device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                               RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                                               world.vertices_m.size()));
  for (const Eigen::Vector3f& vertex : world.vertices_m) {
    for (int axis = 0; axis < 3; ++axis) *vertices++ = vertex(axis);
  }
  auto* indices = static_cast<uint32_t*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                              3 * sizeof(uint32_t), world.triangles.size()));
  for (const auto& triangle : world.triangles)
    indices = std::copy(triangle.begin(), triangle.end(), indices);
  rtcCommitGeometry(geometry);
  scene_->scene = rtcNewScene(scene_->device);
  rtcSetSceneFlags(scene_->scene, RTC_SCENE_FLAG_ROBUST);
  rtcAttachGeometry(scene_->scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene_->scene);
}

RayCaster::~RayCaster() = default;
RayCaster::RayCaster(RayCaster&&) noexcept = default;

std::optional<RayHit> RayCaster::cast(const Eigen::Vector3f& origin_m,
                                      const Eigen::Vector3f& direction,
                                      float max_range_m) const {
  RTCRayHit ray{};
  ray.ray.org_x = origin_m.x();
  ray.ray.org_y = origin_m.y();
  ray.ray.org_z = origin_m.z();
  ray.ray.dir_x = direction.x();
  ray.ray.dir_y = direction.y();
  ray.ray.dir_z = direction.z();
  ray.ray.tnear = 1e-4F;
  ray.ray.tfar = max_range_m;
  ray.ray.mask = 0xFFFFFFFFU;
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  intersect(scene_->scene, ray);
  if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  RayHit hit;
  hit.range_m = ray.ray.tfar;
  hit.normal = Eigen::Vector3f(ray.hit.Ng_x, ray.hit.Ng_y, ray.hit.Ng_z).normalized();
  if (hit.normal.dot(direction) > 0.0F) hit.normal = -hit.normal;
  hit.material = scene_->world.materials[ray.hit.primID];
  hit.triangle = ray.hit.primID;
  return hit;
}

float RayCaster::distance_to_surface_m(const Eigen::Vector3f& point_m, float max_m) const {
  const std::optional<NearestSurface> found = nearest(point_m, max_m);
  return found ? found->distance_m : max_m;
}

std::optional<NearestSurface> RayCaster::nearest(const Eigen::Vector3f& point_m,
                                                 float max_m) const {
  RTCPointQuery query{point_m.x(), point_m.y(), point_m.z(), 0.0F, max_m};
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  PointQuery best{&scene_->world, {max_m, Eigen::Vector3f::Zero(), 0}};
  rtcPointQuery(scene_->scene, &query, &context, on_candidate, &best);
  if (best.best.distance_m >= max_m) return std::nullopt;
  return best.best;
}

const World& RayCaster::world() const { return scene_->world; }

}  // namespace marco::sim
