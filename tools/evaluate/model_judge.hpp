#pragma once

#include <array>
#include <optional>
#include <vector>

#include "common/pose3.hpp"
#include "common/triangle_mesh.hpp"
#include "simulator/ray_caster.hpp"

namespace marco {

/// Statistics of distances, which are searched up to a metre; nothing else is cut off.
struct Spread {
  std::size_t count = 0;
  double rms_m = 0.0;
  double median_m = 0.0;
  double p90_m = 0.0;
  double p95_m = 0.0;
  double p99_m = 0.0;
  double max_m = 0.0;
};
Spread spread_of(std::vector<float> lengths_m);

/// Where a simulated beam hits the world.
struct BeamEnd {
  Eigen::Vector3f point_m = Eigen::Vector3f::Zero();
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();  ///< of the true surface, towards the beam
  uint32_t triangle = 0;                             ///< of the world
};

struct SurfaceCoverage {
  std::size_t places = 0;  ///< 2 cm cells of true surface that a beam hit
  double covered = 0.0;    ///< part of them with model within `near_m`
  double near_m = 0.02;
};

/// Two model sheets of one true face.
struct SheetsApart {
  BeamEnd place;
  float outer_m = 0.0F;  ///< the outermost sheet before the true face, along its normal
  float inner_m = 0.0F;  ///< the innermost; behind it: negative
};

/// Model sheets of one true face that lie behind one another.
struct SheetSpread {
  std::size_t places = 0;          ///< where the model shows that face
  std::size_t doubled = 0;         ///< of them with more than one sheet
  std::size_t too_far = 0;         ///< of them with two sheets more than 20 mm apart
  std::vector<SheetsApart> apart;  ///< those, in order of the beams
  double p99_m = 0.0;              ///< outermost sheet to innermost
  double max_m = 0.0;
};

struct ModelJudgement {
  Spread error;  ///< of the model's surface, one sample each 4 cm2
  std::optional<SurfaceCoverage> coverage;
  std::optional<SheetSpread> sheets;
};

/// @param model in the world's frame
/// @param beams where true beams end; empty = coverage and sheets are left out
ModelJudgement judge_model(const TriangleMesh& model,
                           const sim::RayCaster& world,
                           const std::vector<BeamEnd>& beams);

/// Unit length, counter-clockwise; zero where the face has no area.
Eigen::Vector3f face_normal(const std::vector<Eigen::Vector3f>& vertices_m,
                            const std::array<uint32_t, 3>& triangle);

/// The mesh, transformed.
TriangleMesh moved(TriangleMesh mesh, const Pose3& by);

}  // namespace marco
