#include "web/model_parts.hpp"

#include <numeric>

#include "lcm_tools/schema/schema.hpp"
#include "lcm_tools/schema/wire.hpp"
#include "marco/mesh_t.hpp"

namespace marco::web {

bool ModelParts::put(const process::RawMessage& message) {
  constexpr std::size_t kRevisionAt = 16;
  const auto fingerprint = lcm_schema::fingerprint_of(message.bytes);
  if (!fingerprint || !lcm_schema::is_a<mesh_t>(*fingerprint)) return false;
  if (message.bytes.size() < kRevisionAt + sizeof(int64_t)) return false;
  const auto revision = lcm_schema::load<int64_t>(message.bytes.data() + kRevisionAt);
  std::erase_if(waiting_, [&](const Part& part) {
    return part.channel == message.channel && part.revision != revision;
  });
  const auto bytes =
      std::accumulate(waiting_.begin(), waiting_.end(), message.bytes.size(),
                      [](std::size_t sum, const Part& part) { return sum + part.bytes.size(); });
  if (bytes > kMostBytes) return false;
  waiting_.push_back({std::string(message.channel),
                      {message.bytes.begin(), message.bytes.end()},
                      message.event_time,
                      revision});
  return true;
}

void ModelParts::give(int most, const std::function<void(const process::RawMessage&)>& take) {
  for (; most > 0 && !waiting_.empty(); --most) {
    const Part part = std::move(waiting_.front());
    waiting_.pop_front();
    take({part.channel, part.bytes, part.event_time});
  }
}

}  // namespace marco::web
