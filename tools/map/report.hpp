#pragma once

#include <filesystem>

#include "slam/localization/saved_map.hpp"
#include "tools/map/map_job.hpp"
#include "tools/map/photographs.hpp"
#include "tools/map/self_correction.hpp"
#include "tools/map/verdict.hpp"

namespace marco {

/// What the report needs besides the job.
struct ReportExtras {
  std::map<std::string, double> errors;   ///< against truth, by name with unit
  std::map<std::string, double> surface;  ///< of the joined surface, by name with unit
  PhotographCounts photographs;
  std::vector<std::string> command_line;
  std::string configuration;            ///< TOML of the options that differ from the defaults
  const MapVerdict* verdict = nullptr;  ///< none where no map was made
  const SelfCorrection* correction = nullptr;  ///< none where none was looked for
};

/// Sessions that were not found in the map of the others: each has its own map.
struct KeptApart {
  std::string inputs;  ///< "session 2 (b.log), session 4 (d.log)"
  std::string folder;  ///< within that of the results
  const slam::SavedMap* map = nullptr;
};
std::vector<KeptApart> kept_apart(const MapJob& job);

/// Writes report.json: version, command line and inputs; what was read, used and dropped, and why;
/// loops, times, memory, errors. docs/report.md explains each field. Bytes of names that are not
/// UTF-8 are replaced.
void write_report(const std::filesystem::path& path, const MapJob& job, const ReportExtras& extras);

/// Prints the result of the job for a person.
void print_summary(const MapJob& job,
                   const ReportExtras& extras,
                   const std::filesystem::path& folder);

/// Metres driven along a trajectory.
double path_length_m(const Trajectory& trajectory);

}  // namespace marco
