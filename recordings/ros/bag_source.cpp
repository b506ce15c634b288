#include "recordings/ros/file_sources.hpp"

#include <algorithm>
#include <utility>

#include "recordings/ros/bag_layout.hpp"
#include "recordings/ros/bag_records.hpp"
#include "recordings/ros/chunked_source.hpp"

namespace marco::ros {
namespace {

class BagSource : public ChunkedSource {
 public:
  BagSource(const std::filesystem::path& path, std::size_t most_held_bytes)
      : ChunkedSource(path, most_held_bytes), layout_(read_bag_layout(file_, path_)) {
    for (auto& [id, topic] : layout_.connections) set_topic(std::move(topic));
    layout_.connections.clear();
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
    return layout_.chunks[chunk].connections;
  }

  // Chunks of which no index tells the times. Connections stand in chunks: without the index of the
  // bag these are looked through once.
  void time_chunks() {
    if (layout_.is_indexed) return;
    for (std::size_t i = 0; i < layout_.chunks.size(); ++i) {
      ChunkPlace& place = places_[i];
      bool is_first = true;
      load(i, [&](const ChunkMessage& message) {
        const int64_t at_ns = message.received_ns;
        place.start_ns = is_first ? at_ns : std::min(place.start_ns, at_ns);
        place.end_ns = is_first ? at_ns : std::max(place.end_ns, at_ns);
        is_first = false;
      });
    }
  }

  void count_messages() {
    if (!layout_.is_indexed) return;
    for (auto& [id, topic] : topics_) {
      const auto count = layout_.counts.find(id);
      topic.messages = count == layout_.counts.end() ? 0 : count->second;
    }
  }

  void load(std::size_t index, const Keep& keep) override {
    const BagLayout::Chunk& chunk = layout_.chunks[index];
    const bool is_plain = chunk.compression == "none";
    const auto packed = static_cast<uint64_t>(places_[index].size);
    if (!open(index, chunk.compression, is_plain ? packed : chunk.plain_size)) return;
    uint64_t read = 0;
    while (read_record(keep)) read = window_.at();
    window_.skip(UINT64_MAX);
    if (unpacker_.checksum() == Unpacker::Checksum::wrong) note_wrong_checksum(index);
    if (read < std::max(window_.unpacked(), chunk.plain_size)) {
      note_damage(index, std::max(chunk.plain_size, read) - read);
    }
  }

  // @returns false at the end, and where no whole record stands
  bool read_record(const Keep& keep) {
    const auto seen = window_.peek(bag_head_bytes(window_.peek(4)));
    auto head = parse_bag_head(seen);
    if (!head) return false;
    const uint64_t size = uint64_t{head->size} + head->data_size;
    const auto id = head->fields.u32("conn");
    const bool is_read = id && (head->op == BagOp::message
                                    ? is_needed(*id)
                                    : head->op == BagOp::connection && !topics_.contains(*id));
    if (!is_read) return window_.skip(size);
    if (size > kMostMessageBytes) return leave_out(size);
    const auto record = window_.peek(size);
    if (record.size() < size) return false;
    if (record.data() != seen.data()) head = parse_bag_head(record);
    take(*head, *id, record.subspan(head->size, head->data_size), keep);
    return window_.skip(size);
  }

  void take(const BagRecordHead& head,
            uint32_t id,
            std::span<const uint8_t> data,
            const Keep& keep) {
    if (head.op == BagOp::connection) {
      auto topic = topic_of(id, head.fields.text("topic"), data);
      if (topic) set_topic(std::move(*topic));
    } else if (const auto time_ns = head.fields.time_ns("time")) {
      keep({*time_ns, *time_ns, id, data});
    }
  }

  BagLayout layout_;
};

}  // namespace

std::unique_ptr<MessageSource> open_bag(const std::filesystem::path& path,
                                        std::size_t most_held_bytes) {
  return std::make_unique<BagSource>(path, most_held_bytes);
}

}  // namespace marco::ros
