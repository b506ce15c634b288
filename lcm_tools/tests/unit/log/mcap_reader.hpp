#pragma once

#include <zlib.h>
#include <zstd.h>

#include <cstdint>
#include <deque>
#include <map>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

/// A slow reader of MCAP that believes nothing: every length, checksum and index is checked.
namespace marco::logs::test {

struct McapMessage {
  uint16_t channel = 0;
  uint64_t time_ns = 0;
  std::string data;
};

struct McapFile {
  std::map<std::string, std::string> schemas;  // name -> data
  std::map<uint16_t, std::string> topics;
  std::map<uint16_t, std::string> summary_topics;
  std::vector<McapMessage> messages;
  std::size_t chunks = 0;
  std::size_t indexed_messages = 0;  // found through the summary's chunk indexes
  uint64_t statistics_messages = 0;
};

inline uint32_t crc_of(std::string_view bytes) {
  return static_cast<uint32_t>(
      crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

inline void check(bool holds, const char* what) {
  if (!holds) throw std::runtime_error(what);
}

class Bytes {
 public:
  explicit Bytes(std::string_view bytes) : bytes_(bytes) {}
  template <class Int>
  Int take() {
    check(bytes_.size() >= sizeof(Int), "MCAP ends early");
    uint64_t value = 0;
    for (std::size_t i = sizeof(Int); i-- > 0;)
      value = value << 8U | static_cast<uint8_t>(bytes_[i]);
    bytes_.remove_prefix(sizeof(Int));
    return static_cast<Int>(value);
  }
  std::string_view take(uint64_t count) {
    check(bytes_.size() >= count, "MCAP ends early");
    const std::string_view part = bytes_.substr(0, count);
    bytes_.remove_prefix(count);
    return part;
  }
  std::string_view text() { return take(take<uint32_t>()); }
  bool empty() const { return bytes_.empty(); }
  std::size_t left() const { return bytes_.size(); }

 private:
  std::string_view bytes_;
};

inline void read_definition(uint8_t opcode,
                            Bytes content,
                            std::map<std::string, std::string>* schemas,
                            std::map<uint16_t, std::string>& topics) {
  const auto id = content.take<uint16_t>();
  if (opcode == 0x03) {
    const std::string name(content.text());
    check(content.text() == "jsonschema", "schema encoding");
    if (schemas != nullptr) (*schemas)[name] = content.text();
  } else {
    content.take<uint16_t>();
    topics[id] = content.text();
    check(content.text() == "json", "message encoding");
  }
}

inline McapFile read_mcap(const std::string& bytes) {
  const std::string magic("\x89MCAP0\r\n", 8);
  McapFile file;
  check(bytes.starts_with(magic) && bytes.ends_with(magic), "magic");
  Bytes rest(std::string_view(bytes).substr(8, bytes.size() - 16));
  const auto position = [&] { return bytes.size() - 8 - rest.left(); };
  bool in_summary = false;
  std::deque<std::string> plain;
  uint64_t summary_start = 0;
  std::map<uint64_t, std::string_view> chunks;                        // offset -> records
  std::map<uint64_t, std::pair<uint16_t, std::string_view>> indexes;  // offset -> channel, entries
  while (!rest.empty()) {
    const uint64_t offset = position();
    const auto opcode = rest.take<uint8_t>();
    Bytes content(rest.take(rest.take<uint64_t>()));
    if (opcode == 0x06) {
      const auto start = content.take<uint64_t>(), end = content.take<uint64_t>();
      const auto size = content.take<uint64_t>();
      const auto checksum = content.take<uint32_t>();
      check(content.text() == "zstd", "compression");
      const std::string_view packed = content.take(content.take<uint64_t>());
      std::string& records = plain.emplace_back(size, '\0');
      check(ZSTD_decompress(records.data(), size, packed.data(), packed.size()) == size, "zstd");
      check(records.size() == size && crc_of(records) == checksum, "chunk size or checksum");
      chunks[offset] = records;
      ++file.chunks;
      Bytes inside(records);
      while (!inside.empty()) {
        const auto inner = inside.take<uint8_t>();
        Bytes part(inside.take(inside.take<uint64_t>()));
        if (inner != 0x05) {
          read_definition(inner, part, &file.schemas, file.topics);
          continue;
        }
        McapMessage message;
        message.channel = part.take<uint16_t>();
        part.take<uint32_t>();
        message.time_ns = part.take<uint64_t>();
        check(part.take<uint64_t>() == message.time_ns, "publish time");
        check(message.time_ns >= start && message.time_ns <= end, "chunk times");
        check(file.topics.contains(message.channel), "a message before its channel");
        message.data = part.take(part.left());
        file.messages.push_back(std::move(message));
      }
    } else if (opcode == 0x07) {
      const auto channel = content.take<uint16_t>();
      indexes[offset] = {channel, content.text()};
    } else if (opcode == 0x0F) {
      in_summary = true;
      check(content.take<uint32_t>() == crc_of(std::string_view(bytes).substr(0, offset)),
            "checksum of the data");
      summary_start = position();
    } else if (opcode == 0x03 || opcode == 0x04) {
      check(in_summary, "definitions outside chunks");
      read_definition(opcode, content, nullptr, file.summary_topics);
    } else if (opcode == 0x0B) {
      file.statistics_messages = content.take<uint64_t>();
    } else if (opcode == 0x08) {
      content.take<uint64_t>();
      content.take<uint64_t>();
      const std::string_view records = chunks.at(content.take<uint64_t>());
      content.take<uint64_t>();
      Bytes offsets(content.text());
      while (!offsets.empty()) {
        const auto channel = offsets.take<uint16_t>();
        const auto& index = indexes.at(offsets.take<uint64_t>());
        check(index.first == channel, "index of another channel");
        Bytes entries(index.second);
        while (!entries.empty()) {
          const auto time_ns = entries.take<uint64_t>();
          Bytes message(records.substr(entries.take<uint64_t>()));
          check(message.take<uint8_t>() == 0x05, "an index does not point at a message");
          message.take<uint64_t>();
          check(message.take<uint16_t>() == channel, "index channel");
          message.take<uint32_t>();
          check(message.take<uint64_t>() == time_ns, "index time");
          ++file.indexed_messages;
        }
      }
    } else if (opcode == 0x02) {
      check(content.take<uint64_t>() == summary_start, "summary start");
      const auto offsets_start = content.take<uint64_t>();
      check(bytes[offsets_start] == 0x0E, "summary offset start");
      const std::string_view summed(bytes.data() + summary_start,
                                    bytes.size() - 8 - 4 - summary_start);
      check(crc_of(summed) == content.take<uint32_t>(), "summary checksum");
      check(rest.empty(), "something behind the footer");
    }
  }
  return file;
}

}  // namespace marco::logs::test
