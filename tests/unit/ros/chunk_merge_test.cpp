#include "recordings/ros/chunk_merge.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <map>
#include <random>
#include <string>

namespace marco::ros {
namespace {

using ::testing::Each;
using ::testing::Pair;

struct Text {
  int64_t at_ns;
  std::string bytes;

  bool operator==(const Text&) const = default;
};
using Chunks = std::vector<std::vector<Text>>;

// Few instants, so that many messages share one, in chunks of any length, some of them empty.
Chunks random_chunks(int count, int64_t span_ns, unsigned seed) {
  std::mt19937 random(seed);
  Chunks chunks(static_cast<std::size_t>(count));
  int number = 0;
  for (std::size_t i = 0; i < chunks.size(); ++i) {
    const auto from_ns = static_cast<int64_t>(random() % 500);
    for (auto left = random() % 12; left > 0; --left) {
      const int64_t at_ns =
          from_ns + static_cast<int64_t>(random() % static_cast<unsigned>(span_ns));
      chunks[i].push_back({at_ns, std::to_string(number++) + std::string(random() % 300, '.')});
    }
  }
  return chunks;
}

std::vector<Text> in_order(const Chunks& chunks) {
  std::vector<Text> all;
  for (const auto& chunk : chunks) all.insert(all.end(), chunk.begin(), chunk.end());
  std::stable_sort(all.begin(), all.end(),
                   [](const Text& a, const Text& b) { return a.at_ns < b.at_ns; });
  return all;
}

struct Merged {
  std::vector<Text> all;
  std::map<std::size_t, int> loads;  // of each chunk
  std::size_t runs = 0;
};

Merged merge(const Chunks& chunks, std::size_t most_held_bytes) {
  std::vector<ChunkPlace> places;
  std::vector<uint32_t> used;
  for (const auto& chunk : chunks) {
    used.push_back(static_cast<uint32_t>(places.size()));
    ChunkPlace& place = places.emplace_back();
    const auto is_before = [](const Text& a, const Text& b) { return a.at_ns < b.at_ns; };
    if (chunk.empty()) continue;
    place.start_ns = std::min_element(chunk.begin(), chunk.end(), is_before)->at_ns;
  }
  Merged merged;
  ChunkMerge merge(
      places, used,
      [&](std::size_t chunk, const ChunkMerge::Keep& keep) {
        ++merged.loads[chunk];
        for (const Text& text : chunks[chunk]) {
          keep({text.at_ns,
                0,
                0,
                {reinterpret_cast<const uint8_t*>(text.bytes.data()), text.bytes.size()}});
        }
      },
      most_held_bytes);
  while (const auto message = merge.next()) {
    merged.all.push_back({message->received_ns, {message->bytes.begin(), message->bytes.end()}});
  }
  merged.runs = merge.runs();
  return merged;
}

TEST(ChunkMerge, KeepsTheOrderWhateverMayBeHeldAndLoadsEachChunkOnce) {
  for (const int64_t span_ns : {5, 100, 1000}) {
    const Chunks chunks = random_chunks(200, span_ns, 7);
    const std::vector<Text> wanted = in_order(chunks);
    for (const std::size_t most : {std::size_t{500}, std::size_t{20'000}, kMostHeldBytes}) {
      const Merged merged = merge(chunks, most);
      EXPECT_TRUE(merged.all == wanted) << span_ns << " " << most;
      EXPECT_EQ(merged.loads.size(), chunks.size());
      EXPECT_THAT(merged.loads, Each(Pair(::testing::_, 1)));
      if (most == 500) {
        EXPECT_GT(merged.runs, 0U) << span_ns;
      }
      if (most == kMostHeldBytes) {
        EXPECT_EQ(merged.runs, 0U) << span_ns;
      }
    }
  }
}

TEST(ChunkMerge, OfChunksThatFollowEachOtherNothingGoesToDisk) {
  Chunks chunks;
  for (int i = 0; i < 400; ++i)
    chunks.push_back({{2 * i, std::string(900, 'a')}, {2 * i + 1, "b"}});
  const Merged merged = merge(chunks, 2000);
  EXPECT_TRUE(merged.all == in_order(chunks));
  EXPECT_EQ(merged.runs, 0U);
}

}  // namespace
}  // namespace marco::ros
