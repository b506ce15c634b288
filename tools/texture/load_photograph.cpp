#include "tools/texture/load_photograph.hpp"

#include <Eigen/Geometry>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/inside_folder.hpp"
#include "viewer/image_io.hpp"

namespace marco {
namespace {

Pose3 pose_of(const PhotographSpec& spec) {
  const auto& p = spec.position_m;
  const auto& q = spec.quaternion_xyzw;
  require(p.size() == 3 && q.size() == 4,
          spec.file + ": expected position_m of 3 and quaternion_xyzw of 4 numbers");
  const Eigen::Quaterniond turn(q[3], q[0], q[1], q[2]);
  require(turn.norm() > 0.5, spec.file + ": quaternion_xyzw is not a rotation");
  Pose3 pose = Pose3::Identity();
  pose.linear() = turn.normalized().toRotationMatrix();
  pose.translation() = Eigen::Vector3d(p[0], p[1], p[2]);
  return pose;
}

}  // namespace

mapping3d::CameraPicture load(const PhotographSpec& spec, const std::filesystem::path& folder) {
  require(!spec.focal_px.empty(), spec.file + ": focal_px is missing");
  const viewer::Picture picture =
      viewer::read_picture(files::inside_folder(folder, spec.file).string());
  mapping3d::CameraPicture loaded;
  loaded.camera.width_px = picture.width_px;
  loaded.camera.height_px = picture.height_px;
  loaded.camera.focal_x_px = spec.focal_px.front();
  loaded.camera.focal_y_px = spec.focal_px.back();
  const bool has_centre = spec.centre_px.size() == 2;
  loaded.camera.centre_x_px = has_centre ? spec.centre_px[0] : 0.5 * (picture.width_px - 1);
  loaded.camera.centre_y_px = has_centre ? spec.centre_px[1] : 0.5 * (picture.height_px - 1);
  loaded.camera.k1 = spec.k1;
  loaded.camera.k2 = spec.k2;
  loaded.world_from_camera = pose_of(spec);
  for (const viewer::Rgb& pixel : picture.pixels) {
    loaded.rgb.insert(loaded.rgb.end(), {pixel.red, pixel.green, pixel.blue});
  }
  return loaded;
}

}  // namespace marco
