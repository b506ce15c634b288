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

}  // namespace marco::ros
