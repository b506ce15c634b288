#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "recordings/ros/byte_buffer.hpp"
#include "recordings/ros/byte_file.hpp"
#include "recordings/ros/chunk_merge.hpp"
#include "recordings/ros/compression.hpp"
#include "recordings/ros/message_source.hpp"

namespace marco::ros {

/// A window on the plain bytes of a chunk, which moves from the first to the last. It is as wide as
/// what is looked at. Not safe for threads.
class PlainWindow {
 public:
  /// On the chunk that the unpacker has begun, and that it has to keep until the window's next one.
  /// @param with_crc  whether crc() will be asked for
  void begin(Unpacker& unpacker, bool with_crc);

  /// The next bytes, `count` of them and maybe more; fewer at the end alone. Valid until the next
  /// call.
  std::span<const uint8_t> peek(std::size_t count) {
    if (count > held_) fill(count);
    return buffer_.bytes().subspan(from_, held_);
  }
  /// @returns false where there are fewer: the window is at the end then.
  bool skip(uint64_t count);

  /// Bytes that were passed, and those that were unpacked so far.
  uint64_t at() const { return unpacked_ - held_; }
  uint64_t unpacked() const { return unpacked_; }
  /// Of the unpacked ones, as MCAP has it.
  uint32_t crc() const { return crc_; }

 private:
  void fill(std::size_t count);
  std::size_t unpack(std::span<uint8_t> into);

  Unpacker* unpacker_ = nullptr;
  ByteBuffer buffer_;
  std::size_t from_ = 0, held_ = 0;
  uint64_t unpacked_ = 0;
  bool with_crc_ = false;
  uint32_t crc_ = 0;
};

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
  using Keep = ChunkMerge::Keep;

  /// @throws std::runtime_error where the file cannot be opened
  ChunkedSource(const std::filesystem::path& path, std::size_t most_held_bytes)
      : path_(path.string()), file_(path), most_held_bytes_(most_held_bytes) {}

  /// @param damage  between chunks
  void set_chunks(std::vector<ChunkPlace> places, const Damage& damage);

  /// Gives each message of a chunk that is_needed() to `keep`, in the order of the file.
  /// @throws std::invalid_argument see count_topic_bytes.
  virtual void load(std::size_t chunk, const Keep& keep) = 0;
  /// Topics that the chunk may have; empty: not known.
  virtual std::vector<uint32_t> topics_in(std::size_t chunk) const = 0;
  /// A message's own bytes.
  virtual std::span<const uint8_t> plain(std::span<const uint8_t> message) { return message; }

  /// Whether messages of a topic are wanted, or may be: it is not known yet.
  bool is_needed(uint32_t topic) const;
  /// Adds a topic, or replaces one.
  void set_topic(Topic topic);
  /// @throws std::invalid_argument once they are more than kMostTopicBytes.
  void count_topic_bytes(std::size_t bytes);

  /// Once for each chunk and reading. A chunk that is lost is noted with the reason.
  void note_damage(std::size_t chunk, uint64_t bytes);
  void note_lost(std::size_t chunk, const std::string& why);
  /// Puts the window on the chunk's first plain byte. @returns false where it cannot be unpacked:
  /// that is noted as damage.
  bool open(std::size_t chunk,
            const std::string& compression,
            uint64_t plain_size,
            bool with_crc = false);
  /// Passes a record of more than kMostMessageBytes, with a note. @returns false where it ends
  /// early
  bool leave_out(uint64_t record_bytes);
  void note_wrong_checksum(std::size_t chunk) {
    note_once(notes_, note_of_checksum(places_[chunk].offset));
  }

  std::string path_;
  ByteFile file_;
  Unpacker unpacker_;
  PlainWindow window_;
  std::map<uint32_t, Topic> topics_;  ///< nodes: messages point to them
  std::vector<ChunkPlace> places_;
  Damage damage_;
  std::vector<std::string> notes_;

 private:
  bool may_have_wanted(std::size_t chunk) const;
  bool is_wanted(const Topic& topic) const { return !is_wanted_ || is_wanted_(topic); }

  std::size_t most_held_bytes_;
  ByteStream packed_;
  Damage damage_between_;
  std::function<bool(const Topic&)> is_wanted_;
  mutable std::optional<std::pair<uint32_t, bool>> asked_;  // of is_needed(), last
  std::size_t topic_bytes_ = 0;
  std::set<std::size_t> counted_damage_;  // chunks
  std::unique_ptr<ChunkMerge> merge_;
};

}  // namespace marco::ros
