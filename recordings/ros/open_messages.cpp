#include "recordings/ros/open_messages.hpp"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/readable.hpp"
#include "recordings/looking_through.hpp"
#include "recordings/ros/byte_stream.hpp"
#include "recordings/ros/compression.hpp"
#include "recordings/ros/file_sources.hpp"
#include "recordings/ros/mcap_records.hpp"
#include "recordings/ros/temporary_file.hpp"

namespace marco::ros {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kBagMagic = "#ROSBAG V", kDatabaseMagic = "SQLite format 3";

constexpr std::size_t kHeadBytes = 16;

std::string head_of(const fs::path& path) { return files::first_bytes(path, kHeadBytes); }

bool is_packed(std::string_view head) {
  return is_zstd({reinterpret_cast<const uint8_t*>(head.data()), head.size()});
}

bool is_container(std::string_view head) {
  return head.starts_with(kBagMagic) || head.starts_with(kMcapMagic) ||
         head.starts_with(kDatabaseMagic) || is_packed(head);
}

/// Parts of one recording, one after the other.
class Parts : public MessageSource {
 public:
  explicit Parts(std::vector<std::unique_ptr<MessageSource>> parts) : parts_(std::move(parts)) {}

  std::string format() const override { return parts_.front()->format(); }
  std::vector<std::string> paths() const override {
    std::vector<std::string> paths;
    for (const auto& part : parts_) {
      for (std::string& path : part->paths()) paths.push_back(std::move(path));
    }
    return paths;
  }
  void select(std::function<bool(const Topic&)> is_wanted) override {
    for (const auto& part : parts_) part->select(is_wanted);
    now_ = 0;
  }
  std::optional<Message> next() override {
    for (; now_ < parts_.size(); ++now_) {
      if (auto message = parts_[now_]->next()) return message;
    }
    return std::nullopt;
  }
  void rewind() override {
    for (const auto& part : parts_) part->rewind();
    now_ = 0;
  }
  std::optional<TimeSpan> span() const override {
    const auto first = parts_.front()->span(), last = parts_.back()->span();
    if (!first || !last) return std::nullopt;
    return TimeSpan{first->first_ns, last->last_ns};
  }
  std::vector<const Topic*> topics() const override {
    std::vector<const Topic*> topics;
    for (const auto& part : parts_) {
      for (const Topic* topic : part->topics()) topics.push_back(topic);
    }
    return topics;
  }
  const Damage& damage() const override {
    damage_ = {};
    for (const auto& part : parts_) {
      const Damage& of_part = part->damage();
      if (damage_.places == 0) damage_.first_offset = of_part.first_offset;
      damage_.places += of_part.places;
      damage_.bytes += of_part.bytes;
      damage_.is_cut_off = damage_.is_cut_off || of_part.is_cut_off;
    }
    return damage_;
  }
  const std::vector<std::string>& notes() const override {
    notes_.clear();
    for (const auto& part : parts_) {
      notes_.insert(notes_.end(), part->notes().begin(), part->notes().end());
    }
    return notes_;
  }
  double progress() const override {
    const double begun = static_cast<double>(std::min(now_, parts_.size() - 1));
    const double within = now_ < parts_.size() ? parts_[now_]->progress() : 1.0;
    return (begun + within) / static_cast<double>(parts_.size());
  }

 private:
  std::vector<std::unique_ptr<MessageSource>> parts_;
  std::size_t now_ = 0;
  mutable Damage damage_;
  mutable std::vector<std::string> notes_;
};

/// A source in a file that goes with it. A frame that ends too early gives what there is of it.
class Unpacked : public MessageSource {
 public:
  explicit Unpacked(const fs::path& packed)
      : packed_(packed.string()), file_("to unpack " + packed_) {
    unpack();
    source_ = open_messages(file_.path());
  }
  std::string format() const override { return source_->format() + " in zstd"; }
  std::vector<std::string> paths() const override { return {packed_}; }
  void select(std::function<bool(const Topic&)> is_wanted) override {
    source_->select(std::move(is_wanted));
  }
  std::optional<Message> next() override { return source_->next(); }
  void rewind() override { source_->rewind(); }
  std::optional<TimeSpan> span() const override { return source_->span(); }
  std::vector<const Topic*> topics() const override { return source_->topics(); }
  const Damage& damage() const override { return source_->damage(); }
  const std::vector<std::string>& notes() const override { return source_->notes(); }
  double progress() const override { return source_->progress(); }

 private:
  void unpack() {
    constexpr std::size_t kPiece = std::size_t{1} << 20;
    const ByteFile from(packed_);
    ByteStream bytes;
    bytes.begin(from, 0, from.size());
    Unpacker unpacker;
    unpacker.begin("zstd", bytes, UINT64_MAX);
    LookingThrough progress(packed_);
    std::vector<uint8_t> piece(kPiece);
    std::size_t head = kHeadBytes;  // still to come
    while (const std::size_t got = unpacker.read(piece)) {
      file_.append({piece.data(), got});
      progress.update(1.0 - static_cast<double>(bytes.left()) / static_cast<double>(from.size()));
      if (head > 0 && got >= head) require_recording();
      head -= std::min(head, got);
    }
    require_recording();
  }

  void require_recording() const {
    const std::string head = head_of(file_.path());
    require(!is_packed(head), packed_ + ": is compressed twice");
    require(is_container(head),
            packed_ + ": contains no ROS recording; decompress it with `unzstd`");
  }

  std::string packed_;
  TemporaryFile file_;
  std::unique_ptr<MessageSource> source_;
};

}  // namespace

bool is_message_file(const fs::path& path) { return is_container(head_of(path)); }

bool is_message_recording(const fs::path& path) {
  if (!fs::is_directory(path)) return is_message_file(path);
  const fs::directory_iterator inside(path);
  return std::any_of(fs::begin(inside), fs::end(inside), [](const fs::directory_entry& entry) {
    return is_message_file(entry.path());
  });
}

std::unique_ptr<MessageSource> open_messages(const fs::path& path) {
  if (fs::is_directory(path)) {
    const std::vector<RecordingParts> recordings = recordings_in(path);
    require(!recordings.empty(), path.string() + ": holds no recording");
    require_one(path, recordings);
    return open_messages(recordings.front());
  }
  const std::string head = head_of(path);
  if (head.starts_with(kBagMagic)) return open_bag(path);
  if (head.starts_with(kMcapMagic)) return open_mcap(path);
  if (head.starts_with(kDatabaseMagic)) return open_db3(path);
  require(is_packed(head), path.string() + ": is not a recording of ROS messages");
  return std::make_unique<Unpacked>(path);
}

std::unique_ptr<MessageSource> open_messages(const RecordingParts& parts) {
  if (parts.size() == 1) return open_messages(parts.front());
  std::vector<std::unique_ptr<MessageSource>> sources;
  for (const fs::path& part : parts) sources.push_back(open_messages(part));
  return std::make_unique<Parts>(std::move(sources));
}

}  // namespace marco::ros
