#include "common/files/event_log.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "common/check.hpp"

namespace marco::files {
namespace {

constexpr uint32_t kSync = 0xEDA1DA01;
constexpr int64_t kHeaderBytes = 28;
constexpr uint32_t kMaxChannelBytes = 63;
constexpr uint32_t kMaxDataBytes = 256U << 20U;

template <class Int>
Int read_big_endian(const uint8_t* bytes) {
  std::make_unsigned_t<Int> value = 0;
  for (std::size_t i = 0; i < sizeof(Int); ++i) {
    value = static_cast<std::make_unsigned_t<Int>>((value << 8U) | bytes[i]);
  }
  return static_cast<Int>(value);
}

template <class Int>
uint8_t* write_big_endian(uint8_t* bytes, Int value) {
  for (std::size_t i = 0; i < sizeof(Int); ++i) {
    const std::size_t shift = 8 * (sizeof(Int) - 1 - i);
    *bytes++ = static_cast<uint8_t>(static_cast<std::make_unsigned_t<Int>>(value) >> shift);
  }
  return bytes;
}

struct Header {
  explicit Header(const uint8_t* bytes)
      : sync(read_big_endian<uint32_t>(bytes)),
        number(read_big_endian<int64_t>(bytes + 4)),
        time_us(read_big_endian<int64_t>(bytes + 12)),
        channel_bytes(read_big_endian<uint32_t>(bytes + 20)),
        data_bytes(read_big_endian<uint32_t>(bytes + 24)) {}

  bool plausible() const {
    return sync == kSync && channel_bytes > 0 && channel_bytes <= kMaxChannelBytes &&
           data_bytes <= kMaxDataBytes;
  }
  int64_t event_bytes() const { return kHeaderBytes + channel_bytes + data_bytes; }

  uint32_t sync;
  int64_t number;
  int64_t time_us;
  uint32_t channel_bytes;
  uint32_t data_bytes;
};

bool printable(const std::string& channel) {
  return std::all_of(channel.begin(), channel.end(), [](char c) { return c > 32 && c < 127; });
}

}  // namespace

EventLogReader::EventLogReader(const std::string& path)
    : file_(std::fopen(path.c_str(), "rb")), path_(path) {
  struct stat status = {};
  require(file_ != nullptr && fstat(fileno(file_.get()), &status) == 0 && S_ISREG(status.st_mode),
          path + ": cannot be read as a log" +
              (file_ ? " (not a file)" : std::string(": ") + std::strerror(errno)));
  size_ = status.st_size;
}

bool EventLogReader::read_at(int64_t offset, std::span<uint8_t> bytes) {
  if (offset + static_cast<int64_t>(bytes.size()) > size_) return false;
  if (offset != file_offset_ && fseeko(file_.get(), offset, SEEK_SET) != 0) return false;
  const std::size_t got = std::fread(bytes.data(), 1, bytes.size(), file_.get());
  file_offset_ = offset + static_cast<int64_t>(got);
  return got == bytes.size();
}

std::optional<LogEvent> EventLogReader::read_event_at(int64_t offset) {
  std::array<uint8_t, kHeaderBytes> bytes{};
  if (!read_at(offset, bytes)) return std::nullopt;
  const Header header(bytes.data());
  const int64_t end = offset + header.event_bytes();
  if (!header.plausible() || end > size_) return std::nullopt;
  LogEvent event;
  event.number = header.number;
  event.event_time = Utime::from_us(header.time_us);
  event.channel.resize(header.channel_bytes);
  event.bytes.resize(header.data_bytes);
  const std::span<uint8_t> channel(reinterpret_cast<uint8_t*>(event.channel.data()),
                                   event.channel.size());
  const bool whole = read_at(offset + kHeaderBytes, channel) && printable(event.channel) &&
                     read_at(offset + kHeaderBytes + header.channel_bytes, event.bytes) &&
                     (followed_by_event(end) || !contains_head(offset + kHeaderBytes, end));
  if (!whole) return std::nullopt;
  return event;
}

bool EventLogReader::followed_by_event(int64_t end) {
  std::array<uint8_t, 4> sync{};
  if (end + 4 > size_) return true;
  return read_at(end, sync) && read_big_endian<uint32_t>(sync.data()) == kSync;
}

bool EventLogReader::contains_head(int64_t from, int64_t end) {
  // A damaged length that still points inside the file swallows the heads of other events.
  std::array<uint8_t, kHeaderBytes> bytes{};
  for (auto sync = find_sync(from); sync && *sync < end; sync = find_sync(*sync + 1)) {
    if (read_at(*sync, bytes) && Header(bytes.data()).plausible()) return true;
  }
  return false;
}

std::optional<int64_t> EventLogReader::find_sync(int64_t from) {
  constexpr int64_t kBlock = 1 << 16;
  std::vector<uint8_t> block;
  for (int64_t start = from; start + 4 <= size_; start += kBlock - 3) {
    block.resize(static_cast<std::size_t>(std::min(kBlock, size_ - start)));
    if (!read_at(start, block)) return std::nullopt;
    for (std::size_t i = 0; i + 4 <= block.size(); ++i) {
      if (block[i] == 0xED && read_big_endian<uint32_t>(&block[i]) == kSync) {
        return start + static_cast<int64_t>(i);
      }
    }
  }
  return std::nullopt;
}

std::optional<LogEvent> EventLogReader::next() {
  if (position_ >= size_) return std::nullopt;
  int64_t candidate = position_;
  std::optional<LogEvent> event = read_event_at(candidate);
  while (!event) {
    const std::optional<int64_t> sync = find_sync(candidate + 1);
    if (!sync) break;
    candidate = *sync;
    event = read_event_at(candidate);
  }
  const int64_t skipped = (event ? candidate : size_) - position_;
  if (skipped > 0) {
    if (damage_.first_offset < 0) damage_.first_offset = position_;
    ++damage_.places;
    damage_.bytes_skipped += skipped;
  }
  position_ = event ? candidate + kHeaderBytes + static_cast<int64_t>(event->channel.size()) +
                          static_cast<int64_t>(event->bytes.size())
                    : size_;
  return event;
}

EventLogWriter::EventLogWriter(const std::string& path)
    : file_(std::fopen(path.c_str(), "wb")), path_(path) {
  if (!file_) throw std::runtime_error(path + ": cannot be created: " + std::strerror(errno));
}

void EventLogWriter::write(const std::string& channel,
                           std::span<const uint8_t> bytes,
                           Utime event_time) {
  require(!channel.empty() && channel.size() <= kMaxChannelBytes,
          "a channel name has 1 to 63 bytes");
  std::array<uint8_t, kHeaderBytes> header{};
  uint8_t* to = write_big_endian(header.data(), kSync);
  to = write_big_endian(to, next_number_);
  to = write_big_endian(to, event_time.us);
  to = write_big_endian(to, static_cast<uint32_t>(channel.size()));
  write_big_endian(to, static_cast<uint32_t>(bytes.size()));
  const bool written =
      std::fwrite(header.data(), 1, header.size(), file_.get()) == header.size() &&
      std::fwrite(channel.data(), 1, channel.size(), file_.get()) == channel.size() &&
      std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) == bytes.size();
  if (!written) throw std::runtime_error(path_ + ": cannot be written: " + std::strerror(errno));
  ++next_number_;
}

void EventLogWriter::flush() {
  if (std::fflush(file_.get()) != 0) {
    throw std::runtime_error(path_ + ": cannot be written: " + std::strerror(errno));
  }
}

}  // namespace marco::files
