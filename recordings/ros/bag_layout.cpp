#include "recordings/ros/bag_layout.hpp"

#include <algorithm>
#include <cstring>
#include <limits>
#include <string_view>

#include "lcm_tools/base/check.hpp"
#include "recordings/looking_through.hpp"
#include "recordings/ros/bag_records.hpp"
#include "recordings/ros/compression.hpp"

namespace marco::ros {
namespace {

constexpr std::string_view kMagic = "#ROSBAG V2.0\n";
constexpr int64_t kMostHeaderBytes = 1 << 14;

/// A record of which the data was not read.
struct RecordPlace {
  std::vector<uint8_t> header_bytes;
  BagOp op;
  int64_t data_at;
  int64_t data_size;

  BagHeader header() const { return *BagHeader::parse(header_bytes); }
  int64_t end() const { return data_at + data_size; }
};

uint32_t u32_at(std::span<const uint8_t> bytes) {
  uint32_t value = 0;
  if (bytes.size() >= 4) std::memcpy(&value, bytes.data(), 4);
  return value;
}

// Nothing where no record begins.
std::optional<RecordPlace> record_at(ByteFile& file, int64_t offset) {
  const auto length = file.peek(offset, 4);
  if (length.size() < 4) return std::nullopt;
  const int64_t header_size = u32_at(length);
  if (header_size > kMostHeaderBytes || offset + 8 + header_size > file.size()) return std::nullopt;
  const auto bytes = file.peek(offset + 4, static_cast<std::size_t>(header_size) + 4);
  const auto fields = bytes.first(static_cast<std::size_t>(header_size));
  const auto header = BagHeader::parse(fields);
  const auto op = header ? header->u8("op") : std::nullopt;
  if (!op || *op < 2 || *op > 7) return std::nullopt;
  return RecordPlace{{fields.begin(), fields.end()},
                     static_cast<BagOp>(*op),
                     offset + 8 + header_size,
                     u32_at(bytes.subspan(fields.size()))};
}

class BagLayoutReader {
 public:
  BagLayoutReader(ByteFile& file, const std::string& path) : file_(file), path_(path) {}

  BagLayout read() {
    const auto magic = file_.bytes(0, static_cast<int64_t>(kMagic.size()));
    require(
        std::string_view(reinterpret_cast<const char*>(magic.data()), magic.size()) == kMagic,
        path_ +
            ": a ROS bag in a format older than 2.0 (2010): convert it with `rosbag fix` of ROS");
    const auto first = record_at(file_, static_cast<int64_t>(kMagic.size()));
    uint64_t index_at = 0;
    int64_t at = static_cast<int64_t>(kMagic.size());
    if (first && first->op == BagOp::file_header) {
      const BagHeader header = first->header();
      require(header.text("encryptor").empty(), path_ + ": is encrypted");
      index_at = header.u64("index_pos").value_or(0);
      chunks_told_ = header.u32("chunk_count").value_or(0);
      at = first->end();
    }
    if (index_at > 0 && read_index(static_cast<int64_t>(index_at))) {
      layout_.is_indexed = true;
      return std::move(layout_);
    }
    layout_ = {};
    layout_.notes.emplace_back(
        "the bag has no index, as after a crash: reading it from end to end");
    walk(at);
    return std::move(layout_);
  }

 private:
  // False where it is not whole.
  bool read_index(int64_t at) {
    while (at < file_.size()) {
      const auto record = record_at(file_, at);
      if (!record || record->end() > file_.size()) return false;
      if (record->op == BagOp::connection) {
        add_connection(*record);
      } else if (record->op == BagOp::chunk_info && !add_chunk_of(*record)) {
        return false;
      }
      at = record->end();
    }
    std::sort(layout_.chunks.begin(), layout_.chunks.end(),
              [](const auto& a, const auto& b) { return a.place.offset < b.place.offset; });
    return layout_.chunks.size() == chunks_told_;
  }

  bool add_chunk_of(const RecordPlace& info) {
    const BagHeader header = info.header();
    const auto position = header.u64("chunk_pos");
    const auto start_ns = header.time_ns("start_time"), end_ns = header.time_ns("end_time");
    if (!position || !start_ns || !end_ns) return false;
    const auto chunk = record_at(file_, static_cast<int64_t>(*position));
    if (!chunk || chunk->op != BagOp::chunk || chunk->end() > file_.size()) return false;
    add_chunk(*chunk);
    BagLayout::Chunk& added = layout_.chunks.back();
    added.place.start_ns = *start_ns;
    added.place.end_ns = *end_ns;
    const auto counts = file_.bytes(info.data_at, info.data_size);
    for (std::size_t i = 0; i + 8 <= counts.size(); i += 8) {
      const uint32_t connection = u32_at(std::span(counts).subspan(i));
      added.connections.push_back(connection);
      layout_.counts[connection] += u32_at(std::span(counts).subspan(i + 4));
    }
    return true;
  }

  void add_chunk(const RecordPlace& record) {
    const BagHeader header = record.header();
    BagLayout::Chunk chunk;
    chunk.compression = header.text("compression");
    chunk.plain_size = header.u32("size").value_or(0);
    chunk.place.offset = record.data_at;
    chunk.place.size = std::min(record.data_size, file_.size() - record.data_at);
    require(layout_.chunks.size() < kMostChunks, path_ + kTooManyChunks);
    layout_.chunks.push_back(std::move(chunk));
  }

  void add_connection(const RecordPlace& record) {
    const BagHeader header = record.header();
    const auto id = header.u32("conn");
    if (!id) return;
    const auto data = file_.bytes(record.data_at, record.data_size);
    if (auto topic = topic_of(*id, header.text("topic"), data)) {
      layout_.connections.insert_or_assign(*id, std::move(*topic));
    }
  }

  void walk(int64_t at) {
    while (at < file_.size()) {
      const auto record = record_at(file_, at);
      if (!record) {
        at = next_chunk_after(at);
        continue;
      }
      layout_.damage.is_cut_off = layout_.damage.is_cut_off || record->end() > file_.size();
      switch (record->op) {
        case BagOp::chunk:
          at = take_chunk(*record);
          continue;
        case BagOp::index:
          take_index(*record);
          break;
        case BagOp::connection:
          add_connection(*record);
          break;
        default:
          break;
      }
      at = record->end();
    }
  }

  // The chunk that was open when the recorder ended says that it is empty; what is in it follows.
  int64_t take_chunk(const RecordPlace& record) {
    add_chunk(record);
    BagLayout::Chunk& chunk = layout_.chunks.back();
    if (record.data_size == 0 && chunk.plain_size == 0) {
      chunk.place.size = file_.size() - record.data_at;
      if (chunk.compression == "none") {
        chunk.place.size = end_of_open_chunk(record.data_at) - record.data_at;
        chunk.plain_size = static_cast<uint64_t>(chunk.place.size);
        return record.data_at + chunk.place.size;
      }
      lose(record.data_at, file_.size(), true);
      layout_.chunks.pop_back();
      return file_.size();
    }
    if (record.end() > file_.size()) {
      layout_.damage.is_cut_off = true;
      return file_.size();
    }
    return record.end();
  }

  int64_t end_of_open_chunk(int64_t at) {
    while (const auto record = record_at(file_, at)) {
      const bool is_inside = record->op == BagOp::message || record->op == BagOp::connection;
      if (!is_inside || record->end() > file_.size()) break;
      at = record->end();
    }
    if (at < file_.size() && !record_at(file_, at)) return file_.size();
    return at;
  }

  // `count` times {seconds, nanoseconds, offset}, of the chunk before.
  void take_index(const RecordPlace& record) {
    if (layout_.chunks.empty()) return;
    BagLayout::Chunk& chunk = layout_.chunks.back();
    const auto id = record.header().u32("conn");
    const auto entries = file_.bytes(record.data_at, record.data_size);
    if (!id || entries.size() < 12) return;
    constexpr int64_t kSecondNs = 1'000'000'000;
    for (std::size_t i = 0; i + 12 <= entries.size(); i += 12) {
      const int64_t time_ns = kSecondNs * u32_at(std::span(entries).subspan(i)) +
                              u32_at(std::span(entries).subspan(i + 4));
      const bool is_first = chunk.connections.empty() && i == 0;
      chunk.place.start_ns = is_first ? time_ns : std::min(chunk.place.start_ns, time_ns);
      chunk.place.end_ns = is_first ? time_ns : std::max(chunk.place.end_ns, time_ns);
    }
    chunk.connections.push_back(*id);
  }

  // The header field that says "this is a chunk" tells where to look for the header's start.
  int64_t next_chunk_after(int64_t from) {
    constexpr std::string_view kOp = "\x04\0\0\0op=\x05";
    constexpr int64_t kMostBlock = 1 << 20, kMostBefore = 200;
    const std::string_view wanted(kOp.data(), 8);
    LookingThrough progress(path_);
    int64_t size = 1 << 12;  // damage may be everywhere, and short
    for (int64_t block = from + 1; block < file_.size(); block += size) {
      progress.update(static_cast<double>(block) / static_cast<double>(file_.size()));
      block = std::max(block, file_.next_data(block) - static_cast<int64_t>(wanted.size()));
      size = std::min(2 * size, kMostBlock);
      const auto bytes = file_.bytes(block, size + static_cast<int64_t>(wanted.size()));
      const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
      for (std::size_t hit = text.find(wanted); hit != std::string_view::npos;
           hit = text.find(wanted, hit + 1)) {
        const int64_t field_at = block + static_cast<int64_t>(hit);
        for (int64_t at = field_at - 4; at > std::max(from, field_at - kMostBefore); --at) {
          const int64_t ends_at = at + 4 + u32_at(file_.peek(at, 4));
          if (ends_at <= field_at || ends_at > field_at + kMostBefore) continue;
          const auto record = record_at(file_, at);
          if (!record || record->op != BagOp::chunk || record->data_at <= field_at) continue;
          if (record->header().text("compression").empty()) continue;
          lose(from, at, false);
          return at;
        }
      }
    }
    lose(from, file_.size(), true);
    return file_.size();
  }

  void lose(int64_t from, int64_t to, bool at_the_end) {
    if (layout_.damage.places++ == 0) layout_.damage.first_offset = from;
    layout_.damage.bytes += to - from;
    layout_.damage.is_cut_off = layout_.damage.is_cut_off || at_the_end;
  }

  ByteFile& file_;
  const std::string& path_;
  BagLayout layout_;
  std::size_t chunks_told_ = 0;  // by the file's header
};

}  // namespace

BagLayout read_bag_layout(ByteFile& file, const std::string& path) {
  return BagLayoutReader(file, path).read();
}

std::optional<Topic> topic_of(uint32_t id, std::string name, std::span<const uint8_t> data) {
  const auto fields = BagHeader::parse(data);
  if (!fields || fields->text("type").empty()) return std::nullopt;
  Topic topic;
  topic.id = id;
  topic.name = name.empty() ? fields->text("topic") : std::move(name);
  topic.type = plain_type(fields->text("type"));
  topic.encoding = "ros1";
  topic.schema_encoding = "ros1msg";
  topic.schema = fields->text("message_definition");
  topic.md5 = fields->text("md5sum");
  topic.is_latched = fields->text("latching") == "1";
  topic.metadata["callerid"] = fields->text("callerid");
  return topic;
}

}  // namespace marco::ros
