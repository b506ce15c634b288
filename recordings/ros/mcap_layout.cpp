#include "recordings/ros/mcap_layout.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "lcm_tools/base/check.hpp"
#include "recordings/looking_through.hpp"
#include "recordings/ros/wire_reader.hpp"

namespace marco::ros {
namespace {

struct Record {
  McapOp op;
  int64_t at;       // of its content
  uint64_t length;  // of it

  int64_t end() const { return at + static_cast<int64_t>(length); }
};

bool is_known(uint8_t op) { return op >= 0x01 && op <= 0x0F; }

// Messages outside chunks are read by pieces of this size.
constexpr int64_t kPieceBytes = 1 << 20;

// A chunk's fields before its records, and with a compression's name, which is short.
constexpr std::size_t kChunkHeadBytes = 40, kMostChunkHeadBytes = 256;

class McapLayoutReader {
 public:
  McapLayoutReader(ByteFile& file, const std::string& path) : file_(file), path_(path) {}

  McapLayout read() {
    int64_t at = static_cast<int64_t>(kMcapMagic.size());
    while (at < file_.size() && !ended_) {
      const auto record = record_at(at);
      if (!record) {
        at = after_damage(at);
        continue;
      }
      take(*record, at);
      at = record->end();
    }
    layout_.damage.is_cut_off = layout_.damage.is_cut_off || !ended_;
    return std::move(layout_);
  }

 private:
  std::optional<Record> record_at(int64_t at) {
    return record_of(at, file_.peek(at, kMcapRecordHead));
  }

  // Nothing where no record begins. A chunk that the file cuts off is shortened to what there is.
  std::optional<Record> record_of(int64_t at, std::span<const uint8_t> head) {
    if (head.size() < kMcapRecordHead || !is_known(head[0])) return std::nullopt;
    McapFields fields(head.subspan(1));
    Record record{static_cast<McapOp>(head[0]), at + static_cast<int64_t>(kMcapRecordHead),
                  fields.u64()};
    const auto left = static_cast<uint64_t>(file_.size() - record.at);
    if (record.length <= left) return record;
    if (record.op != McapOp::chunk || !is_cut_chunk(record)) return std::nullopt;
    record.length = left;
    layout_.damage.is_cut_off = true;
    return record;
  }

  // Whether its own fields say the same length.
  bool is_cut_chunk(const Record& record) {
    try {
      const McapChunk chunk = parse_chunk(file_.peek(record.at, kMostChunkHeadBytes));
      return chunk.head <= record.length && chunk.size == record.length - chunk.head;
    } catch (const WireError&) {
      return false;
    }
  }

  void take(const Record& record, int64_t from) {
    try {
      if (record.op == McapOp::message) return add_message(record, from);
      if (record.op == McapOp::chunk) return add_chunk(record);
      if (record.op == McapOp::footer) ended_ = true;
      if (record.op == McapOp::message_index || record.op == McapOp::attachment) return;
      read_small(record);
    } catch (const WireError&) {
      lose(from, record.end());
    }
  }

  void read_small(const Record& record) {
    const bool is_read = record.op == McapOp::schema || record.op == McapOp::channel ||
                         record.op == McapOp::statistics || record.op == McapOp::chunk_index;
    if (!is_read || record.length > kMostTopicBytes) return;
    const std::vector<uint8_t> bytes = file_.bytes(record.at, static_cast<int64_t>(record.length));
    McapFields fields(bytes);
    if (record.op == McapOp::schema) {
      McapSchema schema = parse_schema(fields);
      count(layout_.schemas.contains(schema.id), record.length);
      layout_.schemas[schema.id] = std::move(schema);
    } else if (record.op == McapOp::channel) {
      McapChannel channel = parse_channel(fields);
      count(layout_.channels.contains(channel.id), record.length);
      layout_.channels[channel.id] = std::move(channel);
    } else if (record.op == McapOp::statistics) {
      layout_.statistics = parse_statistics(fields);
    } else {
      take_index(parse_chunk_index(fields));
    }
  }

  // A summary repeats what came before.
  void count(bool is_known, uint64_t bytes) {
    definition_bytes_ += is_known ? 0 : bytes;
    require(definition_bytes_ <= kMostTopicBytes, path_ + kTooManyTopics);
  }

  void take_index(McapChunkIndex index) {
    const auto behind = std::upper_bound(
        layout_.places.begin(), layout_.places.end(), static_cast<int64_t>(index.offset),
        [](int64_t offset, const ChunkPlace& place) { return offset < place.offset; });
    if (behind == layout_.places.end()) return;
    McapLayout::Piece& piece =
        layout_.pieces[static_cast<std::size_t>(behind - layout_.places.begin())];
    if (!piece.is_chunk) return;
    const std::size_t head =
        kMcapRecordHead + kChunkHeadBytes + layout_.compressions[piece.compression].size();
    const bool is_its = index.offset + head == static_cast<uint64_t>(behind->offset);
    if (is_its) piece.channels = std::move(index.channels);
  }

  void add_piece(const ChunkPlace& place, McapLayout::Piece piece) {
    require(layout_.places.size() < kMostChunks, path_ + kTooManyChunks);
    layout_.places.push_back(place);
    layout_.pieces.push_back(std::move(piece));
  }

  void add_message(const Record& record, int64_t from) {
    const McapMessage message = parse_message(McapFields(file_.peek(record.at, kMcapMessageHead)));
    const bool goes_on = !layout_.pieces.empty() && !layout_.pieces.back().is_chunk &&
                         from - layout_.places.back().offset < kPieceBytes;
    if (!goes_on) add_piece({message.log_ns, message.log_ns, from, 0}, {});
    ChunkPlace& place = layout_.places.back();
    place.start_ns = std::min(place.start_ns, message.log_ns);
    place.end_ns = std::max(place.end_ns, message.log_ns);
    place.size = record.end() - place.offset;
    layout_.pieces.back().plain_size = static_cast<uint64_t>(place.size);
  }

  void add_chunk(const Record& record) {
    const McapChunk chunk = parse_chunk(file_.peek(record.at, kMostChunkHeadBytes));
    const int64_t records_at = record.at + static_cast<int64_t>(chunk.head);
    const int64_t size =
        std::min<int64_t>(static_cast<int64_t>(chunk.size), file_.size() - records_at);
    if (size < 0) throw WireError("a chunk of negative size");
    if (size == 0 && chunk.plain_size == 0) return;
    add_piece({chunk.start_ns, chunk.end_ns, records_at, size},
              {chunk.plain_size, chunk.crc, true, number_of(chunk.compression), {}});
  }

  uint8_t number_of(const std::string& compression) {
    auto& names = layout_.compressions;
    const auto known = std::find(names.begin(), names.end(), compression);
    if (known == names.end() && names.size() == UINT8_MAX) throw WireError("too many compressions");
    const auto number = static_cast<uint8_t>(known - names.begin());
    if (known == names.end()) names.push_back(compression);
    return number;
  }

  bool is_followed(int64_t at) {
    const auto record = record_at(at);
    if (!record || record->length == 0) return false;
    std::array<uint8_t, kMcapRecordHead> behind{};  // far off: not by the window of peek()
    const std::size_t there = file_.read(record->end(), behind);
    return record->end() == file_.size() ||
           record_of(record->end(), std::span(behind).first(there)).has_value();
  }

  // No mark stands before a record: one is believed when another follows it.
  int64_t after_damage(int64_t from) {
    LookingThrough progress(path_);
    std::array<uint8_t, 1 << 14> block{};
    for (int64_t start = from + 1; start < file_.size();) {
      progress.update(static_cast<double>(start) / static_cast<double>(file_.size()));
      start = file_.next_data(start);
      const std::size_t size = file_.read(start, block);
      for (std::size_t i = 0; i < size; ++i) {
        const int64_t at = start + static_cast<int64_t>(i);
        if (!is_known(block[i]) || !is_followed(at)) continue;
        lose(from, at);
        return at;
      }
      start += static_cast<int64_t>(std::max<std::size_t>(1, size));
    }
    lose(from, file_.size());
    layout_.damage.is_cut_off = true;
    return file_.size();
  }

  void lose(int64_t from, int64_t to) {
    if (layout_.damage.places++ == 0) layout_.damage.first_offset = from;
    layout_.damage.bytes += to - from;
  }

  ByteFile& file_;
  const std::string& path_;
  McapLayout layout_;
  bool ended_ = false;
  uint64_t definition_bytes_ = 0;
};

}  // namespace

McapLayout read_mcap_layout(ByteFile& file, const std::string& path) {
  const auto magic = file.bytes(0, static_cast<int64_t>(kMcapMagic.size()));
  require(std::equal(magic.begin(), magic.end(), kMcapMagic.begin(), kMcapMagic.end(),
                     [](uint8_t a, char b) { return a == static_cast<uint8_t>(b); }),
          path + ": is not an MCAP file");
  return McapLayoutReader(file, path).read();
}

}  // namespace marco::ros
