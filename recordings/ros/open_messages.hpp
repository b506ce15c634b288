#pragma once

#include <filesystem>
#include <memory>
#include <string_view>

#include "recordings/ros/message_source.hpp"

namespace marco::ros {

/// Whether a file begins as a ROS bag, an MCAP file, a database or a zstd frame does, or a folder
/// holds such files.
/// @param head  of the file: 16 bytes or more; empty of a folder
bool is_message_recording(const std::filesystem::path& path, std::string_view head);

/// Opens a recording of ROS messages: a bag (ROS 1), an MCAP file, a database of rosbag2, a folder
/// of rosbag2 with its parts in a row, each of them also in a zstd frame, which is unpacked into a
/// temporary file. The names of files do not matter but for the order of the parts.
/// @throws std::invalid_argument naming the file and what is wrong with it.
std::unique_ptr<MessageSource> open_messages(const std::filesystem::path& path);

}  // namespace marco::ros
