#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/process/arguments.hpp"
#include "tools/map/picture_order.hpp"
#include "viewer/image_io.hpp"
#include "viewer/map_picture.hpp"
#include "viewer/process/render_command.hpp"

int main(int argc, char** argv) {
  using namespace marco;  // NOLINT(google-build-using-namespace): a main has no other names
  return process::run_main("marco-map-pictures", [&] {
    process::CommandLine app("Draws the pictures that marco-map requests");
    std::string orders;
    app.add_option("ORDERS", orders, "a file that marco-map wrote").required();
    if (const auto code = app.parse(argc, argv)) return *code;
    for (PictureOrder& order : decode_picture_orders(files::read_whole_file(orders))) {
      viewer::RenderRequest request;
      request.camera = order.camera;
      for (const viewer::MeshItem& item : order.scene.meshes) {
        if (!item.mesh->colors_rgb.empty()) request.look.coloring = viewer::Coloring::scene;
      }
      const viewer::Picture picture = order.flat
                                          ? viewer::draw_map(order.scene).picture
                                          : viewer::render_scene(std::move(order.scene), request);
      viewer::write_png(picture, order.path);
    }
    return 0;
  });
}
