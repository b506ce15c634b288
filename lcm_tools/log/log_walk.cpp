#include "lcm_tools/log/log_walk.hpp"

namespace marco::logs {

WalkResult walk_log(WalkInput& input,
                    const Types& types,
                    const std::function<void(const DecodedEvent&)>& visit,
                    const OnProgress& on_progress) {
  constexpr int64_t kEventsBetweenProgress = 1024;
  WalkResult result;
  files::EventLogReader reader(input.path.string());
  lcm_schema::Tree tree;
  int64_t seen = 0;
  while (const auto head = reader.next_head()) {
    if (++seen % kEventsBetweenProgress == 0) {
      on_progress(static_cast<double>(head->offset) / static_cast<double>(reader.size_bytes()));
    }
    if (!input.range.contains(head->event_time) || !input.channels.keeps(head->channel)) continue;
    const auto bytes = reader.data();
    const int structure = types.decode(bytes, tree);
    ++result.events;
    if (structure < 0) ++result.undecodable;
    visit({*head, bytes, structure, tree});
  }
  result.damage = reader.damage();
  return result;
}

}  // namespace marco::logs
