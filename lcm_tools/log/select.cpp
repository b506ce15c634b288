#include "lcm_tools/log/select.hpp"

#include "lcm_tools/log/piece_copier.hpp"

namespace marco::logs {
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
