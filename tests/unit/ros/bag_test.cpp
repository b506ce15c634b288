#include "recordings/ros/file_sources.hpp"

#include <bzlib.h>
#include <gmock/gmock.h>
#include <lz4frame.h>

#include <cstring>
#include <string>
#include <vector>

#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "recordings/ros/open_messages.hpp"

namespace marco::ros {
namespace {

using ::marco::testing::TemporaryFolder;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::string u32(uint32_t value) { return {reinterpret_cast<const char*>(&value), sizeof value}; }
std::string u64(uint64_t value) { return {reinterpret_cast<const char*>(&value), sizeof value}; }
std::string time(double seconds) {
  const auto whole = static_cast<uint32_t>(seconds);
  return u32(whole) + u32(static_cast<uint32_t>((seconds - whole) * 1e9 + 0.5));
}
std::string field(const std::string& name, const std::string& value) {
  return u32(static_cast<uint32_t>(name.size() + 1 + value.size())) + name + "=" + value;
}
std::string record(const std::string& header, const std::string& data) {
  return u32(static_cast<uint32_t>(header.size())) + header +
         u32(static_cast<uint32_t>(data.size())) + data;
}
std::string op(char code) { return field("op", std::string(1, code)); }

std::string connection(uint32_t id, const std::string& topic) {
  return record(op(7) + field("conn", u32(id)) + field("topic", topic),
                field("type", "std_msgs/String") +
                    field("md5sum", "992ce8a1687cec8c8bd883ec73ca41d1") +
                    field("message_definition", "string data\n") + field("latching", "1"));
}
std::string message(uint32_t id, double at_s, const std::string& text) {
  return record(op(2) + field("conn", u32(id)) + field("time", time(at_s)),
                u32(static_cast<uint32_t>(text.size())) + text);
}

std::string compressed(const std::string& name, const std::string& plain) {
  if (name == "none") return plain;
  std::string packed(plain.size() + 1000, '\0');
  if (name == "bz2") {
    auto size = static_cast<unsigned>(packed.size());
    BZ2_bzBuffToBuffCompress(packed.data(), &size, const_cast<char*>(plain.data()),
                             static_cast<unsigned>(plain.size()), 9, 0, 0);
    packed.resize(size);
  } else {
    LZ4F_preferences_t preferences{};  // as ROS wants it
    preferences.frameInfo.contentChecksumFlag = LZ4F_contentChecksumEnabled;
    packed.resize(
        LZ4F_compressFrame(packed.data(), packed.size(), plain.data(), plain.size(), &preferences));
  }
  return packed;
}

struct Chunk {
  std::string plain;
  double start_s, end_s;
  std::vector<std::pair<uint32_t, uint32_t>> counts;  // connection, messages
};

// A bag as the definition of the format says; without its index as a recorder leaves it that died.
std::string bag(const std::vector<Chunk>& chunks, const std::string& compression, bool has_index) {
  const auto start = [](uint64_t index_at, std::size_t chunk_count) {
    const std::string header = op(3) + field("index_pos", u64(index_at)) +
                               field("conn_count", u32(2)) +
                               field("chunk_count", u32(static_cast<uint32_t>(chunk_count)));
    return "#ROSBAG V2.0\n" + record(header, std::string(4096 - 8 - header.size(), ' '));
  };
  std::string body;
  std::vector<uint64_t> places;
  const std::size_t start_size = start(0, 0).size();
  for (const Chunk& chunk : chunks) {
    places.push_back(start_size + body.size());
    body += record(op(5) + field("compression", compression) +
                       field("size", u32(static_cast<uint32_t>(chunk.plain.size()))),
                   compressed(compression, chunk.plain));
  }
  if (!has_index) return start(0, 0) + body;
  const uint64_t index_at = start_size + body.size();
  body += connection(0, "/a") + connection(1, "/b");
  for (std::size_t i = 0; i < chunks.size(); ++i) {
    std::string counts;
    for (const auto& [id, count] : chunks[i].counts) counts += u32(id) + u32(count);
    body += record(op(6) + field("ver", u32(1)) + field("chunk_pos", u64(places[i])) +
                       field("start_time", time(chunks[i].start_s)) +
                       field("end_time", time(chunks[i].end_s)) +
                       field("count", u32(static_cast<uint32_t>(chunks[i].counts.size()))),
                   counts);
  }
  return start(index_at, chunks.size()) + body;
}

// Two chunks whose times overlap.
std::vector<Chunk> two_chunks() {
  return {
      {connection(0, "/a") + message(0, 1.0, "one") + message(0, 3.0, "three"), 1.0, 3.0, {{0, 2}}},
      {connection(1, "/b") + message(1, 2.0, "two") + message(1, 4.0, "four"), 2.0, 4.0, {{1, 2}}}};
}

std::vector<std::string> texts(MessageSource& source) {
  std::vector<std::string> texts;
  while (const auto message = source.next()) {
    texts.emplace_back(message->bytes.begin() + 4, message->bytes.end());
  }
  return texts;
}

TEST(Bag, GivesMessagesByTimeWithAnIndexAndWithout) {
  const TemporaryFolder folder;
  for (const std::string compression : {"none", "bz2", "lz4"}) {
    for (const bool has_index : {true, false}) {
      const auto path = folder.write("a.bag", bag(two_chunks(), compression, has_index));
      const auto source = open_messages(path);
      EXPECT_THAT(texts(*source), ElementsAre("one", "two", "three", "four")) << compression;
      EXPECT_EQ(source->damage().places, 0);
      EXPECT_EQ(source->notes().empty(), has_index);
      const auto topics = source->topics();
      ASSERT_EQ(topics.size(), 2U);
      EXPECT_EQ(topics[0]->type, "std_msgs/String");
      EXPECT_EQ(topics[0]->encoding, "ros1");
      EXPECT_TRUE(topics[0]->is_latched);
      EXPECT_EQ(topics[0]->messages, has_index ? 2 : -1);
      source->select([](const Topic& topic) { return topic.name == "/b"; });
      EXPECT_THAT(texts(*source), ElementsAre("two", "four"));
    }
  }
}

// The recorder writes the sizes of a chunk when it closes it.
TEST(Bag, GivesWhatAChunkHoldsThatWasNeverClosed) {
  const TemporaryFolder folder;
  std::string open = bag({two_chunks()[0]}, "none", false);
  open += record(op(5) + field("compression", "none") + field("size", u32(0)), "");
  open += message(0, 5.0, "five") + connection(1, "/b") + message(1, 6.0, "six");
  open.resize(open.size() - 2);
  const auto source = open_bag(folder.write("a.bag.active", open));
  EXPECT_THAT(texts(*source), ElementsAre("one", "three", "five"));
}

TEST(Bag, GoesOnAtTheNextChunkAfterDamage) {
  const TemporaryFolder folder;
  std::string damaged = bag(two_chunks(), "none", false);
  const std::size_t first_chunk = damaged.find("compression") - 4 - 8 - 8;
  std::memset(damaged.data() + first_chunk, 0xFF, 8);
  const auto source = open_bag(folder.write("a.bag", damaged));
  EXPECT_THAT(texts(*source), ElementsAre("two", "four"));
  EXPECT_EQ(source->damage().places, 1);
}

TEST(Bag, TellsAWrongChecksumAndUsesTheChunk) {
  const TemporaryFolder folder;
  std::string damaged = bag(two_chunks(), "lz4", false);
  damaged.back() ^= 1;
  const auto source = open_bag(folder.write("a.bag", damaged));
  EXPECT_THAT(texts(*source), ElementsAre("one", "two", "three", "four"));
  EXPECT_THAT(source->notes(), ::testing::Contains(HasSubstr("wrong checksum")));
}

TEST(Bag, CutAnywhereGivesNoMoreThanWasWhole) {
  const TemporaryFolder folder;
  for (const std::string compression : {"none", "lz4"}) {
    const std::string whole = bag(two_chunks(), compression, true);
    std::size_t most = 0;
    for (std::size_t size = 4100; size <= whole.size(); ++size) {
      const auto source = open_bag(folder.write("a.bag", whole.substr(0, size)));
      const std::vector<std::string> read = texts(*source);
      EXPECT_GE(read.size(), most) << size;
      most = read.size();
    }
    EXPECT_EQ(most, 4U);
  }
}

TEST(Bag, SaysWhatItDoesNotRead) {
  const TemporaryFolder folder;
  EXPECT_THAT([&] { open_bag(folder.write("old.bag", "#ROSBAG V1.2\n")); },
              ::testing::ThrowsMessage<std::invalid_argument>(HasSubstr("rosbag fix")));
  const std::string header = op(3) + field("encryptor", "rosbag/AesCbcEncryptor");
  EXPECT_THAT([&] { open_bag(folder.write("secret.bag", "#ROSBAG V2.0\n" + record(header, ""))); },
              ::testing::ThrowsMessage<std::invalid_argument>(HasSubstr("encrypted")));
}

}  // namespace
}  // namespace marco::ros
