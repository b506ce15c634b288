#include "common/files/glb.hpp"
#include "common/files/map_yaml.hpp"
#include "common/files/mesh_file.hpp"
#include "common/files/tum.hpp"
#include "lcm_tools/process/arguments.hpp"
#include "viewer/painted_mesh.hpp"
#include "viewer/process/command_line.hpp"

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
