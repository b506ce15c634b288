#include <cstdio>

#include "common/check.hpp"
#include "common/process/arguments.hpp"
#include "common/process/config.hpp"
#include "tools/figures/thesis_figures.hpp"
#include "tools/map/map_job.hpp"
#include "viewer/process/render_command.hpp"

namespace marco {
namespace {

int run(const std::string& log,
        const std::string& config,
        const std::filesystem::path& out,
        const FigureOptions& figures) {
  auto options = process::load_options<MapOptions>(config);
  std::filesystem::create_directories(out);
  MapJob job(options, PathMaker::scans, out);
  job.read(log, process::load_options<ForeignTable>(""));
  job.finish();
  const auto stops = by_stop(job.mapping3d().mapper().scenes());
  require(!stops.empty(), log + ": holds no 3D sweep");
  for (const Figure& figure : draw_thesis_figures(out, stops, figures)) {
    std::printf("%s: %s\n", (out / figure.file).c_str(), figure.what.c_str());
  }
  std::printf("(thesis B's own scene: 59924 triangles, 29785 quads of 36100 beams)\n");
  return 0;
}

}  // namespace
}  // namespace marco

int main(int argc, char** argv) {
  return marco::process::run_main("marco-figures", [&] {
    CLI::App app(
        "The equals of thesis B's figures 5.13-5.17 and 5.19-5.21 from a recording with 3D sweeps: "
        "its polygons, its light, its way of joining.");
    std::string log, config, out = "out/figures", size = "1000x750";
    marco::FigureOptions figures;
    app.add_option("LOG", log)->required()->check(CLI::ExistingPath);
    app.add_option("--out", out, "folder for the pictures")->capture_default_str();
    app.add_option("--config", config, "TOML, as for marco map")->check(CLI::ExistingFile);
    app.add_option("--size", size, "WIDTHxHEIGHT [px]")->capture_default_str();
    app.add_option("--cut-ends", figures.cut_ends, "leave out so many beams at each end of a scan")
        ->check(CLI::Range(0, 100000))
        ->capture_default_str();
    app.add_option("--mode", figures.mode, "points, wire or filled")
        ->transform(CLI::CheckedTransformer(
            std::map<std::string, marco::viewer::Mode>{{"points", marco::viewer::Mode::points},
                                                       {"wire", marco::viewer::Mode::wire},
                                                       {"filled", marco::viewer::Mode::filled}}));
    if (const auto code = marco::process::parse_arguments(app, argc, argv)) return *code;
    figures.size = marco::viewer::parse_size(size);
    return marco::run(log, config, out, figures);
  });
}
