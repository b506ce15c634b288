#include "tools/map/joined_surface.hpp"

#include <nlohmann/json.hpp>

#include "common/files/glb.hpp"
#include "common/files/obj.hpp"
#include "common/files/plan_svg.hpp"
#include "common/files/ply.hpp"
#include "lcm_tools/files/whole_file.hpp"

namespace marco {
namespace {

using mapping3d::SurfacePlane;
using nlohmann::json;

const char* name_of(SurfacePlane::Kind kind) {
  switch (kind) {
    case SurfacePlane::Kind::floor:
      return "floor";
    case SurfacePlane::Kind::ceiling:
      return "ceiling";
    case SurfacePlane::Kind::wall:
      return "wall";
    case SurfacePlane::Kind::level:
      return "level";
    case SurfacePlane::Kind::other:
      return "other";
  }
  return "other";
}

json list(const Eigen::VectorXd& values) {
  return std::vector<double>(values.data(), values.data() + values.size());
}

std::string planes_json(const std::vector<SurfacePlane>& planes) {
  json all = json::array();
  for (const SurfacePlane& plane : planes) {
    json covariance = json::array();
    for (int row = 0; row < 3; ++row) covariance.push_back(list(plane.covariance.row(row)));
    all.push_back({{"kind", name_of(plane.kind)},
                   {"normal", list(plane.normal)},
                   {"offset_m", plane.offset_m},
                   {"centre_m", list(plane.centre_m)},
                   {"along", list(plane.along)},
                   {"across", list(plane.across)},
                   {"low_m", list(plane.low_m)},
                   {"high_m", list(plane.high_m)},
                   {"area_m2", plane.area_m2},
                   {"rms_m", plane.rms_m},
                   {"covariance_of_shift_m_and_slopes_rad", covariance}});
  }
  return all.dump(1) + "\n";
}

}  // namespace

JoinedSurface write_joined_surface(const std::filesystem::path& folder,
                                   const std::vector<mapping3d::ScenePoints>& scenes,
                                   const JoinedSurfaceOptions& options) {
  JoinedSurface joined;
  joined.mesh = mapping3d::fuse(scenes, options.surface);
  if (joined.mesh.triangles.empty()) return joined;
  const auto planes = mapping3d::find_planes(joined.mesh, options.planes);
  mapping3d::Simplified fewer = mapping3d::simplify(joined.mesh, planes, options.simplify);
  const auto plan = mapping3d::cut_at(joined.mesh, options.plan_height_m);
  files::write_ply(folder / "model.ply", joined.mesh);
  files::write_glb(folder / "model.glb", fewer.mesh);
  files::write_obj(folder / "model.obj", fewer.mesh);
  files::write_whole_file(folder / "planes.json", planes_json(planes));
  files::write_whole_file(folder / "floor_plan.svg", files::plan_svg(plan));
  joined.figures = {
      {"scenes", static_cast<double>(scenes.size())},
      {"triangles", static_cast<double>(joined.mesh.triangles.size())},
      {"simplified triangles", static_cast<double>(fewer.mesh.triangles.size())},
      {"simplified, farthest sample_m", std::max(fewer.there_m, fewer.back_m)},
      {"simplified, part beyond the bound", fewer.beyond},
      {"simplified, triangles left as they were", static_cast<double>(fewer.as_it_was)},
      {"planes", static_cast<double>(planes.size())}};
  joined.simplified = std::move(fewer.mesh);
  return joined;
}

}  // namespace marco
