#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/files/glb.hpp"

namespace marco {

/// The command line of `marco map`.
struct MapArguments {
  std::vector<std::string> command_line;
  std::vector<std::string> inputs;
  std::string out = "out";
  std::string config;
  std::string foreign;
  std::string world;
  std::string extend;
  std::string localize;
  std::vector<double> start;  ///< x, y [m], heading [degrees] in the map of `localize`; or empty
  std::string edits;
  std::string calibration;
  int hold_out_every = 0;
  bool lines = false;
  bool merge = false;
  bool calibrate = false;
  bool no_calibration = false;
  bool loop_pictures = false;
  bool sweep_meshes = false;
  bool results_log = false;
  files::GlbNumbers glb_numbers = files::GlbNumbers::plain;
  bool check = false;
};

/// @returns the exit code when there is nothing left to do: --help, --print-config, a mistake.
std::optional<int> parse_map_arguments(int argc, char** argv, MapArguments& arguments);

}  // namespace marco
