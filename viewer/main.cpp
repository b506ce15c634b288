#include "common/files/map_yaml.hpp"
#include "common/files/ply.hpp"
#include "common/files/tum.hpp"
#include "common/process/arguments.hpp"
#include "viewer/process/command_line.hpp"

int main(int argc, char** argv) {
  return marco::process::run_main("marco-viewer", [&] {
    const marco::viewer::FileReaders readers{marco::files::read_ply, marco::files::read_map,
                                             marco::files::read_tum};
    return marco::viewer::run_viewer(argc, argv, readers);
  });
}
