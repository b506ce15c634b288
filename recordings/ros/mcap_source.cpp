#include "recordings/ros/mcap_source.hpp"

#include <zlib.h>

#include <algorithm>
#include <memory>
#include <set>
#include <utility>

#include "lcm_tools/base/check.hpp"
#include "recordings/ros/compression.hpp"
#include "recordings/ros/mcap_layout.hpp"
#include "recordings/ros/wire_reader.hpp"

namespace marco::ros {
namespace {

class McapSource : public MessageSource {
 public:
  explicit McapSource(const std::filesystem::path& path)
      : path_(path.string()),
        file_(path),
        layout_(read_mcap_layout(file_, path_)),
        schemas_(layout_.schemas) {
    for (const auto& [id, channel] : layout_.channels) add_topic(channel);
    if (layout_.statistics) {
      for (const auto& [id, count] : layout_.statistics->by_channel) {
        if (const auto topic = topics_.find(id); topic != topics_.end()) {
          topic->second.messages = static_cast<int64_t>(count);
        }
      }
    }
    rewind();
  }

  std::string format() const override { return "MCAP"; }
  std::vector<std::string> paths() const override { return {path_}; }

  void select(std::function<bool(const Topic&)> is_wanted) override {
    is_wanted_ = std::move(is_wanted);
    rewind();
  }

  std::optional<Message> next() override {
    while (auto item = merge_->next()) {
      const auto topic = topics_.find(static_cast<uint16_t>(item->entry.topic));
      if (topic == topics_.end() || !is_wanted(topic->second)) continue;
      return Message{&topic->second, item->entry.received_ns, item->entry.published_ns,
                     unpacker_.message(item->bytes)};
    }
    return std::nullopt;
  }

  void rewind() override {
    damage_ = layout_.damage;
    counted_damage_.clear();
    used_.clear();
    std::vector<ChunkPlace> places;
    for (std::size_t i = 0; i < layout_.pieces.size(); ++i) {
      if (!may_have_wanted(layout_.pieces[i])) continue;
      used_.push_back(i);
      places.push_back(layout_.pieces[i].place);
    }
    merge_ = std::make_unique<ChunkMerge>(
        std::move(places),
        [this](std::size_t i, LoadedChunk memory) { return load(used_[i], std::move(memory)); });
  }

  std::optional<TimeSpan> span() const override { return span_of(layout_.pieces); }
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

  bool may_have_wanted(const McapLayout::Piece& piece) const {
    return piece.channels.empty() ||
           std::any_of(piece.channels.begin(), piece.channels.end(), [this](const auto& entry) {
             const auto topic = topics_.find(entry.first);
             return topic == topics_.end() || topic->second.type.empty() ||
                    is_wanted(topic->second);
           });
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

  LoadedChunk load(std::size_t index, LoadedChunk loaded) {
    const McapLayout::Piece& piece = layout_.pieces[index];
    loaded.entries.clear();
    const bool is_packed = piece.chunk && !piece.chunk->compression.empty();
    file_.read(piece.place.offset, piece.place.size, is_packed ? packed_ : loaded.bytes);
    if (piece.chunk && !unpack(index, *piece.chunk, loaded.bytes)) return loaded;
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

  // Without compression they are plain already.
  bool unpack(std::size_t index, const McapChunk& chunk, ByteBuffer& plain) {
    auto checksum = Unpacker::Checksum::none_wrong;
    try {
      require(chunk.plain_size <= kMostPlainBytes, "a chunk of more than 256 MB");
      if (!chunk.compression.empty()) {
        checksum = unpacker_.unpack(chunk.compression, packed_.bytes(), chunk.plain_size, plain);
      }
    } catch (const std::invalid_argument& fault) {
      note_damage(index, static_cast<std::size_t>(layout_.pieces[index].place.size));
      note_once(notes_, std::string("damaged chunks: ") + fault.what());
      return false;
    }
    if (plain.size() < chunk.plain_size) {
      note_damage(index, static_cast<std::size_t>(chunk.plain_size) - plain.size());
    } else if (checksum == Unpacker::Checksum::wrong ||
               (chunk.crc != 0 && chunk.crc != crc_of(plain.bytes()))) {
      note_once(notes_, note_of_checksum(layout_.pieces[index].place.offset));
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

  void note_damage(std::size_t index, std::size_t bytes) {
    if (!counted_damage_.insert(index).second) return;
    if (damage_.places++ == 0) damage_.first_offset = layout_.pieces[index].place.offset;
    damage_.bytes += static_cast<int64_t>(bytes);
  }

  std::string path_;
  ByteFile file_;
  McapLayout layout_;
  std::map<uint16_t, McapSchema> schemas_;
  std::map<uint16_t, Topic> topics_;  // nodes: messages point to them
  std::function<bool(const Topic&)> is_wanted_;
  Damage damage_;
  std::vector<std::string> notes_;
  std::set<std::size_t> counted_damage_;  // pieces
  std::vector<std::size_t> used_;         // pieces that are read
  Unpacker unpacker_;
  ByteBuffer packed_;
  std::unique_ptr<ChunkMerge> merge_;
};

}  // namespace

std::unique_ptr<MessageSource> open_mcap(const std::filesystem::path& path) {
  return std::make_unique<McapSource>(path);
}

}  // namespace marco::ros
