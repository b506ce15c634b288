#include "tools/log/select.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "common/check.hpp"

namespace marco::logs {
namespace {

// Joins neighbouring events, so that few large pieces are copied.
class PieceCopier {
 public:
  PieceCopier(const std::filesystem::path& in, OutputFile& out)
      : source_(open(in.c_str(), O_RDONLY | O_CLOEXEC)), out_(out) {
    require(source_ >= 0, in.string() + ": cannot be read: " + std::strerror(errno));
  }
  ~PieceCopier() { close(source_); }
  PieceCopier(const PieceCopier&) = delete;
  PieceCopier& operator=(const PieceCopier&) = delete;

  void add(int64_t from, int64_t to) {
    if (from != to_ || to_ - from_ > kLargestPiece) {
      copy();
      from_ = from;
    }
    to_ = to;
  }
  void copy() {
    if (to_ > from_) out_.copy_from(source_, from_, to_ - from_);
    from_ = to_;
  }

 private:
  // Small enough that what was just scanned is still in the page cache, and that progress moves.
  static constexpr int64_t kLargestPiece = 16 << 20;
  int source_;
  OutputFile& out_;
  int64_t from_ = 0;
  int64_t to_ = 0;
};

}  // namespace

SelectResult select_events(const std::filesystem::path& in,
                           OutputFile& out,
                           const TimeRange& range,
                           ChannelChoice& channels,
                           const OnProgress& on_progress) {
  constexpr int64_t kEventsBetweenProgress = 4096;
  SelectResult result;
  files::EventLogReader reader(in.string());
  PieceCopier copier(in, out);
  while (const auto head = reader.next_head()) {
    if (++result.events % kEventsBetweenProgress == 0) {
      on_progress(static_cast<double>(head->offset) / static_cast<double>(reader.size_bytes()));
    }
    if (!range.contains(head->event_time) || !channels.keeps(head->channel)) continue;
    ++result.kept;
    result.kept_bytes += head->end_offset() - head->offset;
    copier.add(head->offset, head->end_offset());
  }
  copier.copy();
  result.damage = reader.damage();
  return result;
}

}  // namespace marco::logs
