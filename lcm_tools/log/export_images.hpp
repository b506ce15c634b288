#pragma once

#include <filesystem>

#include "lcm_tools/log/log_walk.hpp"

namespace marco::logs {

struct ImagesResult {
  WalkResult walk;
  int64_t written = 0;
  int64_t unknown_format = 0;  ///< pixel formats other than JPEG, gray, RGB and BGR
  int64_t broken = 0;          ///< sizes and bytes that contradict each other
};

/// Writes each bot_core.image_t as FOLDER/CHANNEL_UTIME.jpg (its bytes as they are) or .png.
/// @throws as export_csv about the folder; std::runtime_error when a file cannot be written.
ImagesResult export_images(WalkInput& input,
                           const Types& types,
                           const std::filesystem::path& folder,
                           Existing existing,
                           const OnProgress& on_progress);

}  // namespace marco::logs
