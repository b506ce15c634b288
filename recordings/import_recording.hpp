#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "lcm_tools/log/select.hpp"
#include "recordings/sample_reader.hpp"

namespace marco::logs {

struct ImportResult {
  int64_t events = 0;
  files::InputReport report;
};

/// Writes a recording (a CARMEN log or any other that open_recording knows) as an LCM log with
/// Marco's own channels: LIDAR, ODOMETRY and, once a second, SENSOR_INFO. The event time is the
/// message's stamp; where stamps step backwards it stands still, so that players need not wait.
/// @throws std::invalid_argument or std::runtime_error as open_recording and OutputFile.
ImportResult import_recording(const std::filesystem::path& in,
                              OutputFile& out,
                              const OnProgress& on_progress);

}  // namespace marco::logs
