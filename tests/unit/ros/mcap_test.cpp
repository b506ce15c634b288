#include "recordings/ros/file_sources.hpp"

#include <gmock/gmock.h>
#include <lz4frame.h>
#include <sys/resource.h>
#include <zstd.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "tests/support/real_data.hpp"

namespace marco::ros {
namespace {

using ::marco::testing::TemporaryFolder;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

const std::string kMagic("\x89MCAP0\r\n", 8);

template <class Number>
std::string le(Number value) {
  return {reinterpret_cast<const char*>(&value), sizeof value};
}
std::string text(const std::string& value) {
  return le(static_cast<uint32_t>(value.size())) + value;
}
std::string record(uint8_t op, const std::string& content) {
  return le(op) + le(uint64_t{content.size()}) + content;
}
std::string schema() {
  return record(
      3, le(uint16_t{1}) + text("std_msgs/msg/String") + text("ros2msg") + text("string data"));
}
std::string channel(const std::string& metadata = "") {
  return record(4, le(uint16_t{7}) + le(uint16_t{1}) + text("/a") + text("cdr") + text(metadata));
}
std::string message(uint64_t at_ns, const std::string& data) {
  return record(5, le(uint16_t{7}) + le(uint32_t{0}) + le(at_ns) + le(at_ns) + data);
}
std::string chunk(const std::string& compression,
                  const std::string& plain,
                  uint64_t from,
                  uint64_t to) {
  std::string packed = plain;
  if (compression == "lz4") {
    packed.assign(plain.size() + 1000, '\0');
    packed.resize(
        LZ4F_compressFrame(packed.data(), packed.size(), plain.data(), plain.size(), nullptr));
  } else if (compression == "zstd") {
    packed.assign(plain.size() + 1000, '\0');
    packed.resize(ZSTD_compress(packed.data(), packed.size(), plain.data(), plain.size(), 1));
  }
  return record(6, le(from) + le(to) + le(uint64_t{plain.size()}) + le(uint32_t{0}) +
                       text(compression) + le(uint64_t{packed.size()}) + packed);
}
std::string footer() { return record(0x0F, le(uint32_t{0})) + record(2, std::string(20, '\0')); }

std::string file(const std::string& compression) {
  return kMagic + record(1, text("ros2") + text("test")) +
         chunk(compression, schema() + channel() + message(1, "one") + message(3, "three"), 1, 3) +
         chunk(compression, message(2, "two") + message(4, "four"), 2, 4) + footer() + kMagic;
}

std::string joined(MessageSource& source) {
  std::string all;
  while (const auto message = source.next()) {
    all += std::string(message->bytes.begin(), message->bytes.end()) + " ";
  }
  return all;
}

TEST(Mcap, GivesMessagesOfOverlappingChunksByTime) {
  const TemporaryFolder folder;
  for (const std::string compression : {"", "lz4", "zstd"}) {
    const auto source = open_mcap(folder.write("a.mcap", file(compression)));
    EXPECT_EQ(joined(*source), "one two three four ") << compression;
    EXPECT_EQ(source->damage().places, 0);
    EXPECT_FALSE(source->damage().is_cut_off);
    ASSERT_EQ(source->topics().size(), 1U);
    EXPECT_EQ(source->topics()[0]->type, "std_msgs/String");
    source->rewind();
    EXPECT_EQ(joined(*source), "one two three four ");
    source->select([](const Topic&) { return false; });
    EXPECT_EQ(joined(*source), "");
  }
}

// Summaries repeat channels; a schema may stand in a chunk alone.
TEST(Mcap, KnowsTheTypeOfAChannelWhoseSchemaComesLater) {
  const TemporaryFolder folder;
  const auto source = open_mcap(
      folder.write("a.mcap", kMagic + chunk("lz4", schema() + channel() + message(1, "one"), 1, 1) +
                                 channel() + footer() + kMagic));
  source->select([](const Topic& topic) { return topic.type == "std_msgs/String"; });
  EXPECT_EQ(joined(*source), "one ");
}

TEST(Mcap, CutAnywhereGivesNoMoreThanWasWhole) {
  const TemporaryFolder folder;
  for (const std::string compression : {"", "lz4", "zstd"}) {
    const std::string whole = file(compression);
    std::size_t most = 0;
    for (std::size_t size = 8; size <= whole.size(); ++size) {
      const auto source = open_mcap(folder.write("a.mcap", whole.substr(0, size)));
      const std::size_t read = joined(*source).size();
      EXPECT_GE(read, most) << size;
      most = read;
    }
    EXPECT_EQ(most, std::string("one two three four ").size());
  }
}

TEST(Mcap, GoesOnBehindADamagedLength) {
  const TemporaryFolder folder;
  std::string damaged = file("lz4");
  const std::size_t header = 8 + 9 + 16;  // magic, and the header's record
  damaged[8 + 4] = '\x7F';                // of its length
  ASSERT_LT(header, damaged.size());
  const auto source = open_mcap(folder.write("a.mcap", damaged));
  EXPECT_EQ(joined(*source), "one two three four ");
  EXPECT_EQ(source->damage().places, 1);
}

TEST(Mcap, TakesNoMemoryThatADamagedSizeAsksFor) {
  const TemporaryFolder folder;
  std::string damaged =
      kMagic + chunk("zstd", schema() + channel() + message(1, "one"), 1, 1) + footer() + kMagic;
  const uint64_t huge = uint64_t{1} << 60;
  damaged.replace(8 + 9 + 16, 8, le(huge));
  const auto source = open_mcap(folder.write("a.mcap", damaged));
  EXPECT_EQ(joined(*source), "one ");
  EXPECT_EQ(source->damage().places, 1);
}

std::size_t peak_bytes() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::size_t>(usage.ru_maxrss) << 10U;
}

// Recorders with a chunk a topic, or that sort by another time: chunk i holds each Nth message.
TEST(Mcap, KeepsTheOrderOfManyChunksThatOverlap) {
  const TemporaryFolder folder;
  constexpr int kEach = 10;
  for (const int chunks : {40, 400}) {
    std::string content = kMagic;
    for (int i = 0; i < chunks; ++i) {
      std::string plain = schema() + channel();
      for (int k = 0; k < kEach; ++k) {
        plain += message(static_cast<uint64_t>(i + k * chunks), std::to_string(i + k * chunks));
      }
      content += chunk("zstd", plain, 0, static_cast<uint64_t>(kEach * chunks));
    }
    const auto path = folder.write("a.mcap", content + footer() + kMagic);
    std::string wanted;
    for (int i = 0; i < chunks * kEach; ++i) wanted += std::to_string(i) + " ";
    for (const std::size_t most_held : {kMostHeldBytes, std::size_t{10'000}}) {
      const auto source = open_mcap(path, most_held);
      EXPECT_TRUE(joined(*source) == wanted) << chunks << " " << most_held;
      const bool is_said = !source->notes().empty();
      EXPECT_EQ(is_said, most_held < kMostHeldBytes) << chunks;
      EXPECT_EQ(source->damage().places, 0);
    }
  }
}

// A zstd chunk of `plain` and zeros: four bytes for 128 kB of them.
std::string chunk_with_zeros(const std::string& plain, std::size_t zeros) {
  constexpr std::size_t kBlock = std::size_t{1} << 17U;
  constexpr uint32_t kRaw = 0, kRepeated = 1;
  const auto block = [](std::size_t size, uint32_t kind, bool is_last) {
    return le(static_cast<uint32_t>(size << 3U) | kind << 1U | (is_last ? 1U : 0U)).substr(0, 3);
  };
  std::string packed = le(uint32_t{0xFD2FB528}) + std::string("\0\x70", 2);  // a window of 16 MB
  packed += block(plain.size(), kRaw, false) + plain;
  for (std::size_t at = 0; at < zeros; at += kBlock) {
    packed += block(std::min(kBlock, zeros - at), kRepeated, at + kBlock >= zeros) + '\0';
  }
  return record(6, le(uint64_t{0}) + le(uint64_t{20}) + le(uint64_t{plain.size() + zeros}) +
                       le(uint32_t{0}) + text("zstd") + le(uint64_t{packed.size()}) + packed);
}
std::string head(uint8_t op, std::size_t size) { return le(op) + le(uint64_t{size}); }

// Eight times 64 MB of a record that nobody reads, in chunks that overlap.
TEST(Mcap, HoldsOfChunksWhatIsWantedAlone) {
  const TemporaryFolder folder;
  constexpr std::size_t kPadding = std::size_t{64} << 20U;
  std::string content = kMagic, wanted;
  for (uint64_t i = 0; i < 8; ++i) {
    content += chunk_with_zeros(
        schema() + channel() + message(i, std::to_string(i)) + head(0x80, kPadding), kPadding);
    wanted += std::to_string(i) + " ";
  }
  const std::size_t before = peak_bytes();
  const auto source = open_mcap(folder.write("a.mcap", content + footer() + kMagic));
  EXPECT_EQ(joined(*source), wanted);
  EXPECT_EQ(source->damage().places, 0);
  EXPECT_LT(peak_bytes() - before, kPadding);
}

TEST(Mcap, LeavesOutAMessageLargerThanAnyRecorderWrites) {
  const TemporaryFolder folder;
  const std::string before = schema() + channel() + message(1, "one");
  const std::string of_zeros = message(2, "").substr(9);
  const std::string large = head(5, of_zeros.size() + kMostMessageBytes) + of_zeros;
  const auto source = open_mcap(
      folder.write("a.mcap", kMagic + chunk_with_zeros(before + large, kMostMessageBytes) +
                                 chunk("", message(3, "three"), 3, 3) + footer() + kMagic));
  EXPECT_EQ(joined(*source), "one three ");
  EXPECT_THAT(source->notes(), ElementsAre("messages of more than 256 MB are left out"));
}

TEST(Mcap, RefusesDefinitionsLargerThanAnyRobots) {
  const TemporaryFolder folder;
  constexpr uint32_t kDefinition = 40U << 20U;
  std::string content = kMagic;
  for (uint16_t i = 2; i < 6; ++i) {
    const std::string before = le(i) + text("a/B") + text("ros2msg") + le(kDefinition);
    content += chunk_with_zeros(head(3, before.size() + kDefinition) + before, kDefinition);
  }
  const auto source = open_mcap(folder.write("a.mcap", content + footer() + kMagic));
  EXPECT_THAT([&] { source->next(); }, ThrowsMessage<std::invalid_argument>(
                                           HasSubstr("definitions of topics exceed 128 MB")));
}

// Larger than could be read in an hour.
TEST(Mcap, GoesOnBehindAHole) {
  const TemporaryFolder folder;
  const std::string first = chunk("lz4", schema() + channel() + message(1, "one"), 1, 1);
  const auto path = folder.write("a.mcap", kMagic + first);
  std::filesystem::resize_file(path, uint64_t{200} << 30U);
  std::ofstream(path, std::ios::app) << chunk("lz4", message(2, "two"), 2, 2) + footer() + kMagic;
  const auto source = open_mcap(path);
  EXPECT_EQ(joined(*source), "one two ");
  EXPECT_EQ(source->damage().places, 1);
}

struct Expected {
  std::vector<uint64_t> log_times;
  std::vector<std::string> data;
};

// The conformance files' own list of records.
Expected expected_of(const std::filesystem::path& json_file) {
  std::ifstream in(json_file);
  const nlohmann::json json = nlohmann::json::parse(in);
  std::vector<std::pair<uint64_t, std::string>> messages;
  for (const auto& entry : json.at("records")) {
    if (entry.at("type") != "Message") continue;
    std::map<std::string, nlohmann::json> fields;
    for (const auto& field : entry.at("fields")) fields[field[0].get<std::string>()] = field[1];
    std::string data;
    for (const auto& byte : fields.at("data")) {
      data += static_cast<char>(byte.is_string() ? std::stoi(byte.get<std::string>())
                                                 : byte.get<int>());
    }
    messages.emplace_back(std::stoull(fields.at("log_time").get<std::string>()), data);
  }
  std::stable_sort(messages.begin(), messages.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  Expected expected;
  for (const auto& [time, data] : messages) {
    expected.log_times.push_back(time);
    expected.data.push_back(data);
  }
  return expected;
}

TEST(Mcap, ReadsTheConformanceFilesAsTheyAreMeant) {
  const char* folder = marco::testing::real_data();
  if (folder == nullptr) GTEST_SKIP();
  int files = 0;
  for (const auto& entry :
       std::filesystem::recursive_directory_iterator(std::string(folder) + "/mcap")) {
    if (entry.path().extension() != ".mcap") continue;
    ++files;
    std::filesystem::path json = entry.path();
    const Expected expected = expected_of(json.replace_extension(".json"));
    const auto source = open_mcap(entry.path());
    Expected read;
    while (const auto message = source->next()) {
      read.log_times.push_back(static_cast<uint64_t>(message->received_ns));
      read.data.emplace_back(message->bytes.begin(), message->bytes.end());
    }
    EXPECT_EQ(read.log_times, expected.log_times) << entry.path();
    EXPECT_EQ(read.data, expected.data) << entry.path();
    EXPECT_EQ(source->damage().places, 0) << entry.path();
    EXPECT_TRUE(source->notes().empty()) << entry.path();
  }
  EXPECT_GE(files, 60);
}

}  // namespace
}  // namespace marco::ros
