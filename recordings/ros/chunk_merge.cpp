#include "recordings/ros/chunk_merge.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace marco::ros {
namespace {

constexpr std::size_t kMostOpen = 32;

}  // namespace

ChunkMerge::ChunkMerge(std::vector<ChunkPlace> places, Load load)
    : places_(std::move(places)), by_start_(places_.size()), load_(std::move(load)) {
  std::iota(by_start_.begin(), by_start_.end(), std::size_t{0});
  std::stable_sort(by_start_.begin(), by_start_.end(), [this](std::size_t a, std::size_t b) {
    return places_[a].start_ns < places_[b].start_ns;
  });
}

void ChunkMerge::rewind() {
  begun_ = 0;
  open_.clear();
}

double ChunkMerge::progress() const {
  return by_start_.empty() ? 1.0
                           : static_cast<double>(begun_) / static_cast<double>(by_start_.size());
}

std::vector<ChunkMerge::Open>::iterator ChunkMerge::earliest() {
  return std::min_element(open_.begin(), open_.end(), [](const Open& a, const Open& b) {
    return std::pair(a.chunk.entries[a.next].received_ns, a.place) <
           std::pair(b.chunk.entries[b.next].received_ns, b.place);
  });
}

void ChunkMerge::close_read() {
  std::erase_if(open_, [this](Open& open) {
    if (open.next < open.chunk.entries.size()) return false;
    spare_.push_back(std::move(open.chunk));
    return true;
  });
}

// All chunks that may hold a message before the earliest one at hand.
void ChunkMerge::open_due() {
  while (begun_ < by_start_.size() && open_.size() < kMostOpen) {
    const std::size_t place = by_start_[begun_];
    if (!open_.empty()) {
      const auto first = earliest();
      const int64_t at_ns = first->chunk.entries[first->next].received_ns;
      if (places_[place].start_ns > at_ns) break;
    }
    LoadedChunk memory;
    if (!spare_.empty()) {
      memory = std::move(spare_.back());
      spare_.pop_back();
    }
    open_.push_back({place, load_(place, std::move(memory))});
    ++begun_;
    auto& entries = open_.back().chunk.entries;
    const auto is_before = [](const auto& a, const auto& b) {
      return a.received_ns < b.received_ns;
    };
    if (!std::is_sorted(entries.begin(), entries.end(), is_before)) {
      std::stable_sort(entries.begin(), entries.end(), is_before);
    }
    close_read();  // an empty one
  }
}

std::optional<ChunkMerge::Item> ChunkMerge::next() {
  close_read();
  open_due();
  if (open_.empty()) return std::nullopt;
  const auto first = earliest();
  const LoadedChunk::Entry& entry = first->chunk.entries[first->next++];
  return Item{entry, first->chunk.bytes.bytes().subspan(entry.offset, entry.size)};
}

}  // namespace marco::ros
