#include "recordings/ros/bag_source.hpp"

#include <algorithm>
#include <utility>

#include "recordings/ros/bag_layout.hpp"
#include "recordings/ros/bag_records.hpp"
#include "recordings/ros/chunked_source.hpp"

namespace marco::ros {
namespace {

class BagSource : public ChunkedSource {
 public:
  explicit BagSource(const std::filesystem::path& path)
      : ChunkedSource(path), layout_(read_bag_layout(file_, path_)) {
    topics_ = layout_.connections;
    notes_ = layout_.notes;
    std::vector<ChunkPlace> places;
    for (const BagLayout::Chunk& chunk : layout_.chunks) places.push_back(chunk.place);
    set_chunks(std::move(places), layout_.damage);
    time_chunks();
    count_messages();
    rewind();
  }

  std::string format() const override { return "ROS bag"; }

 private:
  std::vector<uint32_t> topics_in(std::size_t chunk) const override {
    std::vector<uint32_t> ids;
    for (const auto& [id, count] : layout_.chunks[chunk].counts) ids.push_back(id);
    return ids;
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
        ChunkPlace& place = places_[i];
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

  LoadedChunk load(std::size_t index, LoadedChunk loaded) override {
    const BagLayout::Chunk& chunk = layout_.chunks[index];
    loaded.entries.clear();
    if (chunk.compression == "none") {
      file_.read(places_[index].offset, places_[index].size, loaded.bytes);
    } else {
      const auto checksum = unpack(index, chunk.compression, chunk.plain_size, loaded.bytes);
      if (!checksum) return loaded;
      if (*checksum == Unpacker::Checksum::wrong) note_wrong_checksum(index);
    }
    std::size_t at = 0;
    while (at < loaded.bytes.size()) {
      const auto record = parse_bag_record(loaded.bytes.bytes().subspan(at));
      if (!record) break;
      take(*record, loaded);
      at += record->size;
    }
    if (at < loaded.bytes.size() || loaded.bytes.size() < chunk.plain_size) {
      note_damage(index, std::max<uint64_t>(chunk.plain_size, at) - at);
    }
    return loaded;
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

  BagLayout layout_;
};

}  // namespace

std::unique_ptr<MessageSource> open_bag(const std::filesystem::path& path) {
  return std::make_unique<BagSource>(path);
}

}  // namespace marco::ros
