#include "lcm_tools/diagnosis/datagram.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <set>

#include "lcm_tools/tests/unit/spy/spy_fixture.hpp"

namespace marco::spy {
namespace {

using diagnosis::Datagram;
using diagnosis::parse_datagram;
using diagnosis::Reassembler;
using diagnosis::SequenceTracker;

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

TEST(SequenceTracker, LossesForgottenAreNotFoundAgain) {
  SequenceTracker tracker;
  for (const uint32_t number : {10U, 13U}) tracker.add(number);
  EXPECT_EQ(tracker.lost(), 2);
  tracker.forget_losses();
  tracker.add(11);  // late
  EXPECT_EQ(tracker.lost(), 0);
  tracker.add(15);
  EXPECT_EQ(tracker.lost(), 1);
}

TEST(Reassembler, AFragmentThatComesTwiceCompletesNothing) {
  const auto fragments = fragment_datagrams(9, "CAMERA", numbered(300), 100);
  Reassembler reassembler;
  std::vector<std::string> incomplete;
  for (int copy = 0; copy < 5; ++copy) {
    for (const std::size_t i : {0U, 2U}) {
      EXPECT_FALSE(reassembler.add(*parse_datagram(fragments[i]), 0, incomplete));
    }
  }
  EXPECT_TRUE(reassembler.add(*parse_datagram(fragments[1]), 0, incomplete));
}

// Three messages of 100 MB are begun; the oldest gives way before 256 MB are passed.
TEST(Reassembler, KeepsNoMoreOpenThan256Megabytes) {
  Reassembler reassembler;
  std::vector<std::string> incomplete;
  for (uint32_t i = 0; i < 3; ++i) {
    Datagram datagram;
    const std::vector<uint8_t> data(10);
    datagram.sequence = i;
    datagram.channel = "MESH";
    datagram.payload = data;
    datagram.fragmented = true;
    datagram.message_bytes = 100U << 20U;
    datagram.fragments = 1000;
    EXPECT_FALSE(reassembler.add(datagram, i, incomplete));
    EXPECT_EQ(incomplete.size(), i < 2 ? 0U : 1U);
  }
  EXPECT_FALSE(reassembler.holds(0));
  EXPECT_TRUE(reassembler.holds(1));
  EXPECT_TRUE(reassembler.holds(2));
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

}  // namespace
}  // namespace marco::spy
