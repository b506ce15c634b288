#include <benchmark/benchmark.h>
#include <fcntl.h>
#include <unistd.h>

#include <filesystem>
#include <random>

#include "lcm_tools/files/event_log.hpp"
#include "lcm_tools/log/log_info.hpp"
#include "lcm_tools/log/merge.hpp"
#include "lcm_tools/log/repair.hpp"
#include "lcm_tools/log/select.hpp"
#include "lcm_tools/log/types.hpp"

// What the log tools cost beside `cat`: read the log, or read it and write it, doing nothing else.
// Argument: bytes of a message. Every log is 256 MB, in the page cache.
namespace marco::logs {
namespace {

constexpr int64_t kLogBytes = 256 << 20;

std::filesystem::path scratch() {
  return std::filesystem::temp_directory_path() /
         ("marco_log_benchmark_" + std::to_string(getpid()));
}

class ScratchLog {
 public:
  explicit ScratchLog(int64_t message_bytes) : path_(scratch().string() + ".in") {
    static constexpr const char* kChannels[] = {"LIDAR", "ODOMETRY", "CAMERA_LEFT", "IMU"};
    std::vector<uint8_t> bytes(static_cast<std::size_t>(message_bytes));
    std::mt19937 random(1);
    for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(random());
    files::EventLogWriter writer(path_);
    for (int64_t i = 0; i * (message_bytes + 36) < kLogBytes; ++i) {
      writer.write(kChannels[i % 4], bytes, Utime::from_us(1'454'600'000'000'000 + 1000 * i));
    }
    writer.flush();
  }
  ~ScratchLog() {
    std::filesystem::remove(path_);
    std::filesystem::remove(out());
  }
  ScratchLog(const ScratchLog&) = delete;
  ScratchLog& operator=(const ScratchLog&) = delete;

  const std::string& path() const { return path_; }
  static std::string out() { return scratch().string() + ".out"; }

 private:
  std::string path_;
};

void ignore(double /*part*/) {}

void report(benchmark::State& state, const ScratchLog& log) {
  state.SetBytesProcessed(state.iterations() *
                          static_cast<int64_t>(std::filesystem::file_size(log.path())));
}

void cat_to_nowhere(benchmark::State& state) {
  const ScratchLog log(state.range(0));
  std::vector<char> block(128 << 10);
  for (auto _ : state) {
    const int in = open(log.path().c_str(), O_RDONLY);
    while (read(in, block.data(), block.size()) > 0) benchmark::ClobberMemory();
    close(in);
  }
  report(state, log);
}

void info(benchmark::State& state) {
  const ScratchLog log(state.range(0));
  for (auto _ : state) benchmark::DoNotOptimize(inspect_log(log.path(), ignore));
  report(state, log);
}

void cat_to_file(benchmark::State& state) {
  const ScratchLog log(state.range(0));
  std::vector<char> block(128 << 10);
  for (auto _ : state) {
    const int in = open(log.path().c_str(), O_RDONLY);
    const int out = open(ScratchLog::out().c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    for (ssize_t got = 0; (got = read(in, block.data(), block.size())) > 0;) {
      if (write(out, block.data(), static_cast<std::size_t>(got)) != got)
        state.SkipWithError("disk");
    }
    close(in);
    close(out);
  }
  report(state, log);
}

void cut(benchmark::State& state) {
  const ScratchLog log(state.range(0));
  const TimeRange range{Utime::from_us(1'454'600'000'000'000 + 5000), Utime::from_us(INT64_MAX)};
  for (auto _ : state) {
    OutputFile out(ScratchLog::out(), Existing::replace, {});
    ChannelChoice all;
    select_events(log.path(), out, range, all, ignore);
    out.finish();
  }
  report(state, log);
}

void filter_half(benchmark::State& state) {
  const ScratchLog log(state.range(0));
  for (auto _ : state) {
    OutputFile out(ScratchLog::out(), Existing::replace, {});
    ChannelChoice half({"LIDAR", "CAMERA.*"}, ChannelChoice::Sense::keep);
    select_events(log.path(), out, {}, half, ignore);
    out.finish();
  }
  report(state, log);
}

void merge_two(benchmark::State& state) {
  const ScratchLog log(state.range(0));
  for (auto _ : state) {
    OutputFile out(ScratchLog::out(), Existing::replace, {});
    merge_logs({{log.path(), {}, "A_"}, {log.path(), {}, "B_"}}, out, ignore);
    out.finish();
  }
  report(state, log);
}

void repair(benchmark::State& state) {
  const ScratchLog log(state.range(0));
  const Types types({});
  for (auto _ : state) {
    OutputFile out(ScratchLog::out(), Existing::replace, {});
    repair_log(
        log.path(), out, Mending::headers,
        [&types](std::span<const uint8_t> message) { return types.decodes(message); }, ignore);
    out.finish();
  }
  report(state, log);
}

constexpr int64_t kSmall = 1000, kLarge = 300000;
BENCHMARK(cat_to_nowhere)->Arg(kSmall)->Arg(kLarge)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(info)->Arg(kSmall)->Arg(kLarge)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(cat_to_file)->Arg(kSmall)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(cut)->Arg(kSmall)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(filter_half)->Arg(kSmall)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(merge_two)->Arg(kSmall)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(repair)->Arg(kSmall)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace marco::logs
