#include "lcm_tools/log/repair.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <random>

#include "lcm_tools/log/event_sequence.hpp"
#include "lcm_tools/log/restore.hpp"
#include "lcm_tools/log/types.hpp"
#include "lcm_tools/tests/unit/log/tiny_log.hpp"

namespace marco::logs {
namespace {

constexpr int64_t kPoseBytes = 8 + 8 + 3 * 8;
constexpr int64_t kTrueEvent = 28 + 9 + kPoseBytes;   // TRUE_POSE
constexpr int64_t kOtherEvent = 28 + 5 + kPoseBytes;  // OTHER
constexpr int64_t kPair = kTrueEvent + kOtherEvent;

class Repair : public ::testing::Test {
 protected:
  Repair() {
    write_poses(folder_ / "good", 40);
    bytes_ = read_text(folder_ / "good");
  }
  // Offset of the header of event `number`.
  static int64_t event(int number) {
    return number / 2 * kPair + (number % 2 == 1 ? kTrueEvent : 0);
  }
  void damage(int64_t offset, char value) { bytes_[static_cast<std::size_t>(offset)] = value; }
  RepairReport repair(Mending mending = Mending::headers) {
    write_text(folder_ / "bad", bytes_);
    OutputFile out(folder_ / "out", Existing::replace, {});
    const RepairReport report = repair_log(
        folder_ / "bad", out, mending,
        [this](std::span<const uint8_t> message) { return types_.decodes(message); },
        ignore_progress);
    out.finish();
    return report;
  }
  bool is_as_it_was() { return read_text(folder_ / "out") == read_text(folder_ / "good"); }

  ScratchFolder folder_;
  Types types_{{"tests/types"}};
  std::string bytes_;
};

TEST_F(Repair, AWholeLogComesOutAsItIs) {
  const RepairReport report = repair();
  EXPECT_EQ(report.untouched, 40);
  EXPECT_EQ(report.lost_bytes, 0);
  EXPECT_TRUE(is_as_it_was());
}

TEST_F(Repair, EachFieldOfAHeaderIsMendedFromWhatLiesAround) {
  const struct {
    int64_t offset;
    char value;
    const char* what;
  } cases[] = {
      {0, 'x', "sync word"},          {4, '\x70', "number"},
      {11, '\x01', "number"},         {12, '\x11', "time"},
      {15, '\x7f', "time"},           {20, '\x01', "channel length"},
      {23, '\x44', "channel length"}, {23, '\x02', "channel length"},
      {24, '\x01', "data length"},    {27, '\x70', "data length"},
      {27, '\x05', "data length"},    {28, 'Y', "channel"},
      {30, '\x01', "channel"},        {28 + 9, '\x55', "fingerprint"},
  };
  const std::string good = bytes_;
  for (const auto& one : cases) {
    bytes_ = good;
    damage(event(20) + one.offset, one.value);
    const RepairReport report = repair();
    EXPECT_TRUE(is_as_it_was()) << one.what << " at " << one.offset;
    EXPECT_EQ(report.lost_bytes, 0) << one.what;
    ASSERT_EQ(report.mended_events.size(), 1U) << one.what << " at " << one.offset;
    EXPECT_EQ(report.mended_events[0].what, one.what) << one.offset;
    EXPECT_EQ(report.mended_events[0].number, 20);
  }
}

TEST_F(Repair, FirstAndLastEventAreMendedToo) {
  damage(0, 'x');
  damage(event(39) + 4, '\x70');
  const RepairReport report = repair();
  EXPECT_TRUE(is_as_it_was());
  EXPECT_EQ(report.events - report.untouched, 2);
}

TEST_F(Repair, NeighboursDamagedTogether) {
  damage(event(10), 'x');          // sync word
  damage(event(11), 'x');          // and of the next
  damage(event(20) + 27, '\x70');  // length swallows the next event,
  damage(event(21) + 27, '\x71');  // whose length is wrong, too
  const RepairReport report = repair();
  EXPECT_TRUE(is_as_it_was());
  EXPECT_EQ(report.mended.at("sync word"), 2);
  EXPECT_EQ(report.mended.at("data length"), 2);
}

TEST_F(Repair, WhatCannotBeMendedIsReportedWithItsPlace) {
  // Event 5: sync word and both lengths gone.
  for (const int64_t offset : {0, 1, 20, 21, 24, 25}) damage(event(5) + offset, '\x7f');
  bytes_.resize(bytes_.size() - 10);  // the last event is cut off
  const RepairReport report = repair();
  EXPECT_EQ(report.events, 38);
  EXPECT_EQ(report.lost_places, 2);
  ASSERT_EQ(report.lost.size(), 2U);
  EXPECT_EQ(report.lost[0].offset, event(5));
  EXPECT_EQ(report.lost[0].bytes, kOtherEvent);
  EXPECT_EQ(report.lost[1].offset, event(39));
  EXPECT_EQ(report.lost[1].bytes, kOtherEvent - 10);
  EXPECT_EQ(report.missing_numbers, 1);
  EXPECT_NE(to_text(report).find(std::to_string(kOtherEvent) + " bytes at byte " +
                                 std::to_string(event(5))),
            std::string::npos);
  EXPECT_EQ(nlohmann::json::parse(to_json(report)).at("lost").size(), 2U);
}

TEST_F(Repair, AsIsKeepsWholeEventsOnlyAndChangesNone) {
  damage(event(20), 'x');
  damage(event(30) + 12, '\x11');
  const RepairReport report = repair(Mending::nothing);
  EXPECT_EQ(report.events, 39);
  EXPECT_EQ(report.untouched, 39);
  EXPECT_EQ(report.lost_bytes, kTrueEvent);
  EXPECT_EQ(read_events(folder_ / "out").size(), 39U);
}

TEST_F(Repair, OneMessageOfItsOwnChannelIsNotTakenForDamage) {
  {
    files::EventLogWriter writer(folder_ / "good");
    for (int i = 0; i < 40; ++i) {
      const int64_t us = kStartUs + 100000 * i;
      // Differs from TRUE_POSE by two bytes; and another type than the channel it resembles.
      if (i == 7) writer.write("TRUE_P0S3", pose_bytes(us, i), Utime::from_us(us));
      if (i == 9) {
        writer.write("TRUE_POSF", testing::encoded(robot::slam_pose_t{}), Utime::from_us(us));
      }
      writer.write("TRUE_POSE", pose_bytes(us, i), Utime::from_us(us));
    }
  }
  bytes_ = read_text(folder_ / "good");
  const RepairReport report = repair();
  EXPECT_EQ(report.untouched, report.events);
  EXPECT_TRUE(is_as_it_was());
}

// Events of a type nobody knows, of many lengths, the third one of `third_bytes` bytes.
std::vector<int64_t> write_texts(const std::string& path, std::size_t third_bytes) {
  std::vector<int64_t> begins;
  files::EventLogWriter writer(path);
  int64_t at = 0;
  for (std::size_t i = 0; i < 20; ++i) {
    const std::string text = "some text" + std::string(5 * i, '.');
    const std::size_t bytes = i == 3 ? third_bytes : text.size();
    begins.push_back(at);
    writer.write("TEXT", {reinterpret_cast<const uint8_t*>(text.data()), bytes},
                 Utime::from_us(kStartUs + static_cast<int64_t>(i) * 100000));
    at += static_cast<int64_t>(28 + 4 + bytes);
  }
  return begins;
}

// What lies between two events could be the end of the first, if its length was wrong; it is not
// when the message is whole as it is.
TEST_F(Repair, JunkBehindAWholeEventIsNoPartOfIt) {
  const auto begins = write_texts(folder_ / "good", 24);
  bytes_ = read_text(folder_ / "good");
  bytes_.insert(static_cast<std::size_t>(begins[4]), std::string(40, 'j'));
  const RepairReport report = repair();
  EXPECT_EQ(report.lost_bytes, 40);
  EXPECT_EQ(report.untouched, 20);
  EXPECT_TRUE(is_as_it_was());
}

TEST_F(Repair, AShortEventDoesNotSwallowTheDamagedOneBehindIt) {
  const auto begins = write_texts(folder_ / "good", 4);  // too short for a fingerprint
  bytes_ = read_text(folder_ / "good");
  damage(begins[4] + 1, 'x');  // sync word
  const RepairReport report = repair();
  EXPECT_EQ(report.events, 20);
  EXPECT_EQ(report.lost_bytes, 0);
  EXPECT_TRUE(is_as_it_was());
}

TEST_F(Repair, AMessageThatDoesNotDecodeIsKeptAndCounted) {
  {
    files::EventLogWriter writer(folder_ / "good");
    for (int i = 0; i < 10; ++i) {
      std::vector<uint8_t> bytes = pose_bytes(kStartUs, i);
      if (i == 4) bytes.resize(bytes.size() - 4);
      if (i == 5) bytes.push_back(0);
      writer.write("TRUE_POSE", bytes, Utime::from_us(kStartUs + i));
    }
  }
  bytes_ = read_text(folder_ / "good");
  const RepairReport report = repair();
  EXPECT_EQ(report.events, 10);
  EXPECT_EQ(report.undecodable.at("TRUE_POSE"), 2);
}

TEST_F(Repair, AnyBytesAreRepairedWithoutACrashAndIntoAWholeLog) {
  const std::string good = bytes_;
  std::mt19937 random(5);
  for (int round = 0; round < 100; ++round) {
    bytes_ = good;
    const std::size_t flips = 1 + random() % 60;
    for (std::size_t i = 0; i < flips; ++i) {
      damage(static_cast<int64_t>(random() % bytes_.size()), static_cast<char>(random()));
    }
    if (round % 3 == 0) bytes_.resize(random() % bytes_.size());
    const RepairReport report = repair();
    files::EventLogReader reader(folder_ / "out");
    int64_t events = 0;
    while (reader.next_head()) ++events;
    EXPECT_EQ(events, report.events);
    EXPECT_EQ(reader.damage().places, 0);
  }
}

TEST(MendTime, TakesOneByteFromANeighbour) {
  const Utime before = Utime::from_us(kStartUs), after = Utime::from_us(kStartUs + 50000);
  const Utime time = Utime::from_us(kStartUs + 20000);
  EXPECT_FALSE(repaired_time(time, before, after));
  for (unsigned byte = 3; byte < 8; ++byte) {
    const Utime damaged =
        Utime::from_us(time.us ^ static_cast<int64_t>(uint64_t{0x41} << (8 * byte)));
    EXPECT_EQ(repaired_time(damaged, before, after), time) << byte;
  }
  // Two bytes: only their middle is known.
  const Utime twice = Utime::from_us(time.us ^ 0x4100410000000000);
  EXPECT_EQ(repaired_time(twice, before, after)->us, kStartUs + 25000);
  // Neighbours far apart know nothing.
  EXPECT_FALSE(repaired_time(twice, before, before + Duration::from_seconds(3600)));
}

}  // namespace
}  // namespace marco::logs
