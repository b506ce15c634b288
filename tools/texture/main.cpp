#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "common/files/glb.hpp"
#include "common/files/ply.hpp"
#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/process/arguments.hpp"
#include "lcm_tools/process/config.hpp"
#include "mapping3d/surface/planes.hpp"
#include "tools/texture/photograph_list.hpp"
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

mapping3d::CameraPicture load(const PhotographSpec& spec, const std::filesystem::path& folder) {
  const viewer::Picture picture = viewer::read_picture((folder / spec.file).string());
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

viewer::Picture atlas_of(const mapping3d::TexturedSurface& painted) {
  viewer::Picture atlas(painted.width_px, painted.height_px, {});
  for (std::size_t i = 0; i < atlas.pixels.size(); ++i) {
    atlas.pixels[i] = {painted.rgb[3 * i], painted.rgb[3 * i + 1], painted.rgb[3 * i + 2]};
  }
  return atlas;
}

struct Arguments {
  std::string model;
  std::string list;
  std::string out = "model_textured.glb";
  std::string report;
  bool as_it_is = false;
  files::GlbNumbers glb_numbers = files::GlbNumbers::plain;
};

void write_report(const std::string& path,
                  const mapping3d::TexturedSurface& painted,
                  int unreadable) {
  const nlohmann::json counted = {
      {"used", painted.pictures_used},
      {"skipped", painted.pictures_refused + unreadable},
      {"part of the surface painted", painted.painted},
      {"atlas_px", static_cast<double>(painted.width_px) * painted.height_px}};
  files::write_whole_file(path, counted.dump() + "\n");
}

int run(const Arguments& arguments) {
  const auto options = process::load_options<PhotographList>(arguments.list);
  std::vector<mapping3d::CameraPicture> pictures;
  int unreadable = 0;
  for (const PhotographSpec& spec : options.photographs) {
    try {
      require(!spec.focal_px.empty(), spec.file + ": focal_px is missing");
      pictures.push_back(load(spec, std::filesystem::path(arguments.list).parent_path()));
    } catch (const std::exception& fault) {
      std::fprintf(stderr, "skipped: %s\n", fault.what());
      ++unreadable;
    }
  }
  TriangleMesh mesh = files::read_ply(arguments.model);
  if (!arguments.as_it_is) {
    mesh = mapping3d::simplify(mesh, mapping3d::find_planes(mesh), options.simplify).mesh;
  }
  const mapping3d::TexturedSurface painted = mapping3d::paint(mesh, pictures, options.texture);
  require(!painted.mesh.triangles.empty(), arguments.model + ": has no triangles");
  const std::filesystem::path out = arguments.out;
  const std::filesystem::path atlas = std::filesystem::path(out).replace_extension(".png");
  viewer::write_png(atlas_of(painted), atlas.string());
  files::write_glb(out, TexturedMesh{painted.mesh, painted.uvs, files::read_whole_file(atlas)},
                   arguments.glb_numbers);
  if (!arguments.report.empty()) write_report(arguments.report, painted, unreadable);
  std::printf(
      "%d photographs used, %d skipped; %.1f %% of the surface painted; %zu triangles, "
      "atlas of %d x %d texels: %s\n",
      painted.pictures_used, painted.pictures_refused + unreadable, 100.0 * painted.painted,
      painted.mesh.triangles.size(), painted.width_px, painted.height_px, out.c_str());
  return painted.pictures_used > 0 ? 0 : 1;
}

}  // namespace
}  // namespace marco

int main(int argc, char** argv) {
  // A recording may hold any picture: cameras have fewer than 100 megapixels.
  setenv("OPENCV_IO_MAX_IMAGE_PIXELS", "100000000", 0);
  return marco::process::run_main("marco-texture", [&] {
    CLI::App app(
        "Textures a model with photographs of known camera poses.\n"
        "PHOTOGRAPHS lists them:\n"
        "  [[photographs]]\n"
        "  file = \"a.jpg\"\n"
        "  focal_px = [600]\n"
        "  position_m = [2.0, 3.0, 0.6]             # in the model's frame\n"
        "  quaternion_xyzw = [-0.5, 0.5, -0.5, 0.5]   # model from camera: z ahead, x right, y "
        "down");
    marco::Arguments arguments;
    app.add_option("MODEL", arguments.model, "PLY")->required()->check(CLI::ExistingFile);
    app.add_option("PHOTOGRAPHS", arguments.list, "TOML")->required()->check(CLI::ExistingFile);
    app.add_option("--out", arguments.out, "GLB; the atlas is written beside it")
        ->capture_default_str();
    app.add_flag("--as-it-is", arguments.as_it_is, "texture the model without simplifying it");
    app.add_flag_callback(
        "--compressed-glb", [&] { arguments.glb_numbers = marco::files::GlbNumbers::compressed; },
        "write the GLB with EXT_meshopt_compression and KHR_mesh_quantization");
    app.add_option("--report", arguments.report, "write the counts as JSON");
    if (const auto code = marco::process::parse_arguments(app, argc, argv)) return *code;
    return marco::run(arguments);
  });
}
