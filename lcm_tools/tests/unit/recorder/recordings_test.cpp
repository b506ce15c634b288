#include "lcm_tools/recorder/recordings.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lcm_tools/files/event_log.hpp"
#include "lcm_tools/tests/support/temporary_folder.hpp"

namespace marco::recorder {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using testing::TemporaryFolder;

constexpr int64_t kGb = 1'000'000'000;
constexpr std::time_t kNow = 1'764'339'802;

/// A recording that has ended, of `bytes`. @returns its folder
fs::path ended(const fs::path& home, std::time_t began, const std::string& bytes = "12345") {
  const RunningRecording recording(home, began);
  std::ofstream(recording.folder() / "live.lcm.00") << bytes;
  return recording.folder();
}

std::vector<fs::path> folders(const std::vector<Recording>& recordings) {
  std::vector<fs::path> result;
  result.reserve(recordings.size());
  for (const Recording& recording : recordings) result.push_back(recording.folder);
  return result;
}

TEST(Recordings, EachHasANameOfItsOwnAndTheOrderOfItsBeginning) {
  const TemporaryFolder home;
  std::vector<fs::path> begun;
  // Three in a second, one after the clock stepped back for a day, one with no clock at all.
  for (const std::time_t time : {kNow, kNow, kNow, kNow - 86400, std::time_t{0}, kNow}) {
    begun.push_back(ended(home.path(), time));
  }
  EXPECT_THAT(folders(recordings_in(home.path())), ::testing::ElementsAreArray(begun));
  EXPECT_THAT(begun[0].filename(), ::testing::ContainsRegex("^2025-11-2[78]_..-..-..$"));
}

TEST(Recordings, ATenthOfTheDiskStaysFreeAtMostFiveGigabytes) {
  EXPECT_EQ(reserve_bytes({0, 16 * kGb}), 16 * kGb / 10);
  EXPECT_EQ(reserve_bytes({0, 4000 * kGb}), 5 * kGb);
}

TEST(Recordings, TheOldestGoAsManyAsNeedBe) {
  const Recording a{"a", 1, kGb, false, ""}, kept{"b", 2, 9 * kGb, false, "kept"},
      c{"c", 3, kGb, false, ""}, d{"d", 4, kGb, false, ""}, running{"e", 5, 9 * kGb, true, ""};
  const std::vector<Recording> all{a, kept, c, d, running};
  const int64_t total = 100 * kGb;
  EXPECT_THAT(in_the_way(all, {5 * kGb, total}), IsEmpty());
  EXPECT_THAT(folders(in_the_way(all, {5 * kGb - 1, total})), ElementsAre("a"));
  EXPECT_THAT(folders(in_the_way(all, {4 * kGb - 1, total})), ElementsAre("a", "c"));
  EXPECT_THAT(folders(in_the_way(all, {2 * kGb, total})), ElementsAre("a", "c", "d"));
  // All that may go would not do: it would be lost for nothing.
  EXPECT_THAT(in_the_way(all, {2 * kGb - 1, total}), IsEmpty());
}

TEST(Recordings, WhatOthersPutThereOrSomebodyKeptMayNotGo) {
  const TemporaryFolder home;
  const auto kept = ended(home.path(), kNow), renamed = ended(home.path(), kNow + 1),
             mixed = ended(home.path(), kNow + 2), linked = ended(home.path(), kNow + 3);
  keep(kept, Keep::forever);
  fs::rename(renamed, home.path() / "kitchen");
  std::ofstream(mixed / "notes.txt") << "mine";
  home.write("elsewhere", "mine, too");
  fs::create_symlink(home.path() / "elsewhere", linked / "live.lcm.01");
  fs::create_directories(home.path() / "2020-01-01_00-00-00");  // of nobody's: no marker
  home.write("live.lcm.0", "a recording of an older version");
  std::vector<std::string> why;
  for (const Recording& recording : recordings_in(home.path())) why.push_back(recording.kept);
  EXPECT_THAT(why, ElementsAre("kept", "renamed", "holds other files", "holds other files"));
  keep(kept, Keep::until_room_is_needed);
  EXPECT_TRUE(recordings_in(home.path()).front().may_go());
  EXPECT_THROW(keep(home.path() / "2020-01-01_00-00-00", Keep::forever), std::invalid_argument);
}

TEST(Recordings, OneThatRunsMayNotGo) {
  const TemporaryFolder home;
  const RunningRecording running(home.path(), kNow);
  EXPECT_TRUE(recordings_in(home.path()).front().running);
  EXPECT_FALSE(recordings_in(home.path()).front().may_go());
  EXPECT_EQ(keep_newest(home.path()), running.name());
}

TEST(Recordings, RemovingTakesARecordingAndNothingElse) {
  const TemporaryFolder home;
  const auto first = ended(home.path(), kNow), second = ended(home.path(), kNow + 1);
  const Recording doomed = recordings_in(home.path()).front();
  EXPECT_EQ(doomed.bytes, 5);
  std::ofstream(first / "came just now") << "mine";
  EXPECT_THROW(remove(doomed), fs::filesystem_error);
  EXPECT_TRUE(fs::exists(first / "came just now"));
  fs::remove(first / "came just now");
  fs::remove(first);
  remove(recordings_in(home.path()).front());
  EXPECT_FALSE(fs::exists(second));
}

TEST(Recordings, LengthIsFromTheFirstToTheLastEventOfAllPieces) {
  const TemporaryFolder home;
  const auto folder = ended(home.path(), kNow, "");
  EXPECT_EQ(length_s(folder), std::nullopt);
  const std::vector<uint8_t> large(3
                                   << 20);  // the last events are farther from the end than others
  for (const int piece : {9, 100}) {
    files::EventLogWriter writer(folder / ("live.lcm." + std::to_string(piece)));
    for (int i = 0; i < 3; ++i) {
      writer.write("A", large, Utime::from_us(1'000'000 * (piece + i)));
    }
  }
  EXPECT_EQ(length_s(folder), 102.0 - 9.0);
}

}  // namespace
}  // namespace marco::recorder
