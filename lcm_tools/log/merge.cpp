#include "lcm_tools/log/merge.hpp"

#include <memory>
#include <queue>

namespace marco::logs {
namespace {

struct Source {
  explicit Source(const MergeInput& given) : input(given), reader(given.path.string()) {}
  bool advance() {
    head = reader.next_head();
    return head.has_value();
  }
  Utime time() const { return bounded(head->event_time) + input.shift; }

  const MergeInput& input;
  files::EventLogReader reader;
  std::optional<files::LogEventHead> head;
};

}  // namespace

MergeResult merge_logs(const std::vector<MergeInput>& inputs,
                       OutputFile& out,
                       const OnProgress& on_progress) {
  constexpr int64_t kEventsBetweenProgress = 4096;
  MergeResult result;
  result.events.assign(inputs.size(), 0);
  std::vector<std::unique_ptr<Source>> sources;
  double total_bytes = 0.0;
  const auto is_later = [&sources](std::size_t a, std::size_t b) {
    const Utime time_a = sources[a]->time(), time_b = sources[b]->time();
    return time_a != time_b ? time_a > time_b : a > b;
  };
  std::priority_queue<std::size_t, std::vector<std::size_t>, decltype(is_later)> next(is_later);
  for (const MergeInput& input : inputs) {
    sources.push_back(std::make_unique<Source>(input));
    total_bytes += static_cast<double>(sources.back()->reader.size_bytes());
    if (sources.back()->advance()) next.push(sources.size() - 1);
  }
  int64_t number = 0;
  std::string channel;
  while (!next.empty()) {
    const std::size_t index = next.top();
    next.pop();
    Source& source = *sources[index];
    channel = source.input.prefix;
    channel += source.head->channel;
    const auto bytes = source.reader.data();
    out.write(files::event_header(number, source.time(), channel, bytes.size()));
    out.write(channel);
    out.write(bytes);
    ++result.events[index];
    if (++number % kEventsBetweenProgress == 0) {
      on_progress(static_cast<double>(out.size_bytes()) / total_bytes);
    }
    if (source.advance()) next.push(index);
  }
  for (const auto& source : sources) result.damage.push_back(source->reader.damage());
  return result;
}

}  // namespace marco::logs
