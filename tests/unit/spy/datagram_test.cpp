#include "tools/spy/datagram.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <set>

#include "tests/unit/spy/spy_fixture.hpp"
#include "tools/spy/statistics.hpp"

namespace marco::spy {
namespace {

TEST(Datagram, ShortOnesAreRead) {
  const auto bytes = short_datagram(7, "POSE", {1, 2, 3});
  const auto datagram = parse_datagram(bytes);
  ASSERT_TRUE(datagram);
  EXPECT_EQ(datagram->sequence, 7U);
  EXPECT_EQ(datagram->channel, "POSE");
  EXPECT_THAT(datagram->payload, ::testing::ElementsAre(1, 2, 3));
  EXPECT_FALSE(datagram->fragmented);
}

TEST(Datagram, WhatIsNotLcmsIsRefused) {
  EXPECT_FALSE(parse_datagram({}));
  EXPECT_FALSE(parse_datagram(short_datagram(1, std::string(64, 'A'), {1})));
  EXPECT_TRUE(parse_datagram(short_datagram(1, std::string(63, 'A'), {1})));
  EXPECT_FALSE(parse_datagram(short_datagram(1, "", {1})));
  auto other = short_datagram(1, "A", {1});
  other[3] = '1';
  EXPECT_FALSE(parse_datagram(other));
  auto fragment = fragment_datagrams(1, "A", std::vector<uint8_t>(100), 60)[1];
  fragment[15] = 61;  // offset + data beyond the message
  EXPECT_FALSE(parse_datagram(fragment));
  fragment[15] = 60;
  EXPECT_TRUE(parse_datagram(fragment));
  fragment[17] = 2;  // fragment 2 of 2
  EXPECT_FALSE(parse_datagram(fragment));
}

TEST(Datagram, SurvivesAnyBytes) {
  std::mt19937 random(3);
  const auto fragments = fragment_datagrams(1, "CHANNEL", std::vector<uint8_t>(400), 100);
  Reassembler reassembler;
  std::vector<std::string> incomplete;
  for (int round = 0; round < 3000; ++round) {
    auto bytes = fragments[random() % fragments.size()];
    for (int flip = 0; flip < 2; ++flip)
      bytes[4 + random() % 20] = static_cast<uint8_t>(random() % 3);
    bytes.resize(random() % (bytes.size() + 1));
    if (const auto datagram = parse_datagram(bytes); datagram && datagram->fragmented) {
      reassembler.add(*datagram, round, incomplete);
    }
  }
  EXPECT_FALSE(incomplete.empty());
}

// Oracle: a set of all numbers seen.
TEST(SequenceTracker, CountsWhatIsMissingLateOrDoubled) {
  std::mt19937 random(5);
  SequenceTracker tracker;
  std::set<uint32_t> seen;
  std::vector<uint32_t> order;
  for (uint32_t i = 0; i < 5000; ++i) {
    if (i > 0 && i < 4999 && random() % 10 == 0) continue;
    order.push_back(i + 4294965000U);  // across the overflow of 32 bits
    if (random() % 20 == 0) order.push_back(order.back());
  }
  for (std::size_t i = 1; i + 2 < order.size(); i += 2) {
    if (random() % 4 == 0) std::swap(order[i], order[i + 1]);
  }
  int64_t duplicates = 0;
  for (const uint32_t number : order) {
    const bool fresh = seen.insert(number).second;
    EXPECT_EQ(tracker.add(number), fresh);
    duplicates += fresh ? 0 : 1;
  }
  EXPECT_EQ(tracker.lost(), 5000 - static_cast<int64_t>(seen.size()));
  EXPECT_EQ(tracker.duplicates(), duplicates);
  EXPECT_EQ(tracker.restarts(), 0);
}

TEST(SequenceTracker, ASenderThatBeginsAnewHasLostNothing) {
  SequenceTracker tracker;
  for (uint32_t i = 100000; i < 100010; ++i) tracker.add(i);
  for (uint32_t i = 0; i < 10; ++i) EXPECT_TRUE(tracker.add(i));
  EXPECT_EQ(tracker.lost(), 0);
  EXPECT_EQ(tracker.restarts(), 1);
}

TEST(SequenceTracker, AWideGapIsCountedWhole) {
  SequenceTracker tracker;
  tracker.add(0);
  tracker.add(1000000);
  EXPECT_EQ(tracker.lost(), 999999);
  EXPECT_TRUE(tracker.add(999999));  // late
  EXPECT_EQ(tracker.lost(), 999998);
}

std::vector<uint8_t> numbered(std::size_t size) {
  std::vector<uint8_t> bytes(size);
  for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<uint8_t>(i * 7);
  return bytes;
}

TEST(Reassembler, PutsFragmentsTogetherInAnyOrder) {
  const auto data = numbered(1000);
  auto fragments = fragment_datagrams(9, "CAMERA", data, 130);
  std::shuffle(fragments.begin(), fragments.end(), std::mt19937(1));
  Reassembler reassembler;
  std::vector<std::string> incomplete;
  for (std::size_t i = 0; i < fragments.size(); ++i) {
    const auto message = reassembler.add(*parse_datagram(fragments[i]), 0, incomplete);
    ASSERT_EQ(message.has_value(), i + 1 == fragments.size());
    if (!message) continue;
    EXPECT_EQ(message->channel, "CAMERA");
    EXPECT_THAT(message->bytes(), ::testing::ElementsAreArray(data));
  }
  EXPECT_TRUE(reassembler.empty());
}

TEST(Reassembler, GivesUpOldOnesAndNamesTheirChannels) {
  Reassembler reassembler;
  std::vector<std::string> incomplete;
  for (uint32_t i = 0; i < 6; ++i) {
    const auto fragments = fragment_datagrams(i, "CAMERA", numbered(300), 100);
    reassembler.add(*parse_datagram(fragments[i == 0 ? 1 : 0]), 100 * i, incomplete);
  }
  EXPECT_THAT(incomplete, ::testing::ElementsAre("", "CAMERA"));
  reassembler.give_up(450, incomplete);
  EXPECT_THAT(incomplete, ::testing::SizeIs(5));
  EXPECT_TRUE(reassembler.holds(5));
  EXPECT_FALSE(reassembler.holds(4));
}

TEST(RateMeter, ASteadyChannelHasItsRateAndNoJitter) {
  RateMeter meter;
  for (int i = 0; i < 500; ++i) meter.add(1'000'000'000 + 10000 * i, 50);
  const Rates recent = meter.recent(1'000'000'000 + 10000 * 500);
  EXPECT_NEAR(recent.hz, 100, 1e-9);
  EXPECT_NEAR(recent.bytes_per_s, 5000, 1e-6);
  EXPECT_EQ(recent.jitter_s, 0);
  EXPECT_NEAR(meter.overall().hz, 100, 1e-9);
}

TEST(RateMeter, JitterIsLongestMinusShortestIntervalOfTheLastTwoSeconds) {
  RateMeter meter;
  meter.add(0, 1);
  meter.add(3'000'000, 1);  // the long interval ends too long ago
  for (int i = 1; i <= 40; ++i) meter.add(3'000'000 + 100000 * i + (i == 39 ? 20000 : 0), 1);
  // Intervals of 100, 120 and 80 ms.
  EXPECT_NEAR(meter.recent(7'000'000).jitter_s, 0.04, 1e-9);
  EXPECT_NEAR(meter.overall().jitter_s, 3 - 0.08, 1e-9);
}

TEST(RateMeter, ASlowOrSilentChannelFallsTowardsZero) {
  RateMeter meter;
  meter.add(0, 10);
  EXPECT_EQ(meter.recent(5'000'000).hz, 0);
  meter.add(5'000'000, 10);
  EXPECT_NEAR(meter.recent(5'100'000).hz, 0.2, 1e-9);
  EXPECT_NEAR(meter.recent(25'000'000).hz, 0.05, 1e-9);
}

TEST(RateMeter, WildTimesDoNoHarm) {
  RateMeter meter;
  for (const int64_t time : {INT64_MAX, INT64_MIN, int64_t{0}, int64_t{-1}, INT64_MAX})
    meter.add(time, 1);
  EXPECT_EQ(meter.count(), 5);
  EXPECT_GE(meter.recent(INT64_MIN).hz, 0);
  EXPECT_GE(meter.overall().hz, 0);
}

}  // namespace
}  // namespace marco::spy
