#include "lcm_tools/log/mcap_writer.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>

namespace marco::logs {
namespace {

constexpr std::string_view kMagic("\x89MCAP0\r\n", 8);
constexpr std::size_t kChunkBytes = 1 << 20;

enum Opcode : uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kStatistics = 0x0B,
  kSummaryOffset = 0x0E,
  kDataEnd = 0x0F
};

template <class Int>
void put(std::string& to, Int value) {
  for (std::size_t i = 0; i < sizeof(Int); ++i) {
    to += static_cast<char>(static_cast<uint64_t>(value) >> (8 * i));
  }
}

void put_text(std::string& to, std::string_view text) {
  put(to, static_cast<uint32_t>(text.size()));
  to += text;
}

std::string record(Opcode opcode, std::string_view content) {
  std::string bytes;
  bytes.reserve(9 + content.size());
  put(bytes, static_cast<uint8_t>(opcode));
  put(bytes, static_cast<uint64_t>(content.size()));
  bytes += content;
  return bytes;
}

// Eight tables, so that eight bytes are taken a step ("slicing by 8").
using CrcTables = std::array<std::array<uint32_t, 256>, 8>;

CrcTables make_crc_tables() {
  CrcTables tables{};
  for (uint32_t i = 0; i < 256; ++i) {
    uint32_t value = i;
    for (int bit = 0; bit < 8; ++bit) {
      value = (value & 1U) != 0 ? (value >> 1U) ^ 0xEDB88320U : value >> 1U;
    }
    tables[0][i] = value;
  }
  for (uint32_t i = 0; i < 256; ++i) {
    for (std::size_t t = 1; t < 8; ++t) {
      tables[t][i] = (tables[t - 1][i] >> 8U) ^ tables[0][tables[t - 1][i] & 0xFFU];
    }
  }
  return tables;
}

}  // namespace

uint32_t crc32(std::string_view bytes, uint32_t before) {
  static const CrcTables tables = make_crc_tables();
  uint32_t crc = ~before;
  const auto* at = reinterpret_cast<const uint8_t*>(bytes.data());
  std::size_t left = bytes.size();
  for (; left >= 8; left -= 8, at += 8) {
    const uint32_t low =
        crc ^ (static_cast<uint32_t>(at[0]) | static_cast<uint32_t>(at[1]) << 8U |
               static_cast<uint32_t>(at[2]) << 16U | static_cast<uint32_t>(at[3]) << 24U);
    crc = tables[7][low & 0xFFU] ^ tables[6][(low >> 8U) & 0xFFU] ^
          tables[5][(low >> 16U) & 0xFFU] ^ tables[4][low >> 24U] ^ tables[3][at[4]] ^
          tables[2][at[5]] ^ tables[1][at[6]] ^ tables[0][at[7]];
  }
  for (; left > 0; --left, ++at) crc = (crc >> 8U) ^ tables[0][(crc ^ *at) & 0xFFU];
  return ~crc;
}

McapWriter::McapWriter(OutputFile& out) : out_(out) {
  std::string header;
  put_text(header, "");
  put_text(header, "marco-log");
  emit(kMagic);
  emit(record(kHeader, header));
}

void McapWriter::emit(std::string_view bytes) {
  written_crc_ = crc32(bytes, written_crc_);
  out_.write(bytes);
}

uint16_t McapWriter::add_schema(std::string_view name,
                                std::string_view encoding,
                                std::string_view data) {
  if (schemas_.size() >= UINT16_MAX) throw std::runtime_error("MCAP: more than 65535 schemas");
  const auto id = static_cast<uint16_t>(schemas_.size() + 1);
  std::string content;
  put(content, id);
  put_text(content, name);
  put_text(content, encoding);
  put_text(content, data);
  schemas_.push_back(record(kSchema, content));
  chunk_ += schemas_.back();
  return id;
}

uint16_t McapWriter::add_channel(uint16_t schema,
                                 std::string_view topic,
                                 std::string_view encoding,
                                 const std::map<std::string, std::string>& metadata) {
  if (channels_.size() >= UINT16_MAX) throw std::runtime_error("MCAP: more than 65535 channels");
  const auto id = static_cast<uint16_t>(channels_.size() + 1);
  std::string content, pairs;
  put(content, id);
  put(content, schema);
  put_text(content, topic);
  put_text(content, encoding);
  for (const auto& [key, value] : metadata) {
    put_text(pairs, key);
    put_text(pairs, value);
  }
  put_text(content, pairs);
  channels_.push_back(record(kChannel, content));
  chunk_ += channels_.back();
  return id;
}

void McapWriter::write(uint16_t channel,
                       uint32_t sequence,
                       uint64_t time_ns,
                       std::string_view data) {
  constexpr uint64_t kFixedBytes = 2 + 4 + 8 + 8;
  chunk_index_[channel].emplace_back(time_ns, chunk_.size());
  put(chunk_, static_cast<uint8_t>(kMessage));
  put(chunk_, kFixedBytes + data.size());
  put(chunk_, channel);
  put(chunk_, sequence);
  put(chunk_, time_ns);
  put(chunk_, time_ns);
  chunk_ += data;
  chunk_start_ns_ = chunk_messages_ == 0 ? time_ns : std::min(chunk_start_ns_, time_ns);
  chunk_end_ns_ = chunk_messages_ == 0 ? time_ns : std::max(chunk_end_ns_, time_ns);
  start_ns_ = message_count_ == 0 ? time_ns : std::min(start_ns_, time_ns);
  end_ns_ = message_count_ == 0 ? time_ns : std::max(end_ns_, time_ns);
  ++chunk_messages_;
  ++message_count_;
  ++counts_[channel];
  if (chunk_.size() >= kChunkBytes) flush_chunk();
}

void McapWriter::flush_chunk() {
  if (chunk_.empty()) return;
  ChunkIndex index;
  index.start_ns = chunk_messages_ == 0 ? 0 : chunk_start_ns_;
  index.end_ns = chunk_messages_ == 0 ? 0 : chunk_end_ns_;
  index.offset = static_cast<uint64_t>(out_.size_bytes());
  index.records_bytes = chunk_.size();
  std::string head;
  constexpr uint64_t kFixedBytes = 8 + 8 + 8 + 4 + 4 + 8;
  put(head, static_cast<uint8_t>(kChunk));
  put(head, kFixedBytes + chunk_.size());
  put(head, index.start_ns);
  put(head, index.end_ns);
  put(head, static_cast<uint64_t>(chunk_.size()));
  put(head, crc32(chunk_));
  put_text(head, "");  // not compressed
  put(head, static_cast<uint64_t>(chunk_.size()));
  emit(head);
  emit(chunk_);
  index.bytes = head.size() + chunk_.size();
  for (const auto& [channel, messages] : chunk_index_) {
    index.indexes.emplace_back(channel, static_cast<uint64_t>(out_.size_bytes()));
    std::string content, entries;
    for (const auto& [time_ns, offset] : messages) {
      put(entries, time_ns);
      put(entries, offset);
    }
    put(content, channel);
    put_text(content, entries);
    const std::string bytes = record(kMessageIndex, content);
    emit(bytes);
    index.index_bytes += bytes.size();
  }
  chunks_.push_back(std::move(index));
  chunk_.clear();
  chunk_index_.clear();
  chunk_messages_ = 0;
}

// The summary section that begins at byte `start`; `offsets` gets the section behind it.
std::string McapWriter::summary(uint64_t start, std::string& offsets) const {
  std::string bytes;
  const auto end_group = [&](Opcode opcode, std::size_t group_start) {
    if (bytes.size() == group_start) return;
    std::string content;
    put(content, static_cast<uint8_t>(opcode));
    put(content, start + group_start);
    put(content, static_cast<uint64_t>(bytes.size() - group_start));
    offsets += record(kSummaryOffset, content);
  };
  for (const std::string& schema : schemas_) bytes += schema;
  end_group(kSchema, 0);
  std::size_t group = bytes.size();
  for (const std::string& channel : channels_) bytes += channel;
  end_group(kChannel, group);
  group = bytes.size();
  std::string statistics, counts;
  put(statistics, message_count_);
  put(statistics, static_cast<uint16_t>(schemas_.size()));
  put(statistics, static_cast<uint32_t>(channels_.size()));
  put(statistics, uint32_t{0});  // attachments
  put(statistics, uint32_t{0});  // metadata
  put(statistics, static_cast<uint32_t>(chunks_.size()));
  put(statistics, start_ns_);
  put(statistics, end_ns_);
  for (const auto& [channel, count] : counts_) {
    put(counts, channel);
    put(counts, count);
  }
  put_text(statistics, counts);
  bytes += record(kStatistics, statistics);
  end_group(kStatistics, group);
  group = bytes.size();
  for (const ChunkIndex& chunk : chunks_) {
    std::string content, indexes;
    put(content, chunk.start_ns);
    put(content, chunk.end_ns);
    put(content, chunk.offset);
    put(content, chunk.bytes);
    for (const auto& [channel, offset] : chunk.indexes) {
      put(indexes, channel);
      put(indexes, offset);
    }
    put_text(content, indexes);
    put(content, chunk.index_bytes);
    put_text(content, "");
    put(content, chunk.records_bytes);
    put(content, chunk.records_bytes);
    bytes += record(kChunkIndex, content);
  }
  end_group(kChunkIndex, group);
  return bytes;
}

void McapWriter::finish() {
  flush_chunk();
  std::string checksum;
  put(checksum, written_crc_);
  emit(record(kDataEnd, checksum));
  const auto start = static_cast<uint64_t>(out_.size_bytes());
  std::string offsets;
  std::string tail = summary(start, offsets);
  const uint64_t offsets_start = start + tail.size();
  tail += offsets;
  constexpr uint64_t kFooterBytes = 8 + 8 + 4;
  put(tail, static_cast<uint8_t>(kFooter));
  put(tail, kFooterBytes);
  put(tail, start);
  put(tail, offsets_start);
  put(tail, crc32(tail));
  emit(tail);
  emit(kMagic);
}

}  // namespace marco::logs
