#include <cctype>
#include <cstdio>
#include <filesystem>
#include <map>
#include <sstream>

#include "common/files/glb.hpp"
#include "common/files/map_yaml.hpp"
#include "common/files/mesh_file.hpp"
#include "common/files/tum.hpp"
#include "lcm_tools/base/check.hpp"
#include "lcm_tools/base/format.hpp"
#include "lcm_tools/files/output_folder.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/process/arguments.hpp"
#include "viewer/image_io.hpp"
#include "viewer/painted_mesh.hpp"
#include "viewer/process/inputs.hpp"
#include "viewer/process/render_command.hpp"
#include "viewer/vector_export.hpp"

namespace marco::viewer {
namespace {

struct Arguments {
  std::vector<std::string> inputs;
  std::string out = "picture.png";
  std::string size = "1280x720";
  std::string light = "room";
  std::string walk;
  bool orthographic = false;
  RenderRequest request;
};

const std::map<std::string, Mode> kModes{
    {"points", Mode::points}, {"wire", Mode::wire}, {"filled", Mode::filled}};
const std::map<std::string, Coloring> kColorings{{"height", Coloring::height},
                                                 {"normal", Coloring::normal},
                                                 {"scene", Coloring::scene},
                                                 {"photograph", Coloring::scene},
                                                 {"grey", Coloring::grey}};

void add_options(process::CommandLine& app, Arguments& arguments) {
  RenderRequest& request = arguments.request;
  app.add_option(
         "inputs", arguments.inputs,
         "models (.ply, .obj, .glb), maps (.yaml), trajectories (.tum), folders written by `map`")
      .required();
  app.add_option("--out", arguments.out,
                 "what to write: .png, .mp4 (a film), .eps .svg .pdf; a folder with --walk")
      .shows_default();
  app.add_option("--size", arguments.size, "WIDTHxHEIGHT [px]").shows_default();
  app.add_option(
      "--camera", request.camera,
      "above, eye, front, sheet (all of them), robot (its current view), or x,y,z,yaw,pitch [m, "
      "deg]");
  app.add_choice("--mode", request.look.mode, kModes, "points, wire or filled");
  app.add_choice("--color", request.look.coloring, kColorings,
                 "height, normal, scene, photograph (the model's own colours) or grey");
  app.add_option("--light", arguments.light, "room, or thesis: grey under one lamp")
      .one_of({"room", "thesis"})
      .shows_default();
  app.add_flag("--ortho", arguments.orthographic, "orthographic projection");
  app.add_option("--cut", request.cut_height_m, "cut off everything above this height [m]");
  app.add_option("--walls", request.wall_height_m, "height of a map's walls [m]");
  app.add_option("--detail", request.look.detail_px,
                 "largest error of simplified surfaces [px], to draw faster; 0: every triangle")
      .between(0.0, 100.0);
  app.add_option("--walk", arguments.walk,
                 "the robot's commands (\"a10 i19 e4\"), or a file of them; a picture after each");
}

// The script itself, or the file that holds it.
std::string walk_script(const std::string& text) {
  std::error_code none;
  return std::filesystem::is_regular_file(text, none) ? files::read_whole_file(text) : text;
}

std::string write_vector_page(Scene scene, const RenderRequest& request, const std::string& path) {
  const VectorFormat format = vector_format(path);
  scene = scene_in_space(std::move(scene), request);
  Renderer renderer;
  renderer.load(scene);
  const VectorReport report =
      write_vector(scene, plan_request(scene, request, renderer), request.size, format, path);
  return std::to_string(report.polygons) + " polygons, " + std::to_string(report.lines) + " lines";
}

std::string write_output(const Scene& scene, const Arguments& arguments) {
  const std::string& out = arguments.out;
  const RenderRequest& request = arguments.request;
  if (!arguments.walk.empty())
    return std::to_string(render_walk(scene, request, walk_script(arguments.walk), out)) +
           " pictures";
  if (out.ends_with(".mp4")) return std::to_string(render_film(scene, request, out)) + " pictures";
  if (!out.ends_with(".png")) return write_vector_page(scene, request, out);
  const Picture picture =
      request.camera == "sheet" ? render_sheet(scene, request) : render_scene(scene, request);
  write_png(picture, out);
  return std::to_string(picture.width_px) + "x" + std::to_string(picture.height_px) + " px";
}

char key_from_stdin() {
  for (int key = std::getchar(); key != EOF; key = std::getchar())
    if (std::isspace(key) == 0) return static_cast<char>(key);
  return 0;
}

bool is_vector_page(const std::string& out) {
  return out.ends_with(".eps") || out.ends_with(".svg") || out.ends_with(".pdf");
}

Inputs read_and_tell(const Arguments& arguments, const FileReaders& readers) {
  const bool is_page = arguments.walk.empty() && is_vector_page(arguments.out);
  Inputs inputs =
      read_inputs(arguments.inputs, readers, is_page ? FolderModel::simplified : FolderModel::full);
  for (const std::string& skipped : inputs.skipped)
    std::fprintf(stderr, "marco-viewer: skipped %s\n", skipped.c_str());
  return inputs;
}

int run_walk(int argc, const char* const* argv, const FileReaders& readers) {
  process::CommandLine app(
      "Walks through a model like the robot, and draws its view after each step. Letters "
      "on "
      "stdin drive it: a r ahead and back, i d turn left and right, each by a unit; e E tilt, g G "
      "pan.",
      "marco-viewer walk");
  Arguments arguments;
  arguments.out = "walk";
  app.add_option("inputs", arguments.inputs, "models (.ply, .obj, .glb), folders written by `map`")
      .required();
  app.add_option("--script", arguments.walk,
                 "instead of keys: the robot's commands (\"a10 i19 e4\"), or a file of them");
  app.add_option("--out", arguments.out, "folder for the pictures").shows_default();
  app.add_option("--size", arguments.size, "WIDTHxHEIGHT [px]").shows_default();
  if (const auto exit_code = app.parse(argc, argv)) return *exit_code;
  arguments.request.size = parse_size(arguments.size);
  const Inputs inputs = read_and_tell(arguments, readers);
  if (!arguments.walk.empty()) {
    std::printf("%s: %s\n", arguments.out.c_str(), write_output(inputs.scene, arguments).c_str());
    return 0;
  }
  files::OutputFolder pictures(arguments.out, "walk");
  int count = 0;
  render_walk_by_keys(inputs.scene, arguments.request, key_from_stdin, [&](const Picture& seen) {
    write_png(seen, (pictures.path() / format("%03d.png", count++)).string());
  });
  pictures.commit();
  std::printf("%s: %d pictures\n", arguments.out.c_str(), count);
  return 0;
}

int run_viewer(int argc, const char* const* argv, const FileReaders& readers) {
  if (argc > 1 && std::string(argv[1]) == "walk") return run_walk(argc - 1, argv + 1, readers);
  process::CommandLine app("Draws models and maps: pictures, films, vector pages, walks.",
                           "marco-viewer");
  Arguments arguments;
  add_options(app, arguments);
  if (const auto exit_code = app.parse(argc, argv)) return *exit_code;
  RenderRequest& request = arguments.request;
  request.size = parse_size(arguments.size);
  if (arguments.orthographic) request.projection = Projection::orthographic;
  if (arguments.light == "thesis") request.look = thesis_look(request.look.mode);
  const std::string& out = arguments.out;
  require(!arguments.walk.empty() || out.ends_with(".png") || out.ends_with(".mp4") ||
              is_vector_page(out),
          "--out " + out + ": expected a name ending in .png, .mp4, .eps, .svg or .pdf");
  const Inputs inputs = read_and_tell(arguments, readers);
  const std::string what = write_output(inputs.scene, arguments);
  std::printf("%s: %s\n", out.c_str(), what.c_str());
  return 0;
}

}  // namespace
}  // namespace marco::viewer

int main(int argc, char** argv) {
  return marco::process::run_main("marco-viewer", [&] {
    const auto read_mesh = [](const std::string& path) {
      return path.ends_with(".glb")
                 ? marco::viewer::with_painted_vertices(marco::files::read_glb(path))
                 : marco::files::read_mesh(path);
    };
    const marco::viewer::FileReaders readers{read_mesh, marco::files::read_map,
                                             marco::files::read_tum};
    return marco::viewer::run_viewer(argc, argv, readers);
  });
}
