#include "lcm_tools/log/mcap_writer.hpp"

#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <stdexcept>

#include "lcm_tools/files/little_endian.hpp"
#include "lcm_tools/files/mcap.hpp"

namespace marco::logs {
namespace {

using files::kMcapMagic;
using files::put;
using Op = files::McapOp;

constexpr std::string_view kCompression = "zstd";
constexpr std::size_t kChunkBytes = 1 << 20;

void put_text(std::string& to, std::string_view text) {
  put(to, static_cast<uint32_t>(text.size()));
  to += text;
}

std::string record(Op opcode, std::string_view content) {
  std::string bytes;
  bytes.reserve(9 + content.size());
  put(bytes, static_cast<uint8_t>(opcode));
  put(bytes, static_cast<uint64_t>(content.size()));
  bytes += content;
  return bytes;
}

std::string packed_by_zstd(std::string_view plain) {
  std::string packed(ZSTD_compressBound(plain.size()), '\0');
  const std::size_t size =
      ZSTD_compress(packed.data(), packed.size(), plain.data(), plain.size(), ZSTD_CLEVEL_DEFAULT);
  if (ZSTD_isError(size) != 0) throw std::runtime_error(ZSTD_getErrorName(size));
  packed.resize(size);
  return packed;
}

uint32_t checksum(std::string_view bytes, uint32_t before = 0) {
  return static_cast<uint32_t>(
      crc32_z(before, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

}  // namespace

void McapWriter::Span::add(uint64_t time_ns) {
  start_ns = messages == 0 ? time_ns : std::min(start_ns, time_ns);
  end_ns = messages == 0 ? time_ns : std::max(end_ns, time_ns);
  ++messages;
}

McapWriter::McapWriter(OutputFile& out, std::string_view profile) : out_(out) {
  std::string header;
  put_text(header, profile);
  put_text(header, "marco-log");
  emit(kMcapMagic);
  emit(record(Op::header, header));
}

void McapWriter::emit(std::string_view bytes) {
  written_crc_ = checksum(bytes, written_crc_);
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
  schemas_.push_back(record(Op::schema, content));
  chunk_.bytes += schemas_.back();
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
  channels_.push_back(record(Op::channel, content));
  chunk_.bytes += channels_.back();
  return id;
}

void McapWriter::write(uint16_t channel,
                       uint32_t sequence,
                       McapTimes times,
                       std::string_view data) {
  constexpr uint64_t kFixedBytes = 2 + 4 + 8 + 8;
  chunk_.index[channel].emplace_back(times.log_ns, chunk_.bytes.size());
  put(chunk_.bytes, static_cast<uint8_t>(Op::message));
  put(chunk_.bytes, kFixedBytes + data.size());
  put(chunk_.bytes, channel);
  put(chunk_.bytes, sequence);
  put(chunk_.bytes, times.log_ns);
  put(chunk_.bytes, times.publish_ns);
  chunk_.bytes += data;
  chunk_.span.add(times.log_ns);
  written_.add(times.log_ns);
  ++counts_[channel];
  if (chunk_.bytes.size() >= kChunkBytes) flush_chunk();
}

void McapWriter::flush_chunk() {
  if (chunk_.bytes.empty()) return;
  ChunkIndex index;
  index.start_ns = chunk_.span.start_ns;
  index.end_ns = chunk_.span.end_ns;
  index.offset = static_cast<uint64_t>(out_.size_bytes());
  index.records_bytes = chunk_.bytes.size();
  const std::string packed = packed_by_zstd(chunk_.bytes);
  index.packed_bytes = packed.size();
  std::string head;
  constexpr uint64_t kFixedBytes = 8 + 8 + 8 + 4 + 4 + kCompression.size() + 8;
  put(head, static_cast<uint8_t>(Op::chunk));
  put(head, kFixedBytes + packed.size());
  put(head, index.start_ns);
  put(head, index.end_ns);
  put(head, static_cast<uint64_t>(chunk_.bytes.size()));
  put(head, checksum(chunk_.bytes));
  put_text(head, kCompression);
  put(head, static_cast<uint64_t>(packed.size()));
  emit(head);
  emit(packed);
  index.bytes = head.size() + packed.size();
  for (const auto& [channel, messages] : chunk_.index) {
    index.indexes.emplace_back(channel, static_cast<uint64_t>(out_.size_bytes()));
    std::string content, entries;
    for (const auto& [time_ns, offset] : messages) {
      put(entries, time_ns);
      put(entries, offset);
    }
    put(content, channel);
    put_text(content, entries);
    const std::string bytes = record(Op::message_index, content);
    emit(bytes);
    index.index_bytes += bytes.size();
  }
  chunks_.push_back(std::move(index));
  chunk_ = {};
}

// The summary section that begins at byte `start`; `offsets` gets the section behind it.
std::string McapWriter::summary(uint64_t start, std::string& offsets) const {
  std::string bytes;
  const auto end_group = [&](Op opcode, std::size_t group_start) {
    if (bytes.size() == group_start) return;
    std::string content;
    put(content, static_cast<uint8_t>(opcode));
    put(content, start + group_start);
    put(content, static_cast<uint64_t>(bytes.size() - group_start));
    offsets += record(Op::summary_offset, content);
  };
  for (const std::string& schema : schemas_) bytes += schema;
  end_group(Op::schema, 0);
  std::size_t group = bytes.size();
  for (const std::string& channel : channels_) bytes += channel;
  end_group(Op::channel, group);
  group = bytes.size();
  std::string statistics, counts;
  put(statistics, written_.messages);
  put(statistics, static_cast<uint16_t>(schemas_.size()));
  put(statistics, static_cast<uint32_t>(channels_.size()));
  put(statistics, uint32_t{0});  // attachments
  put(statistics, uint32_t{0});  // metadata
  put(statistics, static_cast<uint32_t>(chunks_.size()));
  put(statistics, written_.start_ns);
  put(statistics, written_.end_ns);
  for (const auto& [channel, count] : counts_) {
    put(counts, channel);
    put(counts, count);
  }
  put_text(statistics, counts);
  bytes += record(Op::statistics, statistics);
  end_group(Op::statistics, group);
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
    put_text(content, kCompression);
    put(content, chunk.packed_bytes);
    put(content, chunk.records_bytes);
    bytes += record(Op::chunk_index, content);
  }
  end_group(Op::chunk_index, group);
  return bytes;
}

void McapWriter::finish() {
  flush_chunk();
  std::string data_end;
  put(data_end, written_crc_);
  emit(record(Op::data_end, data_end));
  const auto start = static_cast<uint64_t>(out_.size_bytes());
  std::string offsets;
  std::string tail = summary(start, offsets);
  const uint64_t offsets_start = start + tail.size();
  tail += offsets;
  constexpr uint64_t kFooterBytes = 8 + 8 + 4;
  put(tail, static_cast<uint8_t>(Op::footer));
  put(tail, kFooterBytes);
  put(tail, start);
  put(tail, offsets_start);
  put(tail, checksum(tail));
  emit(tail);
  emit(kMcapMagic);
}

}  // namespace marco::logs
