#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "lcm_tools/log/merge.hpp"
#include "lcm_tools/log/select.hpp"
#include "lcm_tools/tests/unit/log/tiny_log.hpp"

namespace marco::logs {
namespace {

using ::testing::ElementsAre;

std::vector<int64_t> numbers(const std::string& path) {
  std::vector<int64_t> result;
  for (const auto& event : read_events(path)) result.push_back(event.number);
  return result;
}

SelectResult select(const std::string& in,
                    const std::string& path,
                    const TimeRange& range,
                    ChannelChoice channels) {
  OutputFile out(path, Existing::refuse, {in});
  const SelectResult result = select_events(in, out, range, channels, ignore_progress);
  out.finish();
  return result;
}

TEST(Select, KeepsTheEventsOfATimeRangeAsTheyAre) {
  const ScratchFolder folder;
  write_poses(folder / "in", 10);
  const TimeRange range{Utime::from_us(kStartUs + 300000), Utime::from_us(kStartUs + 600000)};
  const SelectResult result = select(folder / "in", folder / "out", range, {});
  EXPECT_EQ(result.events, 10);
  EXPECT_EQ(result.kept, 3);
  EXPECT_THAT(numbers(folder / "out"), ElementsAre(3, 4, 5));
  const std::string all = read_text(folder / "in"), part = read_text(folder / "out");
  EXPECT_NE(all.find(part), std::string::npos);
  EXPECT_EQ(result.kept_bytes, static_cast<int64_t>(part.size()));
}

TEST(Select, ChannelsByNameOrPatternKeptOrDropped) {
  const ScratchFolder folder;
  write_poses(folder / "in", 6);
  select(folder / "in", folder / "named", {}, {{"OTHER"}, ChannelChoice::Sense::keep});
  EXPECT_THAT(numbers(folder / "named"), ElementsAre(1, 3, 5));
  select(folder / "in", folder / "pattern", {}, {{"NO", "TRUE_.*"}, ChannelChoice::Sense::keep});
  EXPECT_THAT(numbers(folder / "pattern"), ElementsAre(0, 2, 4));
  select(folder / "in", folder / "dropped", {}, {{"TRUE_.*"}, ChannelChoice::Sense::drop});
  EXPECT_THAT(numbers(folder / "dropped"), ElementsAre(1, 3, 5));
  EXPECT_THROW(ChannelChoice({"("}, ChannelChoice::Sense::keep), std::invalid_argument);
}

// Long runs go through the kernel, short ones through the buffer: both must be what a plain copy
// is.
TEST(Select, RunsOfAnyLengthAreCopiedExactly) {
  const ScratchFolder folder;
  std::mt19937 random(3);
  std::string expected;
  {
    files::EventLogWriter writer(folder / "in");
    for (int i = 0; i < 600; ++i) {
      std::vector<uint8_t> bytes(random() % (i % 37 == 0 ? 300000 : 3000));
      for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(random());
      // Runs of one channel, of 1 to 100 events.
      const bool kept = (i / (1 + i / 6)) % 2 == 0;
      writer.write(kept ? "KEPT" : "NOT", bytes, Utime::from_us(i));
      if (!kept) continue;
      const auto header = files::event_header(i, Utime::from_us(i), "KEPT", bytes.size());
      expected.append(header.begin(), header.end());
      expected += "KEPT";
      expected.append(bytes.begin(), bytes.end());
    }
  }
  select(folder / "in", folder / "out", {}, {{"KEPT"}, ChannelChoice::Sense::keep});
  EXPECT_TRUE(read_text(folder / "out") == expected);
}

TEST(OutputFile, KeepsWhatIsThereAndLeavesNothingHalfDone) {
  const ScratchFolder folder;
  write_text(folder / "there", "precious");
  EXPECT_THROW(OutputFile(folder / "there", Existing::refuse, {}), std::invalid_argument);
  EXPECT_THROW(OutputFile(folder / "there", Existing::replace, {folder / "there"}),
               std::invalid_argument);
  {
    OutputFile out(folder / "there", Existing::replace, {});
    out.write(std::string_view("half"));
  }
  EXPECT_EQ(read_text(folder / "there"), "precious");
  EXPECT_FALSE(std::filesystem::exists(folder / "there.part"));
  EXPECT_THROW(OutputFile(folder / "no/such", Existing::refuse, {}), std::runtime_error);
}

TEST(Merge, GoesByEventTimeAndNumbersAnew) {
  const ScratchFolder folder;
  write_poses(folder / "a", 3);                    // 0, 100, 200 ms
  write_poses(folder / "b", 3, kStartUs + 50000);  // 50, 150, 250 ms
  OutputFile out(folder / "out", Existing::refuse, {});
  const MergeResult result =
      merge_logs({{folder / "a", {}, ""}, {folder / "b", {}, "B_"}}, out, ignore_progress);
  out.finish();
  EXPECT_THAT(result.events, ElementsAre(3, 3));
  const auto events = read_events(folder / "out");
  ASSERT_EQ(events.size(), 6U);
  for (std::size_t i = 0; i < events.size(); ++i) {
    EXPECT_EQ(events[i].number, static_cast<int64_t>(i));
    EXPECT_EQ(events[i].event_time.us, kStartUs + 50000 * static_cast<int64_t>(i));
  }
  EXPECT_EQ(events[1].channel, "B_TRUE_POSE");
  EXPECT_EQ(events[1].bytes, pose_bytes(kStartUs + 50000, 0));
}

TEST(Merge, AShiftMovesEventTimesAndTiesKeepTheOrderOfTheInputs) {
  const ScratchFolder folder;
  write_poses(folder / "a", 2);
  write_poses(folder / "b", 2, kStartUs + 1000000);
  OutputFile out(folder / "out", Existing::refuse, {});
  merge_logs({{folder / "a", {}, "A_"}, {folder / "b", Duration::from_seconds(-1.0), "B_"}}, out,
             ignore_progress);
  out.finish();
  std::vector<std::string> channels;
  for (const auto& event : read_events(folder / "out")) channels.push_back(event.channel);
  EXPECT_THAT(channels, ElementsAre("A_TRUE_POSE", "B_TRUE_POSE", "A_OTHER", "B_OTHER"));
}

}  // namespace
}  // namespace marco::logs
