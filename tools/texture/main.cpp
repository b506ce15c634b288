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
#include "tools/texture/load_photograph.hpp"
#include "viewer/image_io.hpp"

namespace marco {
namespace {

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
    marco::process::CommandLine app(
        "Textures a model with photographs of known camera poses.\n"
        "PHOTOGRAPHS lists them:\n"
        "  [[photographs]]\n"
        "  file = \"a.jpg\"\n"
        "  focal_px = [600]\n"
        "  position_m = [2.0, 3.0, 0.6]             # in the model's frame\n"
        "  quaternion_xyzw = [-0.5, 0.5, -0.5, 0.5]   # model from camera: z ahead, x right, y "
        "down");
    marco::Arguments arguments;
    app.add_option("MODEL", arguments.model, "PLY").required().existing_file();
    app.add_option("PHOTOGRAPHS", arguments.list, "TOML").required().existing_file();
    app.add_option("--out", arguments.out, "GLB; the atlas is written next to it").shows_default();
    app.add_flag("--as-it-is", arguments.as_it_is, "texture the model without simplifying it");
    app.add_flag(
        "--compressed-glb", [&] { arguments.glb_numbers = marco::files::GlbNumbers::compressed; },
        "write the GLB with EXT_meshopt_compression and KHR_mesh_quantization");
    app.add_option("--report", arguments.report, "write the counts as JSON");
    if (const auto code = app.parse(argc, argv)) return *code;
    return marco::run(arguments);
  });
}
