#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "recordings/kept_samples.hpp"
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

/// What a batch run maps.
struct BatchInput {
  struct Recording {
    std::filesystem::path name;
    std::unique_ptr<KeptSamples> samples;  ///< at the first one
  };
  std::vector<Recording> recordings;  ///< in the order of the sessions
  /// Those of --config, with --calibration and --hold-out, and with what the lasers of the
  /// recordings see of their own robot.
  MapOptions options;
  StageClock clock;
};

/// Opens the recordings, and reads of each what has to be known before its first scan is mapped.
/// @throws std::invalid_argument for an input that cannot be used.
BatchInput load_batch_input(const MapArguments& arguments);

struct CorrectedMap {
  JudgedMap map;
  std::optional<SelfCorrection> correction;  ///< nothing if the set-up was not calibrated
};

/// Makes the map of all recordings and judges it; again with a corrected set-up where calibration
/// finds that the recording's is wrong. Each recording is read from the disk once.
/// @param folder  of slam.lcm. @throws std::invalid_argument for an input that cannot be used.
CorrectedMap make_corrected_map(const MapArguments& arguments,
                                BatchInput input,
                                const std::filesystem::path& folder);

}  // namespace marco
