#include "recordings/ros/bag_writer.hpp"

#include <fcntl.h>
#include <lz4frame.h>
#include <unistd.h>

#include <algorithm>
#include <memory>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "lcm_tools/files/little_endian.hpp"

namespace marco::ros {
namespace {

using files::put;

constexpr std::string_view kFirstLine = "#ROSBAG V2.0\n";
constexpr std::size_t kChunkBytes = std::size_t{768} << 10;
constexpr std::size_t kFileHeaderBytes = 4096;  // of header and data

enum class Op : uint8_t {
  message = 2,
  file = 3,
  index = 4,
  chunk = 5,
  chunk_info = 6,
  connection = 7
};

template <class Int>
std::string packed(Int value) {
  std::string bytes;
  put(bytes, value);
  return bytes;
}

std::string packed_time(int64_t ns) {
  constexpr int64_t kSecondNs = 1'000'000'000;
  return packed(static_cast<uint32_t>(ns / kSecondNs)) +
         packed(static_cast<uint32_t>(ns % kSecondNs));
}

void put_field(std::string& header, std::string_view name, std::string_view value) {
  put(header, static_cast<uint32_t>(name.size() + 1 + value.size()));
  header += name;
  header += '=';
  header += value;
}

std::string header_of(Op op) {
  std::string header;
  put_field(header, "op", packed(static_cast<uint8_t>(op)));
  return header;
}

void put_record(std::string& to, std::string_view header, std::string_view data) {
  put(to, static_cast<uint32_t>(header.size()));
  to += header;
  put(to, static_cast<uint32_t>(data.size()));
  to += data;
}

std::string file_header(uint64_t index_pos, std::size_t connections, std::size_t chunks) {
  std::string header = header_of(Op::file), record;
  put_field(header, "index_pos", packed(index_pos));
  put_field(header, "conn_count", packed(static_cast<uint32_t>(connections)));
  put_field(header, "chunk_count", packed(static_cast<uint32_t>(chunks)));
  put_record(record, header, std::string(kFileHeaderBytes - header.size(), ' '));
  return record;
}

std::size_t checked(std::size_t code) {
  if (LZ4F_isError(code) != 0) throw std::runtime_error(LZ4F_getErrorName(code));
  return code;
}

// ROS writes blocks of 1 MiB, and refuses frames with a content size, linked blocks, or no checksum
// of the content. LZ4F_compressFrame would take smaller blocks for a short chunk.
std::string lz4_frame(std::string_view plain) {
  LZ4F_preferences_t preferences{};
  preferences.frameInfo.blockSizeID = LZ4F_max1MB;
  preferences.frameInfo.blockMode = LZ4F_blockIndependent;
  preferences.frameInfo.contentChecksumFlag = LZ4F_contentChecksumEnabled;
  LZ4F_cctx* raw = nullptr;
  checked(LZ4F_createCompressionContext(&raw, LZ4F_VERSION));
  const std::unique_ptr<LZ4F_cctx, decltype(&LZ4F_freeCompressionContext)> context(
      raw, &LZ4F_freeCompressionContext);
  std::string frame(LZ4F_HEADER_SIZE_MAX + LZ4F_compressBound(plain.size(), &preferences), '\0');
  std::size_t used =
      checked(LZ4F_compressBegin(context.get(), frame.data(), frame.size(), &preferences));
  const auto room = [&] { return frame.size() - used; };
  used += checked(LZ4F_compressUpdate(context.get(), frame.data() + used, room(), plain.data(),
                                      plain.size(), nullptr));
  used += checked(LZ4F_compressEnd(context.get(), frame.data() + used, room(), nullptr));
  frame.resize(used);
  return frame;
}

}  // namespace

BagWriter::BagWriter(files::OutputFile& out) : out_(out) {
  out_.write(kFirstLine);
  out_.write(file_header(0, 0, 0));
}

uint32_t BagWriter::add_topic(const Topic& topic) {
  const auto id = static_cast<uint32_t>(connections_.size());
  std::string header = header_of(Op::connection), data, record;
  put_field(header, "conn", packed(id));
  put_field(header, "topic", topic.name);
  put_field(data, "topic", topic.name);
  put_field(data, "type", topic.type);
  put_field(data, "md5sum", topic.md5);
  put_field(data, "message_definition", topic.schema);
  if (const auto caller = topic.metadata.find("callerid"); caller != topic.metadata.end()) {
    put_field(data, "callerid", caller->second);
  }
  if (topic.is_latched) put_field(data, "latching", "1");
  put_record(record, header, data);
  connections_.push_back(std::move(record));
  return id;
}

void BagWriter::write(uint32_t topic,
                      int64_t received_ns,
                      int64_t /*published_ns*/,
                      std::span<const uint8_t> bytes) {
  // Seconds are 32 bits without a sign.
  constexpr int64_t kLastNs = int64_t{UINT32_MAX} * 1'000'000'000;
  const int64_t time_ns = std::clamp<int64_t>(received_ns, 1, kLastNs);
  if (written_connections_.insert(topic).second) chunk_ += connections_.at(topic);
  index_[topic].push_back({time_ns, static_cast<uint32_t>(chunk_.size())});
  std::string header = header_of(Op::message);
  put_field(header, "conn", packed(topic));
  put_field(header, "time", packed_time(time_ns));
  put_record(chunk_, header, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  if (chunk_.size() >= kChunkBytes) flush_chunk();
}

void BagWriter::flush_chunk() {
  if (chunk_.empty()) return;
  ChunkInfo info;
  info.offset = static_cast<uint64_t>(out_.size_bytes());
  std::string header = header_of(Op::chunk), record;
  put_field(header, "compression", "lz4");
  put_field(header, "size", packed(static_cast<uint32_t>(chunk_.size())));
  put_record(record, header, lz4_frame(chunk_));
  info.start_ns = INT64_MAX;
  for (auto& [connection, entries] : index_) {
    std::stable_sort(entries.begin(), entries.end(),
                     [](const Entry& a, const Entry& b) { return a.time_ns < b.time_ns; });
    info.start_ns = std::min(info.start_ns, entries.front().time_ns);
    info.end_ns = std::max(info.end_ns, entries.back().time_ns);
    info.counts[connection] = static_cast<uint32_t>(entries.size());
    std::string index_header = header_of(Op::index), data;
    put_field(index_header, "ver", packed(uint32_t{1}));
    put_field(index_header, "conn", packed(connection));
    put_field(index_header, "count", packed(static_cast<uint32_t>(entries.size())));
    for (const Entry& entry : entries) {
      data += packed_time(entry.time_ns);
      put(data, entry.offset);
    }
    put_record(record, index_header, data);
  }
  out_.write(record);
  chunks_.push_back(std::move(info));
  chunk_.clear();
  index_.clear();
}

void BagWriter::finish() {
  flush_chunk();
  const auto index_pos = static_cast<uint64_t>(out_.size_bytes());
  std::string tail;
  for (const std::string& connection : connections_) tail += connection;
  for (const ChunkInfo& chunk : chunks_) {
    std::string header = header_of(Op::chunk_info), data;
    put_field(header, "ver", packed(uint32_t{1}));
    put_field(header, "chunk_pos", packed(chunk.offset));
    put_field(header, "start_time", packed_time(chunk.start_ns));
    put_field(header, "end_time", packed_time(chunk.end_ns));
    put_field(header, "count", packed(static_cast<uint32_t>(chunk.counts.size())));
    for (const auto& [connection, count] : chunk.counts) {
      put(data, connection);
      put(data, count);
    }
    put_record(tail, header, data);
  }
  out_.write(tail);
  out_.flush();
  const std::string start = file_header(index_pos, connections_.size(), chunks_.size());
  const int file = ::open(out_.unfinished_path().c_str(),
                          O_WRONLY | O_CLOEXEC);  // NOLINT(cppcoreguidelines-pro-type-vararg)
  const auto wrote = file < 0 ? -1 : ::pwrite(file, start.data(), start.size(), kFirstLine.size());
  if (file >= 0) ::close(file);
  if (wrote != static_cast<ssize_t>(start.size())) {
    throw std::runtime_error(out_.unfinished_path().string() +
                             ": cannot write a bag there; name a file");
  }
}

}  // namespace marco::ros
