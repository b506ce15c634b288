#include "recordings/ros/mcap_source.hpp"

#include <zlib.h>

#include <algorithm>
#include <utility>

#include "recordings/ros/chunked_source.hpp"
#include "recordings/ros/mcap_layout.hpp"
#include "recordings/ros/wire_reader.hpp"

namespace marco::ros {
namespace {

class McapSource : public ChunkedSource {
 public:
  explicit McapSource(const std::filesystem::path& path)
      : ChunkedSource(path), layout_(read_mcap_layout(file_, path_)), schemas_(layout_.schemas) {
    for (const auto& [id, channel] : layout_.channels) add_topic(channel);
    if (layout_.statistics) {
      for (const auto& [id, count] : layout_.statistics->by_channel) {
        if (const auto topic = topics_.find(id); topic != topics_.end()) {
          topic->second.messages = static_cast<int64_t>(count);
        }
      }
    }
    std::vector<ChunkPlace> places;
    for (const McapLayout::Piece& piece : layout_.pieces) places.push_back(piece.place);
    set_chunks(std::move(places), layout_.damage);
    rewind();
  }

  std::string format() const override { return "MCAP"; }

 private:
  std::vector<uint32_t> topics_in(std::size_t chunk) const override {
    std::vector<uint32_t> ids;
    for (const auto& [id, offset] : layout_.pieces[chunk].channels) ids.push_back(id);
    return ids;
  }

  std::span<const uint8_t> plain(std::span<const uint8_t> message) override {
    return unpacker_.message(message);
  }

  void add_topic(const McapChannel& channel) {
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
    // The summary may repeat a channel whose schema stands in a chunk.
    const auto [known, is_new] = topics_.try_emplace(channel.id, topic);
    if (is_new || !known->second.type.empty()) return;
    topic.messages = known->second.messages;
    known->second = std::move(topic);
  }

  LoadedChunk load(std::size_t index, LoadedChunk loaded) override {
    const McapLayout::Piece& piece = layout_.pieces[index];
    loaded.entries.clear();
    if (!read(index, piece, loaded.bytes)) return loaded;
    std::size_t at = 0;
    while (loaded.bytes.size() - at >= kMcapRecordHead) {
      const std::span<const uint8_t> rest = loaded.bytes.bytes().subspan(at);
      const uint64_t length = McapFields(rest.subspan(1)).u64();
      if (length > rest.size() - kMcapRecordHead) break;
      const auto content = rest.subspan(kMcapRecordHead, static_cast<std::size_t>(length));
      take(static_cast<McapOp>(rest[0]), content, loaded);
      at += kMcapRecordHead + content.size();
    }
    if (at < loaded.bytes.size()) note_damage(index, loaded.bytes.size() - at);
    return loaded;
  }

  bool read(std::size_t index, const McapLayout::Piece& piece, ByteBuffer& plain) {
    if (piece.chunk && piece.chunk->plain_size > kMostPlainBytes) {
      note_lost(index, "a chunk of more than 256 MB");
      return false;
    }
    auto checksum = Unpacker::Checksum::none_wrong;
    if (!piece.chunk || piece.chunk->compression.empty()) {
      file_.read(places_[index].offset, places_[index].size, plain);
    } else {
      const auto unpacked = unpack(index, piece.chunk->compression, piece.chunk->plain_size, plain);
      if (!unpacked) return false;
      checksum = *unpacked;
    }
    if (!piece.chunk) return true;
    const McapChunk& chunk = *piece.chunk;
    if (plain.size() < chunk.plain_size) {
      note_damage(index, chunk.plain_size - plain.size());
    } else if (checksum == Unpacker::Checksum::wrong ||
               (chunk.crc != 0 && chunk.crc != crc_of(plain.bytes()))) {
      note_wrong_checksum(index);
    }
    return true;
  }

  static uint32_t crc_of(std::span<const uint8_t> bytes) {
    return static_cast<uint32_t>(::crc32_z(0, bytes.data(), static_cast<z_size_t>(bytes.size())));
  }

  void take(McapOp op, std::span<const uint8_t> content, LoadedChunk& loaded) {
    try {
      if (op == McapOp::message) {
        const McapMessage message = parse_message(McapFields(content));
        const auto offset =
            static_cast<std::size_t>(message.data.data() - loaded.bytes.bytes().data());
        loaded.entries.push_back(
            {message.log_ns, message.publish_ns, message.channel, offset, message.data.size()});
      } else if (op == McapOp::schema) {
        McapSchema schema = parse_schema(McapFields(content));
        schemas_.try_emplace(schema.id, std::move(schema));
      } else if (op == McapOp::channel) {
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

std::unique_ptr<MessageSource> open_mcap(const std::filesystem::path& path) {
  return std::make_unique<McapSource>(path);
}

}  // namespace marco::ros
