// The spy's run-time decoder against lcm-gen's compiled code, and what a message costs the spy.
// compiled: decode into the generated struct. check: is the message whole. tree: every field found.
// values: tree, then each number read, which is the work the compiled decoder does.
#include <benchmark/benchmark.h>

#include <vector>

#include "bot_core/planar_lidar_t.hpp"
#include "bot_core/pose_t.hpp"
#include "lcm_tools/schema/built_in_sources.hpp"
#include "lcm_tools/schema/json.hpp"
#include "lcm_tools/spy/model.hpp"
#include "marco/process_status_t.hpp"
#include "marco/sensor_info_t.hpp"

namespace marco {
namespace {

using lcm_schema::Decoder;
using lcm_schema::Tree;

const Decoder& decoder() {
  static const lcm_schema::Schema kSchema(built_in_sources());
  static const Decoder kResult(kSchema);
  return kResult;
}

template <class Message>
Message example() {
  return {};
}

template <>
bot_core::planar_lidar_t example() {
  bot_core::planar_lidar_t message = {};
  message.nranges = 360;
  message.ranges.assign(360, 2.5F);
  return message;
}

template <>
process_status_t example() {
  process_status_t message = {};
  message.process = "marco-slam";
  message.num_causes = 3;
  message.drop_causes = {"ranges_not_finite", "time_backwards", "unknown_frame"};
  message.drop_counts = {1, 2, 3};
  message.state = "map of 1200 scans";
  return message;
}

template <class Message>
std::vector<uint8_t> bytes() {
  const Message message = example<Message>();
  std::vector<uint8_t> result(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(result.data(), 0, static_cast<int>(result.size()));
  return result;
}

template <class Message>
int type() {
  return decoder().schema().with_fingerprint(static_cast<uint64_t>(Message::getHash())).front();
}

void count(benchmark::State& state, std::size_t size) {
  state.SetItemsProcessed(state.iterations());
  state.SetBytesProcessed(state.iterations() * static_cast<int64_t>(size));
}

template <class Message>
void compiled(benchmark::State& state) {
  const auto message = bytes<Message>();
  Message result;
  for (auto _ : state) {
    benchmark::DoNotOptimize(result.decode(message.data(), 0, static_cast<int>(message.size())));
    benchmark::DoNotOptimize(&result);  // every field must really be written
    benchmark::ClobberMemory();
  }
  count(state, message.size());
}

template <class Message>
void check(benchmark::State& state) {
  const auto message = bytes<Message>();
  const int index = type<Message>();
  for (auto _ : state) benchmark::DoNotOptimize(decoder().check(index, message));
  count(state, message.size());
}

template <class Message>
void tree(benchmark::State& state) {
  const auto message = bytes<Message>();
  const int index = type<Message>();
  Tree result;
  for (auto _ : state) benchmark::DoNotOptimize(decoder().decode(index, message, result));
  count(state, message.size());
}

template <class Message>
void values(benchmark::State& state) {
  const auto message = bytes<Message>();
  const int index = type<Message>();
  Tree result;
  std::vector<double> numbers;
  for (auto _ : state) {
    decoder().decode(index, message, result);
    numbers.clear();
    for (const lcm_schema::Node& node : result.nodes) {
      for (std::size_t i = 0; i < node.count; ++i) numbers.push_back(result.number(node, i));
    }
    benchmark::DoNotOptimize(numbers.data());
  }
  count(state, message.size());
}

template <class Message>
void json(benchmark::State& state) {
  const auto message = bytes<Message>();
  const int index = type<Message>();
  Tree result;
  std::string text;
  for (auto _ : state) {
    decoder().decode(index, message, result);
    text.clear();
    lcm_schema::append_json(result, text);
    benchmark::DoNotOptimize(text.data());
  }
  count(state, message.size());
}

#define MARCO_SPY_BENCHMARKS(Message) \
  BENCHMARK(compiled<Message>);       \
  BENCHMARK(check<Message>);          \
  BENCHMARK(tree<Message>);           \
  BENCHMARK(values<Message>);         \
  BENCHMARK(json<Message>)

MARCO_SPY_BENCHMARKS(bot_core::pose_t);
MARCO_SPY_BENCHMARKS(bot_core::planar_lidar_t);
MARCO_SPY_BENCHMARKS(sensor_info_t);
MARCO_SPY_BENCHMARKS(process_status_t);

// From datagram to statistics: what one message costs the listening thread.
void hear(benchmark::State& state) {
  spy::Model model(decoder());
  const auto message = bytes<bot_core::pose_t>();
  std::vector<uint8_t> datagram = {'L', 'C', '0', '2', 0, 0, 0, 0, 'P', 'O', 'S', 'E', 0};
  datagram.insert(datagram.end(), message.begin(), message.end());
  uint32_t number = 0;
  for (auto _ : state) {
    for (unsigned i = 0; i < 4; ++i) datagram[4 + i] = static_cast<uint8_t>(number >> (24 - 8 * i));
    model.add_datagram(10 * int64_t{++number}, {0x7F000001, 40000}, datagram);
  }
  count(state, datagram.size());
}
BENCHMARK(hear);

}  // namespace
}  // namespace marco
