#include "recordings/ros/file_sources.hpp"

#include <algorithm>
#include <utility>

#include "recordings/ros/chunked_source.hpp"
#include "recordings/ros/mcap_layout.hpp"
#include "recordings/ros/wire_reader.hpp"

namespace marco::ros {
namespace {

class McapSource : public ChunkedSource {
 public:
  McapSource(const std::filesystem::path& path, std::size_t most_held_bytes)
      : ChunkedSource(path, most_held_bytes), layout_(read_mcap_layout(file_, path_)) {
    for (auto& [id, schema] : layout_.schemas) add_schema(std::move(schema));
    for (const auto& [id, channel] : layout_.channels) add_topic(channel);
    layout_.schemas.clear();
    layout_.channels.clear();
    if (layout_.statistics) {
      for (const auto& [id, count] : layout_.statistics->by_channel) {
        if (const auto topic = topics_.find(id); topic != topics_.end()) {
          topic->second.messages = static_cast<int64_t>(count);
        }
      }
    }
    set_chunks(std::move(layout_.places), layout_.damage);
    rewind();
  }

  std::string format() const override { return "MCAP"; }

 private:
  std::vector<uint32_t> topics_in(std::size_t chunk) const override {
    const std::vector<uint16_t>& channels = layout_.pieces[chunk].channels;
    return {channels.begin(), channels.end()};
  }

  std::span<const uint8_t> plain(std::span<const uint8_t> message) override {
    return unpacker_.message(message);
  }

  void add_schema(McapSchema schema) {
    if (schemas_.contains(schema.id)) return;
    count_topic_bytes(sizeof schema + schema.name.size() + schema.data.size());
    schemas_.emplace(schema.id, std::move(schema));
  }

  // The summary may repeat a channel whose schema stands in a chunk.
  bool is_known(uint16_t channel) const {
    const auto topic = topics_.find(channel);
    return topic != topics_.end() && !topic->second.type.empty();
  }

  void add_topic(const McapChannel& channel) {
    if (is_known(channel.id)) return;
    Topic topic;
    topic.id = channel.id;
    topic.name = channel.topic;
    topic.encoding = channel.encoding;
    topic.metadata = channel.metadata;
    if (const auto schema = schemas_.find(channel.schema_id);
        channel.schema_id != 0 && schema != schemas_.end()) {
      topic.type = plain_type(schema->second.name);
      topic.schema_encoding = schema->second.encoding;
      topic.schema = schema->second.data;
    }
    if (const auto md5 = channel.metadata.find("md5sum"); md5 != channel.metadata.end()) {
      topic.md5 = md5->second;
    }
    const auto latching = channel.metadata.find("latching");
    const auto qos = channel.metadata.find("offered_qos_profiles");
    topic.is_latched =
        (latching != channel.metadata.end() && latching->second == "1") ||
        (qos != channel.metadata.end() && qos->second.find("transient_local") != std::string::npos);
    const auto before = topics_.find(channel.id);
    if (before != topics_.end()) topic.messages = before->second.messages;
    set_topic(std::move(topic));
  }

  void load(std::size_t index, const Keep& keep) override {
    const McapLayout::Piece& piece = layout_.pieces[index];
    const std::string compression = piece.is_chunk ? layout_.compressions[piece.compression] : "";
    const auto packed = static_cast<uint64_t>(places_[index].size);
    if (!open(index, compression, compression.empty() ? packed : piece.plain_size,
              piece.crc != 0)) {
      return;
    }
    uint64_t read = 0;
    while (read_record(keep)) read = window_.at();
    window_.skip(UINT64_MAX);
    note_faults(index, piece, read);
  }

  // @returns false at the end, and where no whole record stands
  bool read_record(const Keep& keep) {
    const auto head = window_.peek(kMcapRecordHead + kMcapMessageHead);
    if (head.size() < kMcapRecordHead) return false;
    const uint64_t length = McapFields(head.subspan(1)).u64();
    const uint64_t size = kMcapRecordHead + length;
    if (size < length) return false;
    if (!is_read(static_cast<McapOp>(head[0]), head.subspan(kMcapRecordHead))) {
      return window_.skip(size);
    }
    if (size > kMostMessageBytes) return leave_out(size);
    const auto record = window_.peek(size);
    if (record.size() < size) return false;
    take(static_cast<McapOp>(record[0]), record.subspan(kMcapRecordHead, length), keep);
    return window_.skip(size);
  }

  // @param content  the first bytes. Those of each kind begin with the number of a channel or
  // schema.
  bool is_read(McapOp op, std::span<const uint8_t> content) const {
    const bool is_of_us = op == McapOp::message || op == McapOp::schema || op == McapOp::channel;
    if (!is_of_us || content.size() < sizeof(uint16_t)) return is_of_us;
    const uint16_t id = McapFields(content).u16();
    if (op == McapOp::message) return is_needed(id);
    return op == McapOp::schema ? !schemas_.contains(id) : !is_known(id);
  }

  // @param read  bytes of whole records
  void note_faults(std::size_t index, const McapLayout::Piece& piece, uint64_t read) {
    const uint64_t unpacked = window_.unpacked();
    if (piece.is_chunk && unpacked < piece.plain_size) {
      note_damage(index, piece.plain_size - unpacked);
    } else if (unpacker_.checksum() == Unpacker::Checksum::wrong ||
               (piece.crc != 0 && piece.crc != window_.crc())) {
      note_wrong_checksum(index);
    }
    if (read < unpacked) note_damage(index, unpacked - read);
  }

  void take(McapOp op, std::span<const uint8_t> content, const Keep& keep) {
    try {
      if (op == McapOp::message) {
        const McapMessage message = parse_message(McapFields(content));
        keep({message.log_ns, message.publish_ns, message.channel, message.data});
      } else if (op == McapOp::schema) {
        add_schema(parse_schema(McapFields(content)));
      } else {
        add_topic(parse_channel(McapFields(content)));
      }
    } catch (const WireError&) {  // its length was whole, its fields are not
      ++damage_.places;
    }
  }

  McapLayout layout_;
  std::map<uint16_t, McapSchema> schemas_;
};

}  // namespace

std::unique_ptr<MessageSource> open_mcap(const std::filesystem::path& path,
                                         std::size_t most_held_bytes) {
  return std::make_unique<McapSource>(path, most_held_bytes);
}

}  // namespace marco::ros
