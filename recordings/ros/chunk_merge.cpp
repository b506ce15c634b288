#include "recordings/ros/chunk_merge.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <tuple>
#include <utility>

#include "recordings/ros/byte_buffer.hpp"
#include "recordings/ros/byte_file.hpp"
#include "recordings/ros/temporary_file.hpp"

namespace marco::ros {

/// Messages in order, the first of them at hand.
class ChunkMerge::Stream {
 public:
  struct Head {
    int64_t received_ns, published_ns;
    std::size_t chunk;
    uint32_t topic;
    uint64_t size;
  };

  explicit Stream(std::size_t number) : number_(number) {}
  virtual ~Stream() = default;
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;

  const Head& head() const { return head_; }
  virtual std::span<const uint8_t> bytes() = 0;
  /// To the next one. @returns false at the end.
  virtual bool advance() = 0;
  virtual InMemory* in_memory() { return nullptr; }

  /// Of two parts of one chunk the one that was read first has the lower number.
  auto order() const { return std::tuple(head_.received_ns, head_.chunk, number_); }
  ChunkMessage message() { return {head_.received_ns, head_.published_ns, head_.topic, bytes()}; }

 protected:
  Head head_{};

 private:
  std::size_t number_;
};

/// A chunk, or what was read of it.
class ChunkMerge::InMemory : public Stream {
 public:
  InMemory(std::size_t number, std::size_t chunk, std::unique_ptr<InMemory> spare)
      : Stream(number) {
    if (spare) std::swap(bytes_, spare->bytes_);
    if (spare) std::swap(entries_, spare->entries_);
    entries_.clear();
    bytes_.resize(0);
    head_.chunk = chunk;
  }

  /// @returns the bytes that this takes
  std::size_t add(const ChunkMessage& message) {
    const std::size_t at = bytes_.size();
    entries_.push_back(
        {message.received_ns, message.published_ns, message.topic, at, message.bytes.size()});
    const auto room = bytes_.resize(at + message.bytes.size()).subspan(at);
    std::copy(message.bytes.begin(), message.bytes.end(), room.begin());
    return size_of(message.bytes.size());
  }
  /// After the last add(). @returns false without messages
  bool begin() {
    const auto is_before = [](const Entry& a, const Entry& b) {
      return a.received_ns < b.received_ns;
    };
    if (!std::is_sorted(entries_.begin(), entries_.end(), is_before)) {
      std::stable_sort(entries_.begin(), entries_.end(), is_before);
    }
    next_ = 0;
    return advance();
  }
  std::size_t size_bytes() const { return bytes_.size() + entries_.size() * size_of(0); }
  std::size_t chunk() const { return head_.chunk; }

  std::span<const uint8_t> bytes() override {
    return bytes_.bytes().subspan(entries_[next_ - 1].offset, head_.size);
  }
  bool advance() override {
    if (next_ == entries_.size()) return false;
    const Entry& entry = entries_[next_++];
    head_ = {entry.received_ns, entry.published_ns, head_.chunk, entry.topic, entry.size};
    return true;
  }
  InMemory* in_memory() override { return this; }

 private:
  struct Entry {
    int64_t received_ns, published_ns;
    uint32_t topic;
    std::size_t offset, size;
  };
  static std::size_t size_of(std::size_t message_bytes) { return sizeof(Entry) + message_bytes; }

  ByteBuffer bytes_;
  std::vector<Entry> entries_;
  std::size_t next_ = 0;
};

/// Messages of many chunks: heads and bytes, one after the other.
class ChunkMerge::OnDisk : public Stream {
 public:
  explicit OnDisk(std::size_t number) : Stream(number), written_("to sort overlapping chunks") {}

  void add(const Head& head, std::span<const uint8_t> bytes) {
    constexpr std::size_t kPiece = std::size_t{1} << 20;
    const auto* raw = reinterpret_cast<const uint8_t*>(&head);
    pending_.insert(pending_.end(), raw, raw + sizeof head);
    if (pending_.size() + bytes.size() >= kPiece) write();
    if (bytes.size() >= kPiece) return written_.append(bytes);
    pending_.insert(pending_.end(), bytes.begin(), bytes.end());
  }
  /// After the last add().
  void begin() {
    write();
    pending_ = {};
    file_.emplace(written_.path());
    advance();
  }

  std::span<const uint8_t> bytes() override { return file_->peek(at_, head_.size); }
  bool advance() override {
    at_ += static_cast<int64_t>(head_.size);
    const auto raw = file_->peek(at_, sizeof head_);
    if (raw.size() < sizeof head_) return false;
    std::memcpy(&head_, raw.data(), sizeof head_);
    at_ += static_cast<int64_t>(sizeof head_);
    return true;
  }

 private:
  void write() {
    written_.append(pending_);
    pending_.clear();
  }

  TemporaryFile written_;
  std::vector<uint8_t> pending_;
  std::optional<ByteFile> file_;
  int64_t at_ = 0;
};

struct ChunkMerge::IsLater {
  bool operator()(const std::unique_ptr<Stream>& a, const std::unique_ptr<Stream>& b) const {
    return a->order() > b->order();
  }
};

ChunkMerge::ChunkMerge(std::span<const ChunkPlace> places,
                       std::vector<uint32_t> used,
                       Load load,
                       std::size_t most_held_bytes)
    : places_(places),
      by_start_(std::move(used)),
      load_(std::move(load)),
      most_held_bytes_(most_held_bytes) {
  std::stable_sort(by_start_.begin(), by_start_.end(), [this](uint32_t a, uint32_t b) {
    return places_[a].start_ns < places_[b].start_ns;
  });
}

ChunkMerge::~ChunkMerge() = default;

double ChunkMerge::progress() const {
  return by_start_.empty() ? 1.0
                           : static_cast<double>(begun_) / static_cast<double>(by_start_.size());
}

bool ChunkMerge::is_due(int64_t at_ns) const {
  return begun_ < by_start_.size() && places_[by_start_[begun_]].start_ns <= at_ns;
}

void ChunkMerge::push(std::unique_ptr<Stream> stream) {
  heap_.push_back(std::move(stream));
  std::push_heap(heap_.begin(), heap_.end(), IsLater());
}

std::unique_ptr<ChunkMerge::Stream> ChunkMerge::pop() {
  std::pop_heap(heap_.begin(), heap_.end(), IsLater());
  auto stream = std::move(heap_.back());
  heap_.pop_back();
  return stream;
}

void ChunkMerge::keep(const ChunkMessage& message) {
  const bool is_too_much = held_bytes_ + message.bytes.size() > most_held_bytes_;
  if (is_too_much && held_bytes_ > 0) put_on_disk();
  held_bytes_ += loading_->add(message);
}

// All that is held, with what was read of the chunk at hand, becomes one run.
void ChunkMerge::put_on_disk() {
  std::vector<std::unique_ptr<Stream>> on_disk;
  const std::size_t chunk = loading_->chunk();
  if (loading_->begin()) push(std::move(loading_));
  auto run = std::make_unique<OnDisk>(made_++);
  while (!heap_.empty()) {
    auto stream = pop();
    if (stream->in_memory() == nullptr) {
      on_disk.push_back(std::move(stream));
      continue;
    }
    run->add(stream->head(), stream->bytes());
    if (stream->advance()) push(std::move(stream));
  }
  run->begin();
  ++runs_;
  push(std::move(run));
  for (auto& stream : on_disk) push(std::move(stream));
  held_bytes_ = 0;
  loading_ = std::make_unique<InMemory>(made_++, chunk, nullptr);
}

// All chunks that may hold a message before the earliest one at hand.
void ChunkMerge::load_due() {
  for (; is_due(heap_.empty() ? INT64_MAX : heap_.front()->head().received_ns); ++begun_) {
    const std::size_t chunk = by_start_[begun_];
    loading_ = std::make_unique<InMemory>(made_++, chunk, std::move(spare_));
    load_(chunk, [this](const ChunkMessage& message) { keep(message); });
    if (loading_->begin()) {
      push(std::move(loading_));
    } else {
      spare_ = std::move(loading_);
    }
  }
}

std::optional<ChunkMessage> ChunkMerge::next() {
  if (current_ != nullptr && current_->advance()) {
    const bool is_earliest = heap_.empty() || current_->order() < heap_.front()->order();
    if (is_earliest && !is_due(current_->head().received_ns)) return current_->message();
    push(std::move(current_));
  } else if (current_ != nullptr && current_->in_memory() != nullptr) {
    held_bytes_ -= current_->in_memory()->size_bytes();
    spare_.reset(static_cast<InMemory*>(current_.release()));
  } else {
    current_.reset();
  }
  load_due();
  if (heap_.empty()) {
    spare_.reset();
    return std::nullopt;
  }
  current_ = pop();
  return current_->message();
}

}  // namespace marco::ros
