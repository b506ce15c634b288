#include "tools/map/point_scans.hpp"

#include <algorithm>
#include <filesystem>

#include "common/files/points/point_files.hpp"
#include "lcm_tools/base/check.hpp"
#include "recordings/tilted_scans.hpp"
#include "tools/map/sibling_program.hpp"

namespace marco {
namespace {

namespace fs = std::filesystem;

bool is_point_file(const fs::path& path) {
  return files::point_format_of(path) && !files::is_tilted_scan(path);
}

bool holds_points(const std::string& input) {
  if (!fs::is_directory(input)) return is_point_file(input);
  bool points = false;
  for (const auto& entry : fs::directory_iterator(input)) {
    if (!entry.is_regular_file()) continue;
    if (files::is_tilted_scan(entry.path())) return false;
    points = points || is_point_file(entry.path());
  }
  return points;
}

}  // namespace

std::optional<int> model_point_scans(const MapArguments& arguments) {
  const auto& inputs = arguments.inputs;
  if (inputs.empty() || !std::all_of(inputs.begin(), inputs.end(), holds_points)) {
    return std::nullopt;
  }
  require(!arguments.check && !arguments.lines && !arguments.calibrate &&
              arguments.localize.empty() && arguments.extend.empty() && arguments.world.empty(),
          inputs.front() + ": a 3D scanner's points make a model, not a map: ./marco model");
  std::vector<std::string> words = inputs;
  words.insert(words.end(), {"--out", arguments.out});
  if (!arguments.config.empty()) words.insert(words.end(), {"--config", arguments.config});
  if (arguments.glb_numbers == files::GlbNumbers::compressed) words.push_back("--compressed-glb");
  return run_sibling("marco-model", std::move(words));
}

}  // namespace marco
