#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "recordings/foreign.hpp"
#include "recordings/sample_reader.hpp"

namespace marco {

/// Opens whatever somebody recorded, recognised by its content, not its name: LCM logs, CARMEN
/// logs, text logs of Odometry and Laser lines, folders or files of tilted 3D scans, the theses'
/// own files. It lives here, above common/files, because an LCM log needs the message types.
/// @throws std::invalid_argument naming the file, what it looks like and what could be done.
std::unique_ptr<files::SampleReader> open_recording(const std::filesystem::path& path,
                                                    const ForeignTable& table = {});

/// For a file in which no LCM event was found: what it is instead, and how an LCM log is made of
/// it. A message for a person.
std::string why_no_log(const std::filesystem::path& path);

}  // namespace marco
