#pragma once

#include <filesystem>
#include <memory>

#include "recordings/ros/chunk_merge.hpp"
#include "recordings/ros/message_source.hpp"

namespace marco::ros {

/// An MCAP file, with or without chunks (plain, lz4, zstd), index and summary. Files that are cut
/// off anywhere give what is whole, of the last chunk as far as it can be unpacked; after damage
/// reading continues at the next record. Checksums that are wrong are notes.
/// @throws std::invalid_argument where the file is no MCAP.
std::unique_ptr<MessageSource> open_mcap(const std::filesystem::path& path,
                                         std::size_t most_held_bytes = kMostHeldBytes);

}  // namespace marco::ros
