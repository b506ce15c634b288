#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "recordings/ros/byte_file.hpp"
#include "recordings/ros/chunk_merge.hpp"
#include "recordings/ros/compression.hpp"
#include "recordings/ros/message_source.hpp"

namespace marco::ros {

/// A file whose messages stand in chunks, which may be compressed and overlap in time: what ROS
/// bags and MCAP share. What derives from it lays out the file in its constructor, calls
/// set_chunks() and rewind(), and loads chunks.
class ChunkedSource : public MessageSource {
 public:
  std::vector<std::string> paths() const override { return {path_}; }
  void select(std::function<bool(const Topic&)> is_wanted) override;
  std::optional<Message> next() override;
  void rewind() override;
  std::optional<TimeSpan> span() const override;
  std::vector<const Topic*> topics() const override;
  const Damage& damage() const override { return damage_; }
  const std::vector<std::string>& notes() const override { return notes_; }
  double progress() const override { return merge_->progress(); }

 protected:
  /// @throws std::runtime_error where the file cannot be opened
  explicit ChunkedSource(const std::filesystem::path& path) : path_(path.string()), file_(path) {}

  /// @param damage  between chunks
  void set_chunks(std::vector<ChunkPlace> places, const Damage& damage);

  /// The messages of a chunk, in the memory of one that was read to its end.
  virtual LoadedChunk load(std::size_t chunk, LoadedChunk memory) = 0;
  /// Topics that the chunk may have; empty: not known.
  virtual std::vector<uint32_t> topics_in(std::size_t chunk) const = 0;
  /// A message's own bytes.
  virtual std::span<const uint8_t> plain(std::span<const uint8_t> message) { return message; }

  /// Once for each chunk and reading. A chunk that is lost is noted with the reason.
  void note_damage(std::size_t chunk, uint64_t bytes);
  void note_lost(std::size_t chunk, const std::string& why);
  /// Reads the chunk and unpacks it, see Unpacker. @returns nothing where it cannot be: that is
  /// noted as damage.
  std::optional<Unpacker::Checksum> unpack(std::size_t chunk,
                                           const std::string& compression,
                                           uint64_t plain_size,
                                           ByteBuffer& plain);
  void note_wrong_checksum(std::size_t chunk) {
    note_once(notes_, note_of_checksum(places_[chunk].offset));
  }

  std::string path_;
  ByteFile file_;
  Unpacker unpacker_;
  std::map<uint32_t, Topic> topics_;  ///< nodes: messages point to them
  std::vector<ChunkPlace> places_;
  Damage damage_;
  std::vector<std::string> notes_;

 private:
  bool may_have_wanted(std::size_t chunk) const;
  bool is_wanted(const Topic& topic) const { return !is_wanted_ || is_wanted_(topic); }

  ByteBuffer packed_;
  Damage damage_between_;
  std::function<bool(const Topic&)> is_wanted_;
  std::set<std::size_t> counted_damage_;  // chunks
  std::vector<std::size_t> used_;         // chunks that are read
  std::unique_ptr<ChunkMerge> merge_;
};

}  // namespace marco::ros
