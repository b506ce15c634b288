#include "recordings/ros/chunked_source.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace marco::ros {

void ChunkedSource::set_chunks(std::vector<ChunkPlace> places, const Damage& damage) {
  places_ = std::move(places);
  damage_between_ = damage;
}

void ChunkedSource::select(std::function<bool(const Topic&)> is_wanted) {
  is_wanted_ = std::move(is_wanted);
  rewind();
}

std::optional<Message> ChunkedSource::next() {
  while (auto item = merge_->next()) {
    const LoadedChunk::Entry& entry = item->entry;
    const auto topic = topics_.find(entry.topic);
    if (topic == topics_.end() || !is_wanted(topic->second)) continue;
    return Message{&topic->second, entry.received_ns, entry.published_ns, plain(item->bytes)};
  }
  return std::nullopt;
}

void ChunkedSource::rewind() {
  damage_ = damage_between_;
  counted_damage_.clear();
  used_.clear();
  std::vector<ChunkPlace> places;
  for (std::size_t i = 0; i < places_.size(); ++i) {
    if (!may_have_wanted(i)) continue;
    used_.push_back(i);
    places.push_back(places_[i]);
  }
  merge_ = std::make_unique<ChunkMerge>(
      std::move(places),
      [this](std::size_t i, LoadedChunk memory) { return load(used_[i], std::move(memory)); });
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

std::optional<Unpacker::Checksum> ChunkedSource::unpack(std::size_t chunk,
                                                        const std::string& compression,
                                                        uint64_t plain_size,
                                                        ByteBuffer& plain) {
  file_.read(places_[chunk].offset, places_[chunk].size, packed_);
  try {
    return unpacker_.unpack(compression, packed_.bytes(), plain_size, plain);
  } catch (const std::invalid_argument& fault) {
    note_lost(chunk, fault.what());
    return std::nullopt;
  }
}

}  // namespace marco::ros
