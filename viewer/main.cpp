#include <chrono>
#include <thread>

#include "common/files/glb.hpp"
#include "common/files/map_yaml.hpp"
#include "common/files/ply.hpp"
#include "common/files/tum.hpp"
#include "lcm_tools/process/arguments.hpp"
#include "viewer/painted_mesh.hpp"
#include "viewer/process/command_line.hpp"
#include "viewer/process/window.hpp"

int main(int argc, char** argv) {
  return marco::process::run_main("marco-viewer", [&] {
    const auto read_mesh = [](const std::string& path) {
      return path.ends_with(".glb")
                 ? marco::viewer::with_painted_vertices(marco::files::read_glb(path))
                 : marco::files::read_ply(path);
    };
    const marco::viewer::FileReaders readers{read_mesh, marco::files::read_map,
                                             marco::files::read_tum};
    std::unique_ptr<marco::viewer::Window> window;
    std::string keys;
    marco::viewer::WalkDesk desk;
    desk.open = [&] { return (window = marco::viewer::open_window("Marco")) != nullptr; };
    desk.show = [&](const marco::viewer::Picture& picture) { window->show(picture); };
    desk.next_key = [&] {
      while (keys.empty()) {
        if (!window->pump()) return '\0';
        keys = window->take_keys();
        if (keys.empty()) std::this_thread::sleep_for(std::chrono::milliseconds(10));
      }
      const char key = keys.front();
      keys.erase(0, 1);
      return key;
    };
    return marco::viewer::run_viewer(argc, argv, readers, desk);
  });
}
