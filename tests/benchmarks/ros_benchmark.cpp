#include <benchmark/benchmark.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "recordings/ros/bag_writer.hpp"
#include "recordings/ros/encode_messages.hpp"
#include "recordings/ros/messages.hpp"
#include "recordings/ros/open_messages.hpp"

// What reading recordings of ROS costs beside `cat`: visiting every message, and decoding scans and
// transforms as a map needs them. A bag of 256 MB of plain bytes, in the page cache: scans of 1081
// beams with noise in their last bits, and ten transforms a scan. Bytes are those of the bag
// unpacked.
namespace marco::ros {
namespace {

constexpr std::size_t kPlainBytes = std::size_t{256} << 20;

struct ScratchBag {
  ScratchBag()
      : path(std::filesystem::temp_directory_path() /
             ("marco_ros_benchmark_" + std::to_string(getpid()) + ".bag")) {
    files::OutputFile out(path);
    BagWriter bag(out);
    Topic topic;
    topic.name = "/scan";
    topic.type = "sensor_msgs/LaserScan";
    const uint32_t scans = bag.add_topic(topic);
    topic.name = "/tf";
    topic.type = "tf2_msgs/TFMessage";
    const uint32_t transforms = bag.add_topic(topic);
    LaserScanMessage scan;
    scan.header.frame_id = "laser";
    scan.ranges.resize(1081);
    uint32_t noise = 1;
    for (int64_t at_ns = 1; bytes < kPlainBytes; at_ns += 2'500'000) {
      scan.header.stamp_ns = at_ns;
      for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
        noise = noise * 1664525U + 1013904223U;  // Numerical Recipes' generator
        scan.ranges[i] = 4.0F + std::sin(0.01F * static_cast<float>(i)) +
                         1e-3F * static_cast<float>(noise >> 24U);
      }
      write(bag, scans, at_ns, encode("ros1", scan));
      const std::vector<TransformMessage> one{{{at_ns, "odom"}, "base_link", Pose3::Identity()}};
      for (int i = 0; i < 10; ++i) write(bag, transforms, at_ns + i, encode("ros1", one));
    }
    bag.finish();
    out.finish();
  }
  ~ScratchBag() { std::filesystem::remove(path); }
  ScratchBag(const ScratchBag&) = delete;
  ScratchBag& operator=(const ScratchBag&) = delete;

  void write(BagWriter& bag, uint32_t topic, int64_t at_ns, const Bytes& message) {
    bag.write(topic, at_ns, at_ns, message);
    bytes += message.size();
  }

  std::filesystem::path path;
  std::size_t bytes = 0;
};

const ScratchBag& scratch() {
  static const ScratchBag kBag;
  return kBag;
}

void report(benchmark::State& state, std::size_t bytes) {
  state.SetBytesProcessed(static_cast<int64_t>(bytes) * static_cast<int64_t>(state.iterations()));
}

void BM_Cat(benchmark::State& state) {
  std::vector<char> block(1 << 20);
  for (auto _ : state) {
    std::ifstream file(scratch().path, std::ios::binary);
    while (file.read(block.data(), static_cast<std::streamsize>(block.size()))) {
    }
  }
  report(state, std::filesystem::file_size(scratch().path));
}
BENCHMARK(BM_Cat)->Unit(benchmark::kMillisecond);

void BM_Visit(benchmark::State& state) {
  for (auto _ : state) {
    const auto source = open_messages(scratch().path);
    std::size_t bytes = 0;
    while (const auto message = source->next()) bytes += message->bytes.size();
    if (bytes != scratch().bytes) state.SkipWithError("messages are missing");
  }
  report(state, scratch().bytes);
}
BENCHMARK(BM_Visit)->Unit(benchmark::kMillisecond);

void BM_Decode(benchmark::State& state) {
  for (auto _ : state) {
    const auto source = open_messages(scratch().path);
    std::size_t found = 0;
    while (const auto message = source->next()) {
      found += use_of(*message->topic) == Use::scan ? decode_scan(*message).ranges.size()
                                                    : decode_transforms(*message).size();
    }
    benchmark::DoNotOptimize(found);
  }
  report(state, scratch().bytes);
}
BENCHMARK(BM_Decode)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace marco::ros
