#pragma once

#include <filesystem>
#include <memory>

#include "recordings/ros/message_source.hpp"

namespace marco::ros {

/// A database of rosbag2 (sqlite3), of any version of its tables. It is opened read-only and
/// immutable: nothing is written next to it. The contents of a `-wal` file next to it are not read,
/// which a note reports.
/// @throws std::invalid_argument where it is no such database.
std::unique_ptr<MessageSource> open_db3(const std::filesystem::path& path);

}  // namespace marco::ros
