// Speed of the laser drivers: codecs in bytes/s, and how long a driver and the conversion to its
// message take from the last byte of a scan.
#include <benchmark/benchmark.h>

#include <cmath>
#include <limits>

#include "drivers/hokuyo/codec.hpp"
#include "drivers/leuze/codec.hpp"
#include "drivers/rplidar/codec.hpp"
#include "drivers/sick/codec.hpp"
#include "drivers/sick/driver.hpp"
#include "drivers/transport/clock_filter.hpp"
#include "drivers/transport/wall_clock.hpp"
#include "lcmtypes/convert.hpp"
#include "simulator/devices/sick/emulator.hpp"
#include "simulator/devices/transport/emulator_port.hpp"
#include "simulator/devices/transport/simulated_line.hpp"

namespace marco::drivers {
namespace {

using Bytes = std::vector<uint8_t>;
constexpr std::size_t kChunk = 256;  // as a USB adapter delivers

template <class Parser, class Take>
void parse(benchmark::State& state, const Bytes& telegram, Parser parser, Take take) {
  Bytes stream;
  while (stream.size() < 64 * 1024) stream.insert(stream.end(), telegram.begin(), telegram.end());
  int64_t taken = 0;
  for (auto _ : state) {
    for (std::size_t at = 0; at < stream.size(); at += kChunk) {
      parser.push(std::span(stream).subspan(at, std::min(kChunk, stream.size() - at)));
      while (take(parser)) ++taken;
    }
  }
  state.SetBytesProcessed(static_cast<int64_t>(state.iterations() * stream.size()));
  state.counters["telegrams/s"] =
      benchmark::Counter(static_cast<double>(taken), benchmark::Counter::kIsRate);
}

void sick_codec(benchmark::State& state) {
  sick::MeasuredValues values;
  values.unit = sick::Unit::mm;
  for (int i = 0; i < 361; ++i) values.words.push_back(static_cast<uint16_t>(1000 + i));
  parse(state, sick::encode_reply(sick::encode_values(values)),
        sick::TelegramParser(sick::TelegramParser::Side::laser), [](auto& parser) {
          const auto event = parser.next();
          if (event) benchmark::DoNotOptimize(sick::decode_values(*event));
          return event.has_value();
        });
}
BENCHMARK(sick_codec);

void sick_garbage(benchmark::State& state) {
  Bytes garbage;
  for (uint32_t i = 0; i < 5000; ++i)
    garbage.push_back(static_cast<uint8_t>(i * 2654435761u >> 24));
  parse(state, garbage, sick::TelegramParser(sick::TelegramParser::Side::laser),
        [](auto& parser) { return parser.next().has_value(); });
}
BENCHMARK(sick_garbage);

void hokuyo_codec(benchmark::State& state) {
  const hokuyo::ScanRequest request{true, 3, 0, 1080, 1, 0, 0};
  hokuyo::Measurement scan{123, std::vector<uint32_t>(1081, 5432), {}};
  parse(state, hokuyo::encode_reply(hokuyo::encode_measurement(request, 0, scan)),
        hokuyo::ReplyParser(), [&](auto& parser) {
          const auto reply = parser.next();
          if (reply) benchmark::DoNotOptimize(hokuyo::decode_measurement(*reply, request));
          return reply.has_value();
        });
}
BENCHMARK(hokuyo_codec);

void leuze_codec(benchmark::State& state) {
  leuze::Telegram telegram;
  telegram.values_mm.assign(133, 2000);
  parse(state, leuze::encode_telegram(telegram), leuze::TelegramParser(),
        [](auto& parser) { return parser.next().has_value(); });
}
BENCHMARK(leuze_codec);

void rplidar_capsules(benchmark::State& state) {
  rplidar::Capsule capsule;
  capsule.distance_mm.fill(1500);
  const auto bytes = rplidar::encode_capsule(capsule);
  rplidar::AnswerParser parser;
  parser.push(rplidar::encode_descriptor(rplidar::kCapsuleSize, true, rplidar::kCapsules));
  parse(state, Bytes(bytes.begin(), bytes.end()), parser,
        [](auto& one) { return one.next().has_value(); });
}
BENCHMARK(rplidar_capsules);

void rplidar_nodes(benchmark::State& state) {
  Bytes turn;
  for (int i = 0; i < 360; ++i) {
    const auto bytes = rplidar::encode_node({i == 0, 47, i * 64, 6000});
    turn.insert(turn.end(), bytes.begin(), bytes.end());
  }
  rplidar::AnswerParser parser;
  parser.push(rplidar::encode_descriptor(rplidar::kNodeSize, true, rplidar::kNodes));
  parse(state, turn, parser, [](auto& one) { return one.next().has_value(); });
}
BENCHMARK(rplidar_nodes);

void clock_filter(benchmark::State& state) {
  ClockFilter filter;
  double device_s = 0.0;
  for (auto _ : state) {
    device_s += 0.0267;
    const double late_s = 0.001 * std::abs(std::sin(device_s * 1e3));
    benchmark::DoNotOptimize(filter.update(device_s, Utime::from_seconds(1e9 + device_s + late_s)));
  }
}
BENCHMARK(clock_filter);

std::vector<double> wall(const LaserSweep& sweep) {
  return std::vector<double>(static_cast<std::size_t>(sweep.beams), 2.0);
}

// The driver's own work for a scan at 37.5 a second, emulator included: everything but the system.
void sick_driver_in_simulated_time(benchmark::State& state) {
  sick::SickEmulator emulator(wall, {});
  SimulatedLine line(emulator);
  const auto stream = line.open({500'000});
  sick::SickOptions options;
  options.baud = 500'000;
  sick::SickDriver driver(*stream, options, [&] { return line.now(); });
  while (!driver.measuring()) driver.step();
  int64_t scans = 0;
  for (auto _ : state) scans += static_cast<int64_t>(driver.step().size());
  state.counters["scans/s"] =
      benchmark::Counter(static_cast<double>(scans), benchmark::Counter::kIsRate);
}
BENCHMARK(sick_driver_in_simulated_time);

// From the arrival of a scan's last byte at the driver, through a real pseudo-terminal, to the
// bytes of its message. The emulator is served in the same thread.
void sick_last_byte_to_message(benchmark::State& state) {
  sick::SickEmulator emulator(wall, {});
  EmulatorPort port = EmulatorPort::pty(emulator);
  std::array<EmulatorPort*, 1> ports{&port};
  const auto stream = open_stream(port.address(), {500'000});
  sick::SickOptions options;
  options.baud = 500'000;
  // Reads without waiting, so that the emulator gets its turn.
  struct NoWait final : ByteStream {
    explicit NoWait(ByteStream& inner) : stream(inner) {}
    std::size_t read(std::span<uint8_t> into, std::chrono::microseconds) override {
      return stream.read(into, std::chrono::microseconds(0));
    }
    void write(std::span<const uint8_t> bytes) override { stream.write(bytes); }
    void set_line(const LineSettings& line) override { stream.set_line(line); }
    void discard_input() override { stream.discard_input(); }
    ByteStream& stream;
  } no_wait(*stream);
  sick::SickDriver driver(no_wait, options, wall_now);
  std::vector<double> latencies_us;
  for (auto _ : state) {
    bool published = false;
    while (!published) {
      serve_ports(ports, Duration::from_us(1000));
      for (ArrivedScan& arrived : driver.step()) {
        arrived.scan.time_offsets_s.clear();
        benchmark::DoNotOptimize(encode_message(to_message(arrived.scan)));
        latencies_us.push_back(static_cast<double>((wall_now() - arrived.arrival).us));
        published = true;
      }
    }
  }
  std::sort(latencies_us.begin(), latencies_us.end());
  state.counters["p50_us"] = latencies_us[latencies_us.size() / 2];
  state.counters["p99_us"] = latencies_us[latencies_us.size() * 99 / 100];
}
BENCHMARK(sick_last_byte_to_message)->Iterations(150)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace marco::drivers
