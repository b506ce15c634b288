#include "lcm_tools/files/event_log.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/readable.hpp"

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

bool printable(std::string_view channel) {
  return std::all_of(channel.begin(), channel.end(), [](char c) { return c > 32 && c < 127; });
}

constexpr int64_t kLargestStepBytes = 256 << 10;
constexpr int64_t kSmallestStepBytes = 4 << 10;
constexpr int64_t kJumpBytes = 16 << 10;
constexpr int64_t kSearchBytes = 128 << 10;
constexpr std::array<uint8_t, 4> kSyncBytes = {0xED, 0xA1, 0xDA, 0x01};

}  // namespace

EventLogReader::Descriptor::Descriptor(const std::string& path) {
  const std::string why = why_not_readable(path);
  require(why.empty(), path + ": cannot be read as a log: " + why);
  descriptor_ = open(path.c_str(), O_RDONLY | O_CLOEXEC);
}

EventLogReader::Descriptor::~Descriptor() { close(descriptor_); }

EventLogReader::EventLogReader(const std::string& path) : file_(path) {
  struct stat status = {};
  require(fstat(file_.get(), &status) == 0 && S_ISREG(status.st_mode),
          path + ": cannot be read as a log (not a file)");
  size_ = status.st_size;
}

bool EventLogReader::read_at(int64_t offset, std::span<uint8_t> bytes) const {
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t got = pread(file_.get(), bytes.data() + done, bytes.size() - done,
                              offset + static_cast<int64_t>(done));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    done += static_cast<std::size_t>(got);
  }
  return true;
}

// Bytes of the file in memory; null beyond its end.
const uint8_t* EventLogReader::view(int64_t offset, int64_t count) {
  if (offset < 0 || count > size_ - offset) return nullptr;
  if (offset >= window_start_ && offset + count <= window_start_ + window_bytes_) {
    return window_.data() + (offset - window_start_);
  }
  // After a jump over the data of a large event, read only what the next header needs. Without
  // jumps the steps soon grow again.
  const int64_t gap = offset - (window_start_ + window_bytes_);
  const bool jump = gap > kJumpBytes || offset < window_start_;
  step_bytes_ = jump ? kSmallestStepBytes : std::min(kLargestStepBytes, 2 * step_bytes_);
  const int64_t wanted = std::min(std::max(count, step_bytes_), size_ - offset);
  if (window_.size() < static_cast<std::size_t>(wanted)) {
    window_.resize(static_cast<std::size_t>(wanted));
  }
  window_bytes_ = 0;
  if (!read_at(offset, {window_.data(), static_cast<std::size_t>(wanted)})) return nullptr;
  window_start_ = offset;
  window_bytes_ = wanted;
  return window_.data();
}

// Fills head_ with the event at `offset`, if a whole one is there.
bool EventLogReader::read_head_at(int64_t offset) {
  const uint8_t* bytes = view(offset, kHeaderBytes);
  if (bytes == nullptr) return false;
  const Header header(bytes);
  const int64_t end = offset + header.event_bytes();
  if (!header.plausible() || end > size_) return false;
  const std::size_t first = std::min<std::size_t>(header.data_bytes, first_bytes_.size());
  bytes = view(offset + kHeaderBytes, static_cast<int64_t>(header.channel_bytes + first));
  if (bytes == nullptr) return false;
  const auto* name = reinterpret_cast<const char*>(bytes);
  if (!printable({name, header.channel_bytes})) return false;
  channel_.assign(name, header.channel_bytes);
  std::copy_n(bytes + header.channel_bytes, first, first_bytes_.begin());
  if (!followed_by_event(end) && contains_head(offset + kHeaderBytes, end)) return false;
  head_.offset = offset;
  head_.number = header.number;
  head_.event_time = Utime::from_us(header.time_us);
  head_.channel = channel_;
  head_.data_bytes = header.data_bytes;
  head_.first_bytes = {first_bytes_.data(), first};
  return true;
}

bool EventLogReader::followed_by_event(int64_t end) {
  if (end + 4 > size_) return true;
  if (end >= window_start_ && end + 4 <= window_start_ + window_bytes_) {
    return read_big_endian<uint32_t>(window_.data() + (end - window_start_)) == kSync;
  }
  // Bypasses the window, which keeps the event's data.
  std::array<uint8_t, 4> sync{};
  return read_at(end, sync) && sync == kSyncBytes;
}

bool EventLogReader::contains_head(int64_t from, int64_t end) {
  // A damaged length that still points inside the file swallows the headers of other events.
  for (auto sync = find_sync(from, end); sync; sync = find_sync(*sync + 1, end)) {
    const uint8_t* bytes = view(*sync, kHeaderBytes);
    if (bytes != nullptr && Header(bytes).plausible()) return true;
  }
  return false;
}

// The first sync word that begins in [from, end).
std::optional<int64_t> EventLogReader::find_sync(int64_t from, int64_t end) {
  constexpr int64_t kOverlap = 3;
  const int64_t last = std::min(end + kOverlap, size_);
  for (int64_t start = from; start + 4 <= last; start += kSearchBytes - kOverlap) {
    start = std::max(start, next_data(file_.get(), start) - kOverlap);
    if (start + 4 > last) return std::nullopt;
    if (on_search_) on_search_(start);
    const int64_t count = std::min(kSearchBytes, last - start);
    const uint8_t* block = view(start, count);
    if (block == nullptr) return std::nullopt;
    const void* found =
        memmem(block, static_cast<std::size_t>(count), kSyncBytes.data(), kSyncBytes.size());
    if (found != nullptr) return start + (static_cast<const uint8_t*>(found) - block);
  }
  return std::nullopt;
}

std::optional<int64_t> EventLogReader::find_whole_event(int64_t from) {
  for (auto sync = find_sync(from, size_); sync; sync = find_sync(*sync + 1, size_)) {
    if (read_head_at(*sync)) return sync;
  }
  return std::nullopt;
}

void EventLogReader::seek(int64_t offset) {
  position_ = find_whole_event(std::max<int64_t>(0, offset)).value_or(size_);
}

std::optional<LogEventHead> EventLogReader::next_head() {
  head_.data_bytes = 0;
  if (position_ >= size_) return std::nullopt;
  const bool here = read_head_at(position_);
  const int64_t start = here ? position_ : find_whole_event(position_ + 1).value_or(size_);
  head_.skipped_bytes = start - position_;
  if (head_.skipped_bytes > 0) {
    if (damage_.first_offset < 0) damage_.first_offset = position_;
    ++damage_.places;
    damage_.bytes_skipped += head_.skipped_bytes;
  }
  position_ = start < size_ ? head_.end_offset() : size_;
  if (start >= size_) return std::nullopt;
  return head_;
}

std::span<const uint8_t> EventLogReader::data() {
  const uint8_t* bytes = view(head_.data_offset(), head_.data_bytes);
  if (bytes == nullptr) return {};
  return {bytes, static_cast<std::size_t>(head_.data_bytes)};
}

std::optional<LogEvent> EventLogReader::next() {
  const std::optional<LogEventHead> head = next_head();
  if (!head) return std::nullopt;
  const std::span<const uint8_t> bytes = data();
  LogEvent event;
  event.number = head->number;
  event.event_time = head->event_time;
  event.channel = head->channel;
  event.bytes.assign(bytes.begin(), bytes.end());
  return event;
}

std::array<uint8_t, 28> event_header(int64_t number,
                                     Utime event_time,
                                     std::string_view channel,
                                     std::size_t data_bytes) {
  require(!channel.empty() && channel.size() <= kMaxChannelBytes,
          "a channel name has 1 to 63 bytes");
  std::array<uint8_t, kHeaderBytes> header{};
  uint8_t* to = write_big_endian(header.data(), kSync);
  to = write_big_endian(to, number);
  to = write_big_endian(to, event_time.us);
  to = write_big_endian(to, static_cast<uint32_t>(channel.size()));
  write_big_endian(to, static_cast<uint32_t>(data_bytes));
  return header;
}

EventLogWriter::EventLogWriter(const std::string& path)
    : own_(std::make_unique<OutputFile>(path, Appears::at_once)), out_(own_.get()) {}

void EventLogWriter::write(std::string_view channel,
                           std::span<const uint8_t> bytes,
                           Utime event_time) {
  out_->write(event_header(next_number_, event_time, channel, bytes.size()));
  out_->write(channel);
  out_->write(bytes);
  ++next_number_;
}

}  // namespace marco::files
