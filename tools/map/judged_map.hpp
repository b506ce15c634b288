#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "tools/map/map_arguments.hpp"
#include "tools/map/map_job.hpp"
#include "tools/map/self_correction.hpp"
#include "tools/map/verdict.hpp"

namespace marco {

/// A map with its verdict.
struct JudgedMap {
  std::unique_ptr<MapJob> job;
  std::optional<MapVerdict> verdict;  ///< nothing when localizing
};

/// The options of a batch run: those of --config, with --calibration and --hold-out, and with what
/// the lasers of the recordings show of their own robot.
MapOptions load_batch_options(const MapArguments& arguments, const ForeignTable& foreign);

/// Reads all inputs, makes the map and judges it. @param folder  of slam.lcm
/// @param clock  keeps running. @throws std::invalid_argument for an input that cannot be used.
JudgedMap make_map(const MapArguments& arguments,
                   const MapOptions& options,
                   const ForeignTable& foreign,
                   const std::filesystem::path& folder,
                   const StageClock& clock);

/// Makes the map again where the recording's own set-up was not as it said.
/// @returns what was found; nothing where nobody looked.
std::optional<SelfCorrection> correct(const MapArguments& arguments,
                                      const MapOptions& options,
                                      const ForeignTable& foreign,
                                      const std::filesystem::path& out,
                                      JudgedMap& map);

}  // namespace marco
