#include "recordings/ros/bag_source.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include "recordings/ros/bag_layout.hpp"
#include "recordings/ros/bag_records.hpp"
#include "recordings/ros/chunk_merge.hpp"
#include "recordings/ros/compression.hpp"

namespace marco::ros {
namespace {

class BagSource : public MessageSource {
 public:
  explicit BagSource(const std::filesystem::path& path)
      : path_(path.string()),
        file_(path),
        layout_(read_bag_layout(file_, path_)),
        topics_(layout_.connections),
        damage_(layout_.damage),
        notes_(layout_.notes) {
    time_chunks();
    count_messages();
    rewind();
  }

  std::string format() const override { return "ROS bag"; }
  std::vector<std::string> paths() const override { return {path_}; }

  void select(std::function<bool(const Topic&)> is_wanted) override {
    is_wanted_ = std::move(is_wanted);
    rewind();
  }

  std::optional<Message> next() override {
    while (auto item = merge_->next()) {
      const auto topic = topics_.find(item->entry.topic);
      if (topic == topics_.end() || !is_wanted(topic->second)) continue;
      return Message{&topic->second, item->entry.received_ns, item->entry.received_ns, item->bytes};
    }
    return std::nullopt;
  }

  void rewind() override {
    damage_ = layout_.damage;
    counted_damage_.clear();
    used_.clear();
    std::vector<ChunkPlace> places;
    for (std::size_t i = 0; i < layout_.chunks.size(); ++i) {
      if (!may_have_wanted(layout_.chunks[i])) continue;
      used_.push_back(i);
      places.push_back(layout_.chunks[i].place);
    }
    merge_ = std::make_unique<ChunkMerge>(
        std::move(places),
        [this](std::size_t i, LoadedChunk memory) { return load(used_[i], std::move(memory)); });
  }

  std::optional<TimeSpan> span() const override { return span_of(layout_.chunks); }
  std::vector<const Topic*> topics() const override {
    std::vector<const Topic*> topics;
    for (const auto& [id, topic] : topics_) topics.push_back(&topic);
    return topics;
  }
  const Damage& damage() const override { return damage_; }
  const std::vector<std::string>& notes() const override { return notes_; }
  double progress() const override { return merge_->progress(); }

 private:
  bool is_wanted(const Topic& topic) const { return !is_wanted_ || is_wanted_(topic); }

  // A chunk whose connections are not all known has to be looked into.
  bool may_have_wanted(const BagLayout::Chunk& chunk) const {
    return chunk.counts.empty() ||
           std::any_of(chunk.counts.begin(), chunk.counts.end(), [this](const auto& count) {
             const auto topic = topics_.find(count.first);
             return topic == topics_.end() || is_wanted(topic->second);
           });
  }

  // Chunks of which no index tells the times.
  void time_chunks() {
    if (layout_.is_indexed) return;
    // Connections stand in chunks: without the index of the bag these are looked through once.
    LoadedChunk loaded;
    for (std::size_t i = 0; i < layout_.chunks.size(); ++i) {
      loaded = load(i, std::move(loaded));
      for (const auto& entry : loaded.entries) {
        const bool is_first = &entry == &loaded.entries.front();
        ChunkPlace& place = layout_.chunks[i].place;
        place.start_ns = is_first ? entry.received_ns : std::min(place.start_ns, entry.received_ns);
        place.end_ns = is_first ? entry.received_ns : std::max(place.end_ns, entry.received_ns);
      }
    }
  }

  void count_messages() {
    if (!layout_.is_indexed) return;
    for (auto& [id, topic] : topics_) topic.messages = 0;
    for (const BagLayout::Chunk& chunk : layout_.chunks) {
      for (const auto& [id, count] : chunk.counts) {
        if (const auto topic = topics_.find(id); topic != topics_.end()) {
          topic->second.messages += count;
        }
      }
    }
  }

  LoadedChunk load(std::size_t index, LoadedChunk loaded) {
    const BagLayout::Chunk& chunk = layout_.chunks[index];
    loaded.entries.clear();
    if (chunk.compression == "none") {
      file_.read(chunk.place.offset, chunk.place.size, loaded.bytes);
    } else if (!unpack(index, loaded.bytes)) {
      return loaded;
    }
    std::size_t at = 0;
    while (at < loaded.bytes.size()) {
      const auto record = parse_bag_record(loaded.bytes.bytes().subspan(at));
      if (!record) break;
      take(*record, loaded);
      at += record->size;
    }
    if (at < loaded.bytes.size() || loaded.bytes.size() < chunk.plain_size) {
      note_damage(index, static_cast<int64_t>(std::max<uint64_t>(chunk.plain_size, at) - at));
    }
    return loaded;
  }

  bool unpack(std::size_t index, ByteBuffer& plain) {
    const BagLayout::Chunk& chunk = layout_.chunks[index];
    file_.read(chunk.place.offset, chunk.place.size, packed_);
    try {
      const auto checksum =
          unpacker_.unpack(chunk.compression, packed_.bytes(), chunk.plain_size, plain);
      if (checksum == Unpacker::Checksum::wrong) {
        note_once(notes_, note_of_checksum(chunk.place.offset));
      }
      return true;
    } catch (const std::invalid_argument& fault) {
      note_damage(index, chunk.place.size);
      note_once(notes_, std::string("damaged chunks: ") + fault.what());
      return false;
    }
  }

  void take(const BagRecord& record, LoadedChunk& loaded) {
    const auto id = record.header.u32("conn");
    if (!id) return;
    if (record.op == BagOp::connection) {
      if (topics_.contains(*id)) return;
      if (auto topic = topic_of(*id, record.header.text("topic"), record.data)) {
        topics_.emplace(*id, std::move(*topic));
      }
    } else if (const auto time_ns = record.header.time_ns("time");
               record.op == BagOp::message && time_ns) {
      const auto offset =
          static_cast<std::size_t>(record.data.data() - loaded.bytes.bytes().data());
      loaded.entries.push_back({*time_ns, *time_ns, *id, offset, record.data.size()});
    }
  }

  void note_damage(std::size_t index, int64_t bytes) {
    if (!counted_damage_.insert(index).second) return;
    const int64_t offset = layout_.chunks[index].place.offset;
    if (damage_.places++ == 0) damage_.first_offset = offset;
    damage_.bytes += bytes;
  }

  std::string path_;
  ByteFile file_;
  BagLayout layout_;
  Unpacker unpacker_;
  ByteBuffer packed_;
  std::map<uint32_t, Topic> topics_;  // nodes: messages point to them
  std::function<bool(const Topic&)> is_wanted_;
  Damage damage_;
  std::vector<std::string> notes_;
  std::set<std::size_t> counted_damage_;  // chunks
  std::vector<std::size_t> used_;         // chunks that are read
  std::unique_ptr<ChunkMerge> merge_;
};

}  // namespace

std::unique_ptr<MessageSource> open_bag(const std::filesystem::path& path) {
  return std::make_unique<BagSource>(path);
}

}  // namespace marco::ros
