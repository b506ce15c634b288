#pragma once

#include <filesystem>
#include <memory>

#include "recordings/ros/message_source.hpp"
#include "recordings/ros/split_recordings.hpp"

namespace marco::ros {

/// Whether a file begins as a ROS bag, an MCAP file, a database or a zstd frame does.
bool is_message_file(const std::filesystem::path& path);

/// The same, or that of a file in a folder.
bool is_message_recording(const std::filesystem::path& path);

/// Opens a recording of ROS messages: a bag (ROS 1), an MCAP file, a database of rosbag2, a folder
/// with the parts of one recording, each of them also in a zstd frame, which is unpacked into a
/// temporary file.
/// @throws std::invalid_argument naming the file and what is wrong with it, or the recordings in a
/// folder of several.
std::unique_ptr<MessageSource> open_messages(const std::filesystem::path& path);

/// The parts of one recording in a row.
std::unique_ptr<MessageSource> open_messages(const RecordingParts& parts);

}  // namespace marco::ros
