#include "recordings/ros/chunked_source.hpp"

#include <zlib.h>

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "lcm_tools/base/check.hpp"

namespace marco::ros {
namespace {

// Small enough for a processor's cache, large enough for a scan.
constexpr std::size_t kPiece = std::size_t{1} << 22;

}  // namespace

void PlainWindow::begin(Unpacker& unpacker, bool with_crc) {
  constexpr std::size_t kMostKept = 16 * kPiece;  // one large message is no reason to stay large
  if (buffer_.size() > kMostKept) buffer_ = {};
  unpacker_ = &unpacker;
  from_ = held_ = 0;
  unpacked_ = 0;
  with_crc_ = with_crc;
  crc_ = 0;
}

bool PlainWindow::skip(uint64_t count) {
  while (count > held_) {
    count -= held_;
    from_ = 0;
    held_ = unpack(buffer_.resize(std::max(kPiece, buffer_.size())));
    if (held_ == 0) return false;
  }
  from_ += static_cast<std::size_t>(count);
  held_ -= static_cast<std::size_t>(count);
  return true;
}

// The buffer grows as the bytes come: a damaged length may ask for more than there is.
void PlainWindow::fill(std::size_t count) {
  if (from_ > 0)
    std::memmove(buffer_.resize(buffer_.size()).data(), buffer_.bytes().data() + from_, held_);
  from_ = 0;
  while (held_ < count) {
    const std::size_t wanted = std::min(count, 2 * held_);
    const auto room = buffer_.resize(std::max({kPiece, buffer_.size(), wanted})).subspan(held_);
    const std::size_t got = unpack(room);
    if (got == 0) return;
    held_ += got;
  }
}

std::size_t PlainWindow::unpack(std::span<uint8_t> into) {
  const std::size_t got = unpacker_->read(into);
  if (with_crc_) crc_ = static_cast<uint32_t>(::crc32_z(crc_, into.data(), got));
  unpacked_ += got;
  return got;
}

void ChunkedSource::set_chunks(std::vector<ChunkPlace> places, const Damage& damage) {
  places_ = std::move(places);
  damage_between_ = damage;
}

void ChunkedSource::select(std::function<bool(const Topic&)> is_wanted) {
  is_wanted_ = std::move(is_wanted);
  rewind();
}

std::optional<Message> ChunkedSource::next() {
  while (const auto message = merge_->next()) {
    const auto topic = topics_.find(message->topic);
    if (topic == topics_.end() || !is_needed(message->topic)) continue;
    return Message{&topic->second, message->received_ns, message->published_ns,
                   plain(message->bytes)};
  }
  if (merge_->runs() > 0) {
    note_once(notes_, "overlapping chunks contain more than " +
                          std::to_string(most_held_bytes_ >> 20U) + " MB: sorted on disk");
  }
  // Parts of a recording are all open, and read one after the other.
  window_ = PlainWindow();
  unpacker_ = Unpacker();
  return std::nullopt;
}

void ChunkedSource::rewind() {
  damage_ = damage_between_;
  counted_damage_.clear();
  asked_.reset();
  std::vector<uint32_t> used;
  for (uint32_t i = 0; i < places_.size(); ++i) {
    if (may_have_wanted(i)) used.push_back(i);
  }
  merge_ = std::make_unique<ChunkMerge>(
      places_, std::move(used), [this](std::size_t i, const Keep& keep) { load(i, keep); },
      most_held_bytes_);
}

bool ChunkedSource::is_needed(uint32_t topic) const {
  if (asked_ && asked_->first == topic) return asked_->second;
  const auto found = topics_.find(topic);
  if (found == topics_.end()) return true;
  asked_.emplace(topic, is_wanted(found->second));
  return asked_->second;
}

void ChunkedSource::set_topic(Topic topic) {
  std::size_t bytes = sizeof topic + topic.name.size() + topic.schema.size();
  for (const auto& [key, value] : topic.metadata) bytes += sizeof topic + key.size() + value.size();
  count_topic_bytes(bytes);
  asked_.reset();
  topics_.insert_or_assign(topic.id, std::move(topic));
}

void ChunkedSource::count_topic_bytes(std::size_t bytes) {
  topic_bytes_ += bytes;
  require(topic_bytes_ <= kMostTopicBytes, path_ + kTooManyTopics);
}

// A chunk whose topics are not all known has to be looked into.
bool ChunkedSource::may_have_wanted(std::size_t chunk) const {
  const std::vector<uint32_t> ids = topics_in(chunk);
  return ids.empty() || std::any_of(ids.begin(), ids.end(), [this](uint32_t id) {
           const auto topic = topics_.find(id);
           return topic == topics_.end() || topic->second.type.empty() || is_wanted(topic->second);
         });
}

std::optional<TimeSpan> ChunkedSource::span() const {
  std::optional<TimeSpan> span;
  for (const ChunkPlace& place : places_) {
    if (place.end_ns == 0) continue;  // no message in it
    if (!span) span = TimeSpan{place.start_ns, place.end_ns};
    span->first_ns = std::min(span->first_ns, place.start_ns);
    span->last_ns = std::max(span->last_ns, place.end_ns);
  }
  return span;
}

std::vector<const Topic*> ChunkedSource::topics() const {
  std::vector<const Topic*> topics;
  for (const auto& [id, topic] : topics_) topics.push_back(&topic);
  return topics;
}

void ChunkedSource::note_damage(std::size_t chunk, uint64_t bytes) {
  if (!counted_damage_.insert(chunk).second) return;
  if (damage_.places++ == 0) damage_.first_offset = places_[chunk].offset;
  damage_.bytes += static_cast<int64_t>(bytes);
}

void ChunkedSource::note_lost(std::size_t chunk, const std::string& why) {
  note_damage(chunk, static_cast<uint64_t>(places_[chunk].size));
  note_once(notes_, "damaged chunks: " + why);
}

bool ChunkedSource::open(std::size_t chunk,
                         const std::string& compression,
                         uint64_t plain_size,
                         bool with_crc) {
  packed_.begin(file_, places_[chunk].offset, places_[chunk].size);
  try {
    unpacker_.begin(compression, packed_, plain_size);
  } catch (const std::invalid_argument& fault) {
    note_lost(chunk, fault.what());
    return false;
  }
  window_.begin(unpacker_, with_crc);
  return true;
}

bool ChunkedSource::leave_out(uint64_t record_bytes) {
  if (!window_.skip(record_bytes)) return false;
  note_once(notes_, kTooLarge);
  return true;
}

}  // namespace marco::ros
