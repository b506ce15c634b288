#include <gmock/gmock.h>

#include <fstream>

#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "tools/many/slurm.hpp"
#include "tools/many/table.hpp"

namespace marco::many {
namespace {

namespace fs = std::filesystem;
using ::marco::testing::complaint;
using ::marco::testing::TemporaryFolder;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr const char* kCarmen = "FLASER 2 1.0 1.0 0 0 0 0 0 0 1.0 host 1.0\n";

class Recordings : public ::testing::Test {
 protected:
  Recordings() {
    fs::create_directories(folder_.path() / "b" / "rosbag");
    fs::create_directories(folder_.path() / "mapped");
    folder_.write("z.log", kCarmen);
    folder_.write("a b.log", kCarmen);
    folder_.write("notes.txt", "nothing\n");
    folder_.write(".hidden.log", kCarmen);
    folder_.write("b/z.log", kCarmen);
    folder_.write("b/rosbag/metadata.yaml", "");
    folder_.write("b/rosbag/x.mcap", "\x89MCAP0\r\n");
    folder_.write("mapped/report.json", "{}");
    folder_.write("mapped/slam.log", kCarmen);
  }
  std::vector<std::string> names(const std::vector<Entry>& entries) {
    std::vector<std::string> names;
    for (const Entry& entry : entries) names.push_back(entry.name);
    return names;
  }
  TemporaryFolder folder_;
};

TEST_F(Recordings, AreFoundInAFolderAndInFoldersWithinIt) {
  const auto entries = with_names({}, find_recordings({folder_.path()}));
  EXPECT_THAT(names(entries), ElementsAre("a_b", "rosbag", "z", "z_2"));
  EXPECT_TRUE(entries[0].parts.front().is_absolute());
}

TEST_F(Recordings, AreListedOneALine) {
  const fs::path list = folder_.write("list.txt", "# ours\nz.log\r\n\nb/z.log\n");
  EXPECT_THAT(names(with_names({}, find_recordings({list}))), ElementsAre("z", "z_2"));
  folder_.write("list.txt", "gone.log\n");
  EXPECT_THAT(complaint([&] { find_recordings({list}); }), HasSubstr("gone.log"));
  EXPECT_THAT(complaint([&] { find_recordings({folder_.path() / "none"}); }),
              HasSubstr("is missing"));
}

TEST_F(Recordings, OfSeveralPartsAreOneLine) {
  const auto entries = with_names({}, {{"/logs/run_0.bag", "/logs/run_1.bag"}, {"/logs/z_0.bag"}});
  EXPECT_THAT(names(entries), ElementsAre("run", "z_0"));
  write_list(folder_.path() / "list.tsv", entries);
  const auto again = read_list(folder_.path() / "list.tsv");
  ASSERT_EQ(again.size(), 2U);
  EXPECT_EQ(again[0].parts, entries[0].parts);
  EXPECT_THAT(names(with_names(again, {{"/logs/run_1.bag", "/logs/run_2.bag"}})),
              ElementsAre("run", "z_0"));
}

TEST_F(Recordings, KeepTheirNamesWhenOthersCome) {
  const auto first = with_names({}, find_recordings({folder_.path() / "b"}));
  EXPECT_THAT(names(first), ElementsAre("rosbag", "z"));
  write_list(folder_.path() / "list.tsv", first);
  const auto more =
      with_names(read_list(folder_.path() / "list.tsv"), find_recordings({folder_.path()}));
  EXPECT_THAT(names(more), ElementsAre("rosbag", "z", "a_b", "z_2"));
  EXPECT_EQ(more[1].parts, first[1].parts);
}

TEST(Table, TellsOfEachWhatBecameOfIt) {
  const TemporaryFolder folder;
  const Store store{folder.path()};
  fs::create_directories(store.jobs());
  fs::create_directories(folder.path() / "good");
  folder.write("good/report.json",
               R"({"inputs": [{"format": "ROS bag"}], "scans": {"posed": 12}, "distance_m": 3.456,
                   "loops": [{"in_force": true}, {"in_force": false}], "verdict": "good",
                   "cpu_s": 1.25})");
  folder.write("good/map.png", "");
  record_failure(store, {"bad", {"/bad"}}, "no laser: it holds \"a\", <b>", 0.5);
  const auto rows =
      write_table(store, {{"good", {"/good"}}, {"bad", {"/bad"}}, {"none", {"/none"}}});
  EXPECT_EQ(csv_of(rows),
            "log,format,scans,length_m,loops,verdict,cpu_s,picture,reason,path\r\n"
            "good,ROS bag,12,3.46,1,good,1.25,good/map.png,,/good\r\n"
            "bad,,0,0.00,0,failed,0.50,,\"no laser: it holds \"\"a\"\", <b>\",/bad\r\n"
            "none,,0,0.00,0,not done,0.00,,,/none\r\n");
  const std::string page = html_of(rows);
  EXPECT_THAT(page, HasSubstr("3 recordings, 1 good, 0 doubtful, 0 wrong, 1 failed, 1 not done"));
  EXPECT_THAT(page, HasSubstr("failed: no laser: it holds &quot;a&quot;, &lt;b&gt;"));
  EXPECT_THAT(page, HasSubstr("src=\"good/map.png\""));
  EXPECT_TRUE(fs::exists(folder.path() / "index.html"));
}

TEST(Slurm, TakesRangesAndQuotedWords) {
  EXPECT_EQ(array_of({1, 2, 3, 7, 9, 10}), "1-3,7,9-10");
  EXPECT_EQ(array_of({4}), "4");
  EXPECT_EQ(quoted("it's $HOME"), "'it'\\''s $HOME'");
}

}  // namespace
}  // namespace marco::many
