#pragma once

#include <functional>
#include <string>
#include <vector>

namespace marco::spy {

/// What a program adds to the spy of lcm_tools.
struct SpyExtensions {
  /// Explains a file without any LCM event. Empty: "PATH: has no complete LCM event".
  std::function<std::string(const std::string& path)> explain_no_log = {};
  std::vector<std::string> hints = {};  ///< Surroundings::hints; none = the spy's own
};

/// The command line.
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
  SpyExtensions extensions;
};

/// Runs until the job is done or the user quits. @returns the exit code: 0, or 1 when --once
/// received nothing.
int run_session(const SessionOptions& options);

/// The body of main: parses the command line and runs the session. @returns the exit code.
int run_spy_program(int argc, char** argv, const SpyExtensions& extensions);

}  // namespace marco::spy
