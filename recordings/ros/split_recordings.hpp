#pragma once

#include <filesystem>
#include <vector>

namespace marco {

/// The files of one recording in the order of time; most have one. A folder may stand for all.
using RecordingParts = std::vector<std::filesystem::path>;

namespace ros {

/// Joins what a recorder of ROS split (`rosbag record --split`: NAME_0.bag, NAME_1.bag, ...).
/// Parts of one recording are
///  - files that the metadata.yaml of rosbag2 in their folder names, in its order; or
///  - files of one folder whose names differ by a running number, and the recorder's date, alone;
///    whose topics have the same names and types; and of which each begins within seconds of the
///    end of the one before. What cannot be read is no part of another.
/// @param files  of any format, and folders: those that are not of ROS stand for themselves
/// @returns recordings in the order in which they are first mentioned
std::vector<RecordingParts> recordings_of(const std::vector<std::filesystem::path>& files);

/// The recordings of ROS in a folder, by name; folders in it are not looked into. The files that
/// its metadata.yaml names are all that counts, where there are any.
std::vector<RecordingParts> recordings_in(const std::filesystem::path& folder);

/// The files that a folder's metadata.yaml names, as far as they are there: packed or unpacked
/// since counts as well. Some: it is a folder of rosbag2.
RecordingParts parts_by_metadata(const std::filesystem::path& folder);

}  // namespace ros

/// @throws std::invalid_argument where a folder holds several recordings: which, and what to do
void require_one(const std::filesystem::path& folder,
                 const std::vector<RecordingParts>& recordings);

}  // namespace marco
