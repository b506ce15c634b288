#include <benchmark/benchmark.h>
#include <sqlite3.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

#include "lcm_tools/log/mcap_writer.hpp"
#include "lcm_tools/log/output_file.hpp"
#include "recordings/ros/bag_writer.hpp"
#include "recordings/ros/byte_file.hpp"
#include "recordings/ros/encode_messages.hpp"
#include "recordings/ros/messages.hpp"
#include "recordings/ros/open_messages.hpp"

// What reading recordings of ROS costs beside `cat`: visiting every message, and decoding scans and
// transforms as a map needs them. 256 MB of messages, in the page cache: scans of 1081 beams with
// noise in their last bits, and ten transforms a scan. Bytes are those of the plain messages; of
// `cat` those of the file. Seconds per GB stand in the last column.
namespace marco::ros {
namespace {

enum Container { bag, mcap, db3, kContainers };
constexpr std::array<const char*, kContainers> kNames{"bag, lz4", "mcap, zstd", "db3"};
constexpr std::size_t kPlainBytes = std::size_t{256} << 20;

// `write(topic, time, bytes)` for each message: scans of topic 0, transforms of topic 1.
template <class Write>
std::size_t write_drive(const std::string& encoding, Write write) {
  LaserScanMessage scan;
  scan.header.frame_id = "laser";
  scan.ranges.resize(1081);
  uint32_t noise = 1;
  std::size_t bytes = 0;
  for (int64_t at_ns = 1; bytes < kPlainBytes; at_ns += 2'500'000) {
    scan.header.stamp_ns = at_ns;
    for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
      noise = noise * 1664525U + 1013904223U;  // Numerical Recipes' generator
      scan.ranges[i] =
          4.0F + std::sin(0.01F * static_cast<float>(i)) + 1e-3F * static_cast<float>(noise >> 24U);
    }
    const Bytes of_scan = encode(encoding, scan);
    write(0, at_ns, of_scan);
    bytes += of_scan.size();
    const std::vector<TransformMessage> one{{{at_ns, "odom"}, "base_link", Pose3::Identity()}};
    const Bytes of_transform = encode(encoding, one);
    for (int i = 0; i < 10; ++i) write(1, at_ns + i, of_transform);
    bytes += 10 * of_transform.size();
  }
  return bytes;
}

constexpr std::array<std::array<const char*, 2>, 2> kTopics{
    {{"/scan", "sensor_msgs/LaserScan"}, {"/tf", "tf2_msgs/TFMessage"}}};

std::size_t write_bag(const std::filesystem::path& path) {
  files::OutputFile out(path);
  BagWriter writer(out);
  for (const auto& [name, type] : kTopics) {
    Topic topic;
    topic.name = name;
    topic.type = type;
    writer.add_topic(topic);
  }
  const std::size_t bytes =
      write_drive("ros1", [&](uint32_t topic, int64_t at_ns, const Bytes& message) {
        writer.write(topic, at_ns, at_ns, message);
      });
  writer.finish();
  out.finish();
  return bytes;
}

std::size_t write_mcap(const std::filesystem::path& path) {
  logs::OutputFile out(path, logs::Existing::replace, {});
  logs::McapWriter writer(out, "ros2");
  std::array<uint16_t, 2> channels{};
  for (std::size_t i = 0; i < kTopics.size(); ++i) {
    channels[i] = writer.add_channel(writer.add_schema(kTopics[i][1], "ros2msg", ""), kTopics[i][0],
                                     "cdr", {});
  }
  const std::size_t bytes =
      write_drive("cdr", [&](uint32_t topic, int64_t at_ns, const Bytes& message) {
        const auto time_ns = static_cast<uint64_t>(at_ns);
        writer.write(channels.at(topic), 0, {time_ns, time_ns},
                     {reinterpret_cast<const char*>(message.data()), message.size()});
      });
  writer.finish();
  out.finish();
  return bytes;
}

// As rosbag2 lays it out.
std::size_t write_db3(const std::filesystem::path& path) {
  sqlite3* database = nullptr;
  sqlite3_open(path.c_str(), &database);
  const auto run = [&](const std::string& sql) {
    sqlite3_exec(database, sql.c_str(), nullptr, nullptr, nullptr);
  };
  run("CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT,"
      " offered_qos_profiles TEXT); CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER,"
      " timestamp INTEGER, data BLOB); CREATE INDEX timestamp_idx ON messages (timestamp ASC);"
      " BEGIN");
  for (std::size_t i = 0; i < kTopics.size(); ++i) {
    run("INSERT INTO topics VALUES (" + std::to_string(i) + ", '" + kTopics[i][0] + "', '" +
        kTopics[i][1] + "', 'cdr', '')");
  }
  sqlite3_stmt* insert = nullptr;
  sqlite3_prepare_v2(database, "INSERT INTO messages (topic_id, timestamp, data) VALUES (?, ?, ?)",
                     -1, &insert, nullptr);
  const std::size_t bytes = write_drive("cdr", [&](uint32_t topic, int64_t at_ns,
                                                   const Bytes& message) {
    sqlite3_bind_int64(insert, 1, topic);
    sqlite3_bind_int64(insert, 2, at_ns);
    sqlite3_bind_blob(insert, 3, message.data(), static_cast<int>(message.size()), SQLITE_STATIC);
    sqlite3_step(insert);
    sqlite3_reset(insert);
  });
  sqlite3_finalize(insert);
  run("COMMIT");
  sqlite3_close(database);
  return bytes;
}

struct Recording {
  explicit Recording(Container container)
      : path(
            std::filesystem::temp_directory_path() /
            ("marco_ros_benchmark_" + std::to_string(getpid()) + "_" + std::to_string(container))) {
    std::filesystem::remove(path);
    bytes = container == bag    ? write_bag(path)
            : container == mcap ? write_mcap(path)
                                : write_db3(path);
  }
  ~Recording() { std::filesystem::remove(path); }
  Recording(const Recording&) = delete;
  Recording& operator=(const Recording&) = delete;

  std::filesystem::path path;
  std::size_t bytes = 0;  ///< of the plain messages
};

// Written when it is first asked for, outside the loop that is timed.
const Recording& recording(const benchmark::State& state) {
  static std::array<std::unique_ptr<Recording>, kContainers> kept;
  auto& wanted = kept.at(static_cast<std::size_t>(state.range(0)));
  if (!wanted) wanted = std::make_unique<Recording>(static_cast<Container>(state.range(0)));
  return *wanted;
}

void report(benchmark::State& state, std::size_t bytes) {
  state.SetLabel(kNames.at(static_cast<std::size_t>(state.range(0))));
  const double gigabytes = 1e-9 * static_cast<double>(bytes);
  state.counters["s_per_GB"] =
      benchmark::Counter(gigabytes * static_cast<double>(state.iterations()),
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

void BM_Cat(benchmark::State& state) {
  const ByteFile file(recording(state).path);
  ByteBuffer block;
  for (auto _ : state) {
    for (int64_t at = 0; at < file.size(); at += 1 << 17) file.read(at, 1 << 17, block);
  }
  report(state, static_cast<std::size_t>(file.size()));
}

void BM_Visit(benchmark::State& state) {
  const Recording& read = recording(state);
  for (auto _ : state) {
    const auto source = open_messages(read.path);
    std::size_t bytes = 0;
    while (const auto message = source->next()) bytes += message->bytes.size();
    if (bytes != read.bytes) state.SkipWithError("messages are missing");
  }
  report(state, read.bytes);
}

void BM_Decode(benchmark::State& state) {
  const Recording& read = recording(state);
  for (auto _ : state) {
    const auto source = open_messages(read.path);
    std::size_t found = 0;
    while (const auto message = source->next()) {
      found += use_of(*message->topic) == Use::scan ? decode_scan(*message).ranges.size()
                                                    : decode_transforms(*message).size();
    }
    benchmark::DoNotOptimize(found);
  }
  report(state, read.bytes);
}

BENCHMARK(BM_Cat)->DenseRange(0, kContainers - 1)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_Visit)->DenseRange(0, kContainers - 1)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_Decode)->DenseRange(0, kContainers - 1)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace marco::ros
