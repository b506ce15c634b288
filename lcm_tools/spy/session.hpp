#pragma once

#include <optional>
#include <string>
#include <vector>

#include "lcm_tools/spy/view.hpp"

namespace marco::spy {

/// What the command line asks for.
struct SessionOptions {
  std::string log;                 ///< "" = live
  std::string lcm_url;             ///< "" = the one all processes use
  std::vector<std::string> types;  ///< files and folders of `.lcm` sources
  bool once = false;               ///< one report, then the end
  bool json = false;
  double duration_s = 0;  ///< of listening, or of the log from its first event; 0 = see --help
  double speed = 1;       ///< of a log on the screen
  std::string channel;    ///< the one opened (screen) or shown instead of the table (--once)
  std::string page;       ///< channel | plot:FIELD | picture | who
  int width = 0;          ///< of the picture of --once; 0 = 120 x 30
  int height = 0;
};

/// Runs until the job is done or the person quits. @returns the exit code: 0, or 1 when --once
/// heard nothing at all.
int run_session(const SessionOptions& options);

}  // namespace marco::spy
