#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "recordings/foreign.hpp"
#include "recordings/ros/split_recordings.hpp"
#include "recordings/sample_reader.hpp"

namespace marco {

/// Opens a recording of any known format: LCM logs, CARMEN logs, text logs of Odometry and Laser
/// lines, folders or files of tilted 3D scans, the theses' own files. The format is recognised by
/// the content, not the name. One table in recording.cpp lists the formats; a new one is a row
/// there and a QueuedReader.
/// @throws std::invalid_argument naming the file, what it looks like and what to do; or the folder,
/// and the recordings in it where they are several.
std::unique_ptr<files::SampleReader> open_recording(const std::filesystem::path& path,
                                                    const ForeignTable& table = {});

/// The same of parts, as recordings_of() joins them.
std::unique_ptr<files::SampleReader> open_recording(const RecordingParts& parts,
                                                    const ForeignTable& table = {});

/// Whether open_recording knows the format: by its first bytes, or what a folder holds.
bool is_recording(const std::filesystem::path& path);

/// Explains a file in which no LCM event was found: what it is instead, and how to convert it.
std::string why_no_log(const std::filesystem::path& path);

}  // namespace marco
