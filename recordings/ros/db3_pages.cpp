#include "recordings/ros/db3_pages.hpp"

#include <algorithm>

#include "recordings/ros/message_source.hpp"

namespace marco::ros {
namespace {

constexpr std::size_t kHeaderBytes = 100;
constexpr uint8_t kLeafOfTable = 0x0D;
constexpr std::size_t kLeafHeaderBytes = 8;

/// Numbers of sqlite: the most significant byte first.
class BigEndian {
 public:
  explicit BigEndian(std::span<const uint8_t> bytes) : bytes_(bytes) {}

  bool failed() const { return failed_; }
  std::size_t at() const { return at_; }
  std::span<const uint8_t> rest() const { return bytes_.subspan(at_); }
  uint64_t number(std::size_t size) {
    if (size > bytes_.size() - at_) {
      failed_ = true;
      return 0;
    }
    uint64_t value = 0;
    for (std::size_t i = 0; i < size; ++i) value = (value << 8U) | bytes_[at_++];
    return value;
  }
  // Seven bits a byte, and eight of the ninth.
  uint64_t varint() {
    uint64_t value = 0;
    for (int i = 0; i < 9; ++i) {
      const uint64_t byte = number(1);
      if (i == 8) return (value << 8U) | byte;
      value = (value << 7U) | (byte & 0x7FU);
      if (failed_ || byte < 0x80) break;
    }
    return value;
  }
  // Of a serial type that is a number.
  std::optional<int64_t> integer(uint64_t type) {
    constexpr std::size_t kSizes[] = {0, 1, 2, 3, 4, 6, 8};
    if (type == 8 || type == 9) return static_cast<int64_t>(type - 8);
    if (type == 0 || type > 6) return std::nullopt;
    const std::size_t size = kSizes[type];
    const unsigned shift = 8U * static_cast<unsigned>(8 - size);
    const int64_t value = static_cast<int64_t>(number(size) << shift) >> shift;
    return failed_ ? std::nullopt : std::optional(value);
  }

 private:
  std::span<const uint8_t> bytes_;
  std::size_t at_ = 0;
  bool failed_ = false;
};

// Of {id as NULL, topic, time, bytes}, as no other table of a recording is.
bool read_record(std::span<const uint8_t> payload, Db3Row& row) {
  BigEndian header(payload);
  const uint64_t header_size = header.varint();
  const uint64_t id = header.varint(), topic = header.varint(), time = header.varint(),
                 data = header.varint();
  if (header.failed() || header.at() != header_size || id != 0) return false;
  BigEndian body(payload.subspan(header.at()));
  const auto topic_id = body.integer(topic), time_ns = body.integer(time);
  const bool is_blob = data >= 12 && data % 2 == 0;
  if (!topic_id || !time_ns || !is_blob || body.rest().size() != (data - 12) / 2) return false;
  row.topic = *topic_id;
  row.time_ns = *time_ns;
  row.data.assign(body.rest().begin(), body.rest().end());
  return true;
}

}  // namespace

Db3Pages::Db3Pages(const std::filesystem::path& path) : file_(path) {
  const auto header = file_.bytes(0, kHeaderBytes);
  const auto number = [&header](std::size_t at, std::size_t size) {
    BigEndian in{std::span<const uint8_t>(header).subspan(std::min(at, header.size()))};
    return static_cast<int64_t>(in.number(size));
  };
  constexpr int64_t kSixtyFourK = 1;
  const int64_t told = number(16, 2);
  page_bytes_ = told == kSixtyFourK ? 65536 : told;
  usable_bytes_ = page_bytes_ - number(20, 1);
  pages_told_ = number(28, 4);
}

int64_t Db3Pages::missing_bytes() const {
  return std::max<int64_t>(0, pages_told_ * page_bytes_ - file_.size());
}

bool Db3Pages::next_page() {
  constexpr int64_t kLeastBytes = 480;  // by the format's definition
  if (usable_bytes_ < kLeastBytes) return false;
  while ((page_ + 1) * page_bytes_ <= file_.size()) {
    bytes_ = file_.bytes(page_++ * page_bytes_, page_bytes_);
    if (bytes_.size() < kLeafHeaderBytes || bytes_[0] != kLeafOfTable) continue;
    cells_ =
        static_cast<std::size_t>(BigEndian(std::span<const uint8_t>(bytes_).subspan(3)).number(2));
    cell_ = 0;
    if (kLeafHeaderBytes + 2 * cells_ <= bytes_.size()) return true;
  }
  return false;
}

std::optional<Db3Row> Db3Pages::next() {
  while (true) {
    while (cell_ < cells_) {
      BigEndian pointer{std::span<const uint8_t>(bytes_).subspan(kLeafHeaderBytes + 2 * cell_++)};
      if (auto row = row_at(static_cast<std::size_t>(pointer.number(2)))) return row;
    }
    if (!next_page()) return std::nullopt;
  }
}

std::optional<Db3Row> Db3Pages::row_at(std::size_t at) {
  if (at >= static_cast<std::size_t>(usable_bytes_)) return std::nullopt;
  BigEndian cell{std::span<const uint8_t>(bytes_).subspan(at)};
  const uint64_t size = cell.varint();
  Db3Row row;
  row.id = static_cast<int64_t>(cell.varint());
  // What of the payload stands in its page.
  const auto usable = static_cast<uint64_t>(usable_bytes_);
  const uint64_t most = usable - 35, least = (usable - 12) * 32 / 255 - 23;
  const auto file_bytes = static_cast<uint64_t>(file_.size());
  if (cell.failed() || size > std::min(file_bytes, kMostMessageBytes)) return std::nullopt;
  uint64_t here = size;
  if (size > most) {
    here = least + (size - least) % (usable - 4);
    if (here > most) here = least;
  }
  if (here > cell.rest().size()) return std::nullopt;
  std::vector<uint8_t> payload(cell.rest().begin(),
                               cell.rest().begin() + static_cast<std::ptrdiff_t>(here));
  if (here < size) {
    BigEndian next(cell.rest().subspan(static_cast<std::size_t>(here)));
    const uint64_t page = next.number(4);
    if (next.failed() || !append_overflow(page, size, payload)) return std::nullopt;
  }
  if (!read_record(payload, row)) return std::nullopt;
  return row;
}

bool Db3Pages::append_overflow(uint64_t page, uint64_t size, std::vector<uint8_t>& payload) {
  const int64_t pages = file_.size() / page_bytes_;
  const auto usable = static_cast<std::size_t>(usable_bytes_);
  while (payload.size() < size) {
    // Each belongs to one row: more of them go round.
    if (page < 2 || page > static_cast<uint64_t>(pages) || ++overflow_pages_ > 2 * pages)
      return false;
    const auto bytes = file_.bytes((static_cast<int64_t>(page) - 1) * page_bytes_, page_bytes_);
    if (bytes.size() < usable) return false;
    const std::size_t wanted =
        std::min<std::size_t>(static_cast<std::size_t>(size) - payload.size(), usable - 4);
    payload.insert(payload.end(), bytes.begin() + 4,
                   bytes.begin() + 4 + static_cast<std::ptrdiff_t>(wanted));
    page = BigEndian(bytes).number(4);
  }
  return true;
}

}  // namespace marco::ros
