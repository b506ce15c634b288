#include <cstdio>
#include <filesystem>
#include <string>

#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/process/arguments.hpp"
#include "web/snapshot/export_html.hpp"

namespace {

int run(const std::string& folder, std::string html) {
  namespace fs = std::filesystem;
  if (html.empty()) html = (fs::path(folder) / "map.html").string();
  const std::string page = marco::web::export_html(folder, marco::web::kDebianThree);
  marco::files::write_whole_file(html, page);
  if (fs::exists(fs::path(folder) / "model.glb") && !fs::exists(marco::web::kDebianThree)) {
    std::fprintf(stderr, "without the 3D model: three.js is not installed (libjs-three)\n");
  }
  std::printf("%s: %.1f MB, opens in any browser without network\n", html.c_str(),
              static_cast<double>(page.size()) * 1e-6);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  return marco::process::run_main("marco-export", [&] {
    marco::process::CommandLine app(
        "Writes a map folder as one HTML file to view, measure and send: floor plan, "
        "path, loops, verdict, 3D model and photographs.",
        "marco-export");
    std::string folder, html;
    app.add_option("FOLDER", folder, "what `marco map` wrote").required();
    app.add_option("--html", html, "the file (FOLDER/map.html)").values(0, 1);
    if (const auto code = app.parse(argc, argv)) return *code;
    return run(folder, html);
  });
}
