#include "tools/map/joined_surface.hpp"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "common/files/obj.hpp"
#include "common/files/ply.hpp"
#include "lcm_tools/files/whole_file.hpp"

namespace marco {
namespace {

using mapping3d::SurfacePlane;
using nlohmann::json;

constexpr std::array kKindNames = {"floor", "ceiling", "wall", "level", "other"};
static_assert(kKindNames.size() == static_cast<std::size_t>(SurfacePlane::Kind::other) + 1);

json list(const Eigen::VectorXd& values) {
  return std::vector<double>(values.data(), values.data() + values.size());
}

std::string planes_json(const std::vector<SurfacePlane>& planes) {
  json all = json::array();
  for (const SurfacePlane& plane : planes) {
    json covariance = json::array();
    for (int row = 0; row < 3; ++row) covariance.push_back(list(plane.covariance.row(row)));
    all.push_back({{"kind", kKindNames.at(static_cast<std::size_t>(plane.kind))},
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

void write_joined_surface(const std::filesystem::path& folder,
                          const TriangleMesh& model,
                          const mapping3d::JoinedSurface& joined,
                          files::GlbNumbers glb_numbers) {
  if (model.triangles.empty()) return;
  files::write_ply(folder / "model.ply", model);
  files::write_glb(folder / "model.glb", joined.simplified.mesh, glb_numbers);
  files::write_obj(folder / "model.obj", joined.simplified.mesh);
  files::write_whole_file(folder / "planes.json", planes_json(joined.planes));
}

std::map<std::string, double> figures_of(const TriangleMesh& model,
                                         const mapping3d::JoinedSurface& joined,
                                         std::size_t scenes) {
  if (model.triangles.empty()) return {};
  const mapping3d::Simplified& fewer = joined.simplified;
  return {{"scenes", static_cast<double>(scenes)},
          {"triangles", static_cast<double>(model.triangles.size())},
          {"simplified triangles", static_cast<double>(fewer.mesh.triangles.size())},
          {"simplified, farthest sample_m", std::max(fewer.there_m, fewer.back_m)},
          {"planes", static_cast<double>(joined.planes.size())}};
}

}  // namespace marco
