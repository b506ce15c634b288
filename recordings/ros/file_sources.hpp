#pragma once

#include <filesystem>
#include <memory>

#include "recordings/ros/chunk_merge.hpp"
#include "recordings/ros/message_source.hpp"

namespace marco::ros {

/// A bag of ROS 1, format 2.0 (chunks plain, bz2 or lz4). With its index the topics are known at
/// once and chunks without a wanted one are left unread. Without it (the recorder crashed) the file
/// is walked through; a chunk that is cut off gives what of it is whole, and after damage the walk
/// continues at the next chunk.
/// @throws std::invalid_argument for an encrypted bag, and one of a format before 2.0.
std::unique_ptr<MessageSource> open_bag(const std::filesystem::path& path,
                                        std::size_t most_held_bytes = kMostHeldBytes);

/// A database of rosbag2 (sqlite3), of any version of its tables. It is opened read-only and
/// immutable: nothing is written next to it. The contents of a `-wal` file next to it are not read,
/// which a note reports.
/// @throws std::invalid_argument where it is no such database.
std::unique_ptr<MessageSource> open_db3(const std::filesystem::path& path);

/// An MCAP file, with or without chunks (plain, lz4, zstd), index and summary. Files that are cut
/// off anywhere give what is whole, of the last chunk as far as it can be unpacked; after damage
/// reading continues at the next record. Checksums that are wrong are notes.
/// @throws std::invalid_argument where the file is no MCAP.
std::unique_ptr<MessageSource> open_mcap(const std::filesystem::path& path,
                                         std::size_t most_held_bytes = kMostHeldBytes);

}  // namespace marco::ros
