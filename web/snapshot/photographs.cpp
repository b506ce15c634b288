#include "web/snapshot/photographs.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <nlohmann/json.hpp>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/inside_folder.hpp"
#include "lcm_tools/process/config.hpp"
#include "tools/texture/photograph_list.hpp"

namespace marco::web {

nlohmann::json photographs_json(const std::filesystem::path& folder) {
  nlohmann::json found = nlohmann::json::array();
  const std::filesystem::path list = files::inside_folder(folder, "photographs.toml");
  if (!std::filesystem::exists(list)) return found;
  for (const auto& spec : process::load_options<PhotographList>(list.string()).photographs) {
    if (!files::stays_inside(spec.file)) continue;
    if (!std::filesystem::exists(files::inside_folder(folder, spec.file))) continue;
    require(spec.position_m.size() == 3 && spec.quaternion_xyzw.size() == 4,
            list.string() + ": expected position_m of 3 and quaternion_xyzw of 4 numbers");
    const auto& q = spec.quaternion_xyzw;
    const Eigen::Vector3d ahead =
        Eigen::Quaterniond(q[3], q[0], q[1], q[2]).normalized() * Eigen::Vector3d::UnitZ();
    found.push_back({{"file", spec.file},
                     {"x_m", spec.position_m[0]},
                     {"y_m", spec.position_m[1]},
                     {"z_m", spec.position_m[2]},
                     {"theta_rad", std::atan2(ahead.y(), ahead.x())}});
  }
  return found;
}

}  // namespace marco::web
