#include <cstdio>
#include <filesystem>

#include "common/check.hpp"
#include "common/files/glb.hpp"
#include "common/files/ply.hpp"
#include "common/files/whole_file.hpp"
#include "common/process/arguments.hpp"
#include "common/process/config.hpp"
#include "mapping3d/surface/simplify.hpp"
#include "mapping3d/surface/texture.hpp"
#include "viewer/image_io.hpp"

namespace marco {
namespace {

struct PhotographSpec {
  std::string file;                                    ///< beside the list, or absolute
  std::vector<double> position_m = {0, 0, 0};          ///< of the camera, in the model's frame
  std::vector<double> quaternion_xyzw = {0, 0, 0, 1};  ///< model from camera: z ahead, y down
  std::vector<double> focal_px = {0};                  ///< one, or x and y
  std::vector<double> centre_px;                       ///< the picture's middle when left out
  double k1 = 0.0;
  double k2 = 0.0;

  template <class Visitor>
  void visit(Visitor& v) {
    v("file", file);
    v("position_m", position_m);
    v("quaternion_xyzw", quaternion_xyzw);
    v("focal_px", focal_px, kPositive);
    v("centre_px", centre_px);
    v("k1", k1);
    v("k2", k2);
  }
};

struct PhotographList {
  std::vector<PhotographSpec> photographs;
  mapping3d::TextureOptions texture;
  mapping3d::SimplifyOptions simplify;

  template <class Visitor>
  void visit(Visitor& v) {
    v("photographs", photographs);
    v("texture", texture);
    v("simplify", simplify);
  }
};

Pose3 pose_of(const PhotographSpec& spec) {
  const auto& p = spec.position_m;
  const auto& q = spec.quaternion_xyzw;
  require(p.size() == 3 && q.size() == 4,
          spec.file + ": expected position_m of 3 and quaternion_xyzw of 4 numbers");
  const Eigen::Quaterniond turn(q[3], q[0], q[1], q[2]);
  require(turn.norm() > 0.5, spec.file + ": quaternion_xyzw is no rotation");
  Pose3 pose = Pose3::Identity();
  pose.linear() = turn.normalized().toRotationMatrix();
  pose.translation() = Eigen::Vector3d(p[0], p[1], p[2]);
  return pose;
}

mapping3d::CameraPicture load(const PhotographSpec& spec, const std::filesystem::path& folder) {
  const viewer::Picture picture = viewer::read_picture((folder / spec.file).string());
  mapping3d::CameraPicture loaded;
  loaded.camera.width_px = picture.width_px;
  loaded.camera.height_px = picture.height_px;
  loaded.camera.focal_x_px = spec.focal_px.front();
  loaded.camera.focal_y_px = spec.focal_px.back();
  const bool said = spec.centre_px.size() == 2;
  loaded.camera.centre_x_px = said ? spec.centre_px[0] : 0.5 * (picture.width_px - 1);
  loaded.camera.centre_y_px = said ? spec.centre_px[1] : 0.5 * (picture.height_px - 1);
  loaded.camera.k1 = spec.k1;
  loaded.camera.k2 = spec.k2;
  loaded.world_from_camera = pose_of(spec);
  for (const viewer::Rgb& pixel : picture.pixels) {
    loaded.rgb.insert(loaded.rgb.end(), {pixel.red, pixel.green, pixel.blue});
  }
  return loaded;
}

viewer::Picture atlas_of(const mapping3d::TexturedSurface& painted) {
  viewer::Picture atlas(painted.width_px, painted.height_px, {});
  for (std::size_t i = 0; i < atlas.pixels.size(); ++i) {
    atlas.pixels[i] = {painted.rgb[3 * i], painted.rgb[3 * i + 1], painted.rgb[3 * i + 2]};
  }
  return atlas;
}

int run(const std::string& model, const std::string& list, const std::filesystem::path& out) {
  const auto options = process::load_options<PhotographList>(list);
  std::vector<mapping3d::CameraPicture> pictures;
  int refused = 0;
  for (const PhotographSpec& spec : options.photographs) {
    try {
      require(!spec.focal_px.empty(), spec.file + ": focal_px is missing");
      pictures.push_back(load(spec, std::filesystem::path(list).parent_path()));
    } catch (const std::exception& fault) {
      std::fprintf(stderr, "skipped: %s\n", fault.what());
      ++refused;
    }
  }
  const TriangleMesh whole = files::read_ply(model);
  const mapping3d::Simplified fewer =
      mapping3d::simplify(whole, mapping3d::find_planes(whole), options.simplify);
  const mapping3d::TexturedSurface painted =
      mapping3d::paint(fewer.mesh, pictures, options.texture);
  require(!painted.mesh.triangles.empty(), model + ": has no triangles");
  const std::filesystem::path atlas = std::filesystem::path(out).replace_extension(".png");
  viewer::write_png(atlas_of(painted), atlas.string());
  files::write_glb(out, TexturedMesh{painted.mesh, painted.uvs, files::read_whole_file(atlas)});
  std::printf(
      "%d photographs used, %d skipped; %.1f %% of the surface painted; %zu triangles, "
      "atlas of %d x %d texels: %s\n",
      painted.pictures_used, painted.pictures_refused + refused, 100.0 * painted.painted,
      painted.mesh.triangles.size(), painted.width_px, painted.height_px, out.c_str());
  return painted.pictures_used > 0 ? 0 : 1;
}

}  // namespace
}  // namespace marco

int main(int argc, char** argv) {
  return marco::process::run_main("marco-texture", [&] {
    CLI::App app(
        "Paints a model with photographs whose cameras and places are known.\n"
        "PHOTOGRAPHS lists them:\n"
        "  [[photographs]]\n"
        "  file = \"a.jpg\"\n"
        "  focal_px = [600]\n"
        "  position_m = [2.0, 3.0, 0.6]             # in the model's frame\n"
        "  quaternion_xyzw = [-0.5, 0.5, -0.5, 0.5]   # model from camera: z ahead, x right, y "
        "down");
    std::string model, list, out = "model_textured.glb";
    app.add_option("MODEL", model, "PLY")->required()->check(CLI::ExistingFile);
    app.add_option("PHOTOGRAPHS", list, "TOML")->required()->check(CLI::ExistingFile);
    app.add_option("--out", out, "GLB; the atlas is written beside it")->capture_default_str();
    if (const auto code = marco::process::parse_arguments(app, argc, argv)) return *code;
    return marco::run(model, list, out);
  });
}
