#pragma once

#include <filesystem>
#include <vector>

#include "recordings/ros/split_recordings.hpp"

namespace marco {

/// Inputs as the recordings that they make up: the parts of a split recording of ROS are one, and
/// files of 3D scans in a row. In the order of the inputs.
std::vector<RecordingParts> recordings_of(const std::vector<std::filesystem::path>& inputs);

/// The recordings in a folder, and in folders within it, by name; the folder itself where it is
/// one: of rosbag2, of 3D scans, or with nothing else in it than one recording of ROS. Hidden files
/// and the results of `marco map` are none.
std::vector<RecordingParts> recordings_in(const std::filesystem::path& folder);

}  // namespace marco
