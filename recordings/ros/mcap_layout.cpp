#include "recordings/ros/mcap_layout.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "lcm_tools/base/check.hpp"
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

// A chunk's fields before its records; a compression's name is short.
constexpr std::size_t kChunkHeadBytes = 256;

class McapLayoutReader {
 public:
  explicit McapLayoutReader(ByteFile& file) : file_(file) {}

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
    for (McapLayout::Piece& piece : layout_.pieces) {
      if (!piece.chunk) continue;
      const auto index = chunk_indexes_.find(piece.place.offset);
      if (index != chunk_indexes_.end()) piece.channels = index->second.message_indexes;
    }
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
      const McapChunk chunk = parse_chunk(file_.peek(record.at, kChunkHeadBytes));
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
    const std::vector<uint8_t> bytes = file_.bytes(record.at, static_cast<int64_t>(record.length));
    McapFields fields(bytes);
    if (record.op == McapOp::schema) {
      McapSchema schema = parse_schema(fields);
      layout_.schemas[schema.id] = std::move(schema);
    } else if (record.op == McapOp::channel) {
      McapChannel channel = parse_channel(fields);
      layout_.channels[channel.id] = std::move(channel);
    } else if (record.op == McapOp::statistics) {
      layout_.statistics = parse_statistics(fields);
    } else if (record.op == McapOp::metadata) {
      std::string name = fields.text();
      layout_.metadata[std::move(name)] = fields.text_map();
    } else if (record.op == McapOp::chunk_index) {
      McapChunkIndex index = parse_chunk_index(fields);
      const auto place = places_.find(static_cast<int64_t>(index.offset));
      if (place != places_.end()) chunk_indexes_[place->second] = std::move(index);
    }
  }

  void add_message(const Record& record, int64_t from) {
    const McapMessage message = parse_message(McapFields(file_.peek(record.at, 22)));
    const bool goes_on = !layout_.pieces.empty() && !layout_.pieces.back().chunk &&
                         from - layout_.pieces.back().place.offset < kPieceBytes;
    if (!goes_on) {
      layout_.pieces.push_back({{message.log_ns, message.log_ns, from, 0}, {}, {}});
    }
    ChunkPlace& place = layout_.pieces.back().place;
    place.start_ns = std::min(place.start_ns, message.log_ns);
    place.end_ns = std::max(place.end_ns, message.log_ns);
    place.size = record.end() - place.offset;
  }

  void add_chunk(const Record& record) {
    const McapChunk chunk = parse_chunk(file_.peek(record.at, kChunkHeadBytes));
    const int64_t records_at = record.at + static_cast<int64_t>(chunk.head);
    const int64_t size =
        std::min<int64_t>(static_cast<int64_t>(chunk.size), file_.size() - records_at);
    if (size < 0) throw WireError("a chunk of negative size");
    places_[record.at - static_cast<int64_t>(kMcapRecordHead)] = records_at;
    layout_.pieces.push_back({{chunk.start_ns, chunk.end_ns, records_at, size}, chunk, {}});
  }

  // No mark stands before a record: one is believed when another follows it.
  int64_t after_damage(int64_t from) {
    for (int64_t at = from + 1; at < file_.size(); ++at) {
      const auto head = file_.peek(at, kMcapRecordHead);
      if (head.size() < kMcapRecordHead) break;
      if (!is_known(head[0])) continue;
      const auto record = record_at(at);
      if (!record || record->length == 0) continue;
      std::array<uint8_t, kMcapRecordHead> behind{};  // far off: not by the window of peek()
      const std::size_t there = file_.read(record->end(), behind);
      const bool is_end = record->end() == file_.size();
      if (!is_end && !record_of(record->end(), std::span(behind).first(there))) continue;
      lose(from, at);
      return at;
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
  McapLayout layout_;
  bool ended_ = false;
  std::map<int64_t, int64_t> places_;                // a chunk's records by its opcode
  std::map<int64_t, McapChunkIndex> chunk_indexes_;  // by the place of its records
};

}  // namespace

McapLayout read_mcap_layout(ByteFile& file, const std::string& path) {
  const auto magic = file.bytes(0, static_cast<int64_t>(kMcapMagic.size()));
  require(std::equal(magic.begin(), magic.end(), kMcapMagic.begin(), kMcapMagic.end(),
                     [](uint8_t a, char b) { return a == static_cast<uint8_t>(b); }),
          path + ": is no MCAP file");
  return McapLayoutReader(file).read();
}

}  // namespace marco::ros
