#include "recordings/ros/mcap_records.hpp"

#include "recordings/ros/wire_reader.hpp"

namespace marco::ros {
namespace {

std::string text_of(std::span<const uint8_t> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

int64_t time_ns(McapFields& fields) { return static_cast<int64_t>(fields.u64()); }

}  // namespace

std::span<const uint8_t> McapFields::take(uint64_t size) {
  if (size > bytes_.size()) throw WireError("a record ends too early");
  const auto taken = bytes_.first(static_cast<std::size_t>(size));
  bytes_ = bytes_.subspan(taken.size());
  return taken;
}

std::string McapFields::text() { return text_of(short_blob()); }

std::map<std::string, std::string> McapFields::text_map() {
  std::map<std::string, std::string> map;
  McapFields pairs(short_blob());
  while (!pairs.rest().empty()) {
    std::string key = pairs.text();
    map[std::move(key)] = pairs.text();
  }
  return map;
}

std::map<uint16_t, uint64_t> McapFields::count_map() {
  std::map<uint16_t, uint64_t> map;
  McapFields pairs(short_blob());
  while (!pairs.rest().empty()) {
    const uint16_t key = pairs.u16();
    map[key] = pairs.u64();
  }
  return map;
}

McapSchema parse_schema(McapFields fields) {
  McapSchema schema;
  schema.id = fields.u16();
  schema.name = fields.text();
  schema.encoding = fields.text();
  schema.data = text_of(fields.short_blob());
  return schema;
}

McapChannel parse_channel(McapFields fields) {
  McapChannel channel;
  channel.id = fields.u16();
  channel.schema_id = fields.u16();
  channel.topic = fields.text();
  channel.encoding = fields.text();
  channel.metadata = fields.text_map();
  return channel;
}

McapMessage parse_message(McapFields fields) {
  McapMessage message;
  message.channel = fields.u16();
  message.sequence = fields.u32();
  message.log_ns = time_ns(fields);
  message.publish_ns = time_ns(fields);
  message.data = fields.rest();
  return message;
}

McapChunk parse_chunk(std::span<const uint8_t> bytes) {
  McapFields fields(bytes);
  McapChunk chunk;
  chunk.start_ns = time_ns(fields);
  chunk.end_ns = time_ns(fields);
  chunk.plain_size = fields.u64();
  chunk.crc = fields.u32();
  chunk.compression = fields.text();
  chunk.size = fields.u64();
  chunk.head = bytes.size() - fields.rest().size();
  return chunk;
}

McapChunkIndex parse_chunk_index(McapFields fields) {
  McapChunkIndex index;
  for (int i = 0; i < 2; ++i) fields.u64();  // first and last time
  index.offset = fields.u64();
  fields.u64();  // the chunk's length
  McapFields offsets(fields.short_blob());
  while (!offsets.rest().empty()) {
    index.channels.push_back(offsets.u16());
    offsets.u64();
  }
  index.channels.shrink_to_fit();
  return index;
}

McapStatistics parse_statistics(McapFields fields) {
  McapStatistics statistics;
  statistics.messages = fields.u64();
  fields.u16();                              // schemas
  for (int i = 0; i < 4; ++i) fields.u32();  // channels, attachments, metadata, chunks
  for (int i = 0; i < 2; ++i) fields.u64();  // first and last time
  statistics.by_channel = fields.count_map();
  return statistics;
}

}  // namespace marco::ros
