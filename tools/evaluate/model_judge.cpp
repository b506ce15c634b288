#include "tools/evaluate/model_judge.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <unordered_set>

#include "common/mesh_samples.hpp"

namespace marco {
namespace {

constexpr float kFarthestM = 1.0F;
constexpr float kSampleM2 = 4e-4F;
constexpr float kTooFarApartM = 0.02F;

sim::RayCaster as_world(const TriangleMesh& mesh) {
  sim::World world;
  world.vertices_m = mesh.vertices_m;
  world.triangles = mesh.triangles;
  world.materials.resize(mesh.triangles.size(), sim::Material::plain);
  return sim::RayCaster(world);
}

// One beam end a 2 cm cell: what is near the robot would else count a thousandfold.
std::vector<BeamEnd> one_a_cell(const std::vector<BeamEnd>& beams) {
  std::unordered_set<uint64_t> cells;
  std::vector<BeamEnd> places;
  for (const BeamEnd& beam : beams) {
    const Eigen::Vector3i cell = (beam.point_m / 0.02F).array().floor().matrix().cast<int>();
    const auto part = [&](int axis) {
      return uint64_t{(1U << 20U) + static_cast<uint32_t>(cell[axis])};
    };
    const uint64_t key = part(0) | (part(1) << 21U) | (part(2) << 42U);
    if (cells.insert(key).second) places.push_back(beam);
  }
  return places;
}

// Outermost sheet to innermost of the true face that a beam ended on; nothing where the model does
// not show it.
std::optional<SheetsApart> sheet_spread(const TriangleMesh& model,
                                        const sim::RayCaster& model_rays,
                                        const sim::RayCaster& world,
                                        const BeamEnd& place) {
  constexpr float kAheadM = 0.15F, kDeepM = 0.30F;
  const Eigen::Vector3f start = place.point_m + kAheadM * place.normal;
  float first = -1.0F, last = -1.0F;
  for (float from = 0.0F; from < kDeepM;) {
    const auto hit = model_rays.cast(start - from * place.normal, -place.normal, kDeepM - from);
    if (!hit) break;
    const float depth = from + hit->range_m;
    from = depth + 1e-4F;
    if (face_normal(model.vertices_m, model.triangles[hit->triangle]).dot(place.normal) < 0.5F) {
      continue;
    }
    // Of this face, and not of a door before the wall?
    const auto near = world.nearest(start - depth * place.normal, kFarthestM);
    if (!near) continue;
    const auto& truth = world.world();
    const auto& triangle = truth.triangles[near->triangle];
    const float turn = face_normal(truth.vertices_m, triangle).dot(place.normal);
    const float off = place.normal.dot(truth.vertices_m[triangle[0]] - place.point_m);
    if (std::abs(turn) < 0.999F || std::abs(off) > 1e-3F) continue;
    if (first < 0.0F) first = depth;
    last = depth;
  }
  if (first < 0.0F) return std::nullopt;
  return SheetsApart{place, kAheadM - first, kAheadM - last};
}

}  // namespace

Eigen::Vector3f face_normal(const std::vector<Eigen::Vector3f>& vertices_m,
                            const std::array<uint32_t, 3>& triangle) {
  const Eigen::Vector3f& from = vertices_m[triangle[0]];
  return (vertices_m[triangle[1]] - from).cross(vertices_m[triangle[2]] - from).normalized();
}

Spread spread_of(std::vector<float> lengths_m) {
  Spread spread;
  spread.count = lengths_m.size();
  if (lengths_m.empty()) return spread;
  double squares = 0.0;
  for (const float length : lengths_m)
    squares += static_cast<double>(length) * static_cast<double>(length);
  std::sort(lengths_m.begin(), lengths_m.end());
  const auto part = [&](double share) {
    return static_cast<double>(
        lengths_m[static_cast<std::size_t>(share * static_cast<double>(lengths_m.size() - 1))]);
  };
  spread.rms_m = std::sqrt(squares / static_cast<double>(lengths_m.size()));
  spread.median_m = part(0.5);
  spread.p90_m = part(0.9);
  spread.p95_m = part(0.95);
  spread.p99_m = part(0.99);
  spread.max_m = part(1.0);
  return spread;
}

TriangleMesh moved(TriangleMesh mesh, const Pose3& by) {
  for (Eigen::Vector3f& vertex : mesh.vertices_m) {
    vertex = (by * vertex.cast<double>()).cast<float>();
  }
  const Eigen::Matrix3f turn = by.linear().cast<float>();
  for (Eigen::Vector3f& normal : mesh.normals) normal = turn * normal;
  return mesh;
}

ModelJudgement judge_model(const TriangleMesh& model,
                           const sim::RayCaster& world,
                           const std::vector<BeamEnd>& beams) {
  ModelJudgement judgement;
  std::vector<float> errors_m;
  for_each_sample(model, kSampleM2, [&](const Eigen::Vector3f& point, std::size_t) {
    errors_m.push_back(world.distance_to_surface_m(point, kFarthestM));
  });
  judgement.error = spread_of(std::move(errors_m));
  if (beams.empty() || model.triangles.empty()) return judgement;
  const sim::RayCaster model_rays = as_world(model);
  SurfaceCoverage coverage;
  SheetSpread sheets;
  std::vector<float> spreads_m;
  std::size_t covered = 0;
  for (const BeamEnd& place : one_a_cell(beams)) {
    ++coverage.places;
    const float distance_m = model_rays.distance_to_surface_m(place.point_m, kFarthestM);
    covered += static_cast<double>(distance_m) <= coverage.near_m ? 1 : 0;
    const auto apart = sheet_spread(model, model_rays, world, place);
    if (!apart) continue;
    spreads_m.push_back(apart->outer_m - apart->inner_m);
    sheets.doubled += spreads_m.back() > 0.0F ? 1 : 0;
    sheets.too_far += spreads_m.back() > kTooFarApartM ? 1 : 0;
    if (spreads_m.back() > kTooFarApartM) sheets.apart.push_back(*apart);
  }
  coverage.covered = static_cast<double>(covered) / static_cast<double>(coverage.places);
  const Spread spread = spread_of(std::move(spreads_m));
  sheets.places = spread.count;
  sheets.p99_m = spread.p99_m;
  sheets.max_m = spread.max_m;
  judgement.coverage = coverage;
  judgement.sheets = sheets;
  return judgement;
}

}  // namespace marco
