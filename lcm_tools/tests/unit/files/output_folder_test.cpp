#include "lcm_tools/files/output_folder.hpp"

#include <gmock/gmock.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <map>

#include "lcm_tools/files/event_log.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/tests/support/temporary_folder.hpp"

namespace marco::files {
namespace {

namespace fs = std::filesystem;
using ::marco::testing::complaint;
using ::marco::testing::TemporaryFolder;
using ::testing::HasSubstr;

using Files = std::map<std::string, std::string>;

// Names and contents, without what only OutputFolder reads.
Files content_of(const fs::path& folder) {
  Files content;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = entry.path().lexically_relative(folder).string();
    if (entry.is_directory() || name.find(".marco-") != std::string::npos) continue;
    content[name] = read_whole_file(entry.path());
  }
  return content;
}

void write_results(const fs::path& folder, const Files& files) {
  for (const auto& [name, text] : files) {
    fs::create_directories((folder / name).parent_path());
    write_whole_file(folder / name, text);
  }
}

void run_command(const fs::path& folder, const Files& files, FolderSeams seams = {}) {
  OutputFolder results(folder, "test", std::move(seams));
  write_results(results.path(), files);
  results.commit();
}

// How new results come in: one exchange, two renames where the file system refuses that, or file by
// file where no folder can stand in another's place.
enum class Way { exchange, renames, moves };

FolderSeams seams_of(Way way) {
  FolderSeams seams;
  if (way == Way::exchange) return seams;
  seams.exchange = [way](const fs::path&, const fs::path&) {
    return way == Way::renames ? EINVAL : EXDEV;
  };
  return seams;
}

const Files kFirst{{"map.png", "old map"}, {"lines.svg", "old lines"}, {"loops/1.png", "old loop"}};
const Files kSecond{{"map.png", "new map"}, {"model.ply", "new model"}};
const Files kOwn{{"note.txt", "mine"}, {"photos/a.jpg", "my picture"}};

Files both(Files files, const Files& more) {
  files.insert(more.begin(), more.end());
  return files;
}

class OutputFolderTest : public ::testing::TestWithParam<Way> {
 protected:
  FolderSeams seams() const { return seams_of(GetParam()); }
  fs::path out() const { return folder_.path() / "out"; }
  Files content() const { return content_of(out()); }
  void expect_no_leftovers() const {
    EXPECT_FALSE(fs::exists(folder_.path() / "out.part"));
    EXPECT_FALSE(fs::exists(folder_.path() / "out.part.old"));
    for (const char* name : {kWorkFolder, kWorkMark}) {
      EXPECT_FALSE(fs::exists(out() / name)) << name;
    }
  }
  TemporaryFolder folder_;
};

TEST_P(OutputFolderTest, EarlierResultsGoAndEverybodysOwnFilesStay) {
  run_command(out(), kFirst, seams());
  EXPECT_EQ(content(), kFirst);
  write_results(out(), kOwn);
  fs::create_symlink("note.txt", out() / "link");
  fs::create_directory(out() / "empty");
  const auto inode = [&](const char* name) {
    struct stat status = {};
    lstat((out() / name).c_str(), &status);
    return status.st_ino;
  };
  const ino_t note = inode("note.txt");
  run_command(out(), kSecond, seams());
  EXPECT_EQ(content(), both(both(kSecond, kOwn), {{"link", "mine"}}));
  EXPECT_EQ(inode("note.txt"), note);  // whoever appends to it right now goes on doing so
  EXPECT_TRUE(fs::is_symlink(out() / "link"));
  EXPECT_TRUE(fs::is_directory(out() / "empty"));
  EXPECT_FALSE(fs::exists(out() / "loops"));
  expect_no_leftovers();
}

TEST_P(OutputFolderTest, WithoutCommitTheFolderIsAsItWas) {
  run_command(out(), kFirst, seams());
  {
    OutputFolder results(out(), "test", seams());
    write_results(results.path(), kSecond);
  }
  EXPECT_EQ(content(), kFirst);
  expect_no_leftovers();
}

TEST_P(OutputFolderTest, AResultThatSomebodyChangedIsHisOwn) {
  run_command(out(), kFirst, seams());
  write_whole_file(out() / "lines.svg", "old lines, and a door drawn by hand");
  run_command(out(), kSecond, seams());
  EXPECT_EQ(content(), both(kSecond, {{"lines.svg", "old lines, and a door drawn by hand"}}));
}

TEST_P(OutputFolderTest, WhatTheCommandReadsStaysAndIsAResultStill) {
  run_command(out(), kFirst, seams());
  {
    OutputFolder results(out(), "test", seams());
    results.keep(out() / "lines.svg");
    results.keep("/etc/hostname");
    results.keep(out() / "no such file");
    write_results(results.path(), kSecond);
    results.commit();
  }
  EXPECT_EQ(content(), both(kSecond, {{"lines.svg", "old lines"}}));
  run_command(out(), kSecond, seams());
  EXPECT_EQ(content(), kSecond);
}

TEST_P(OutputFolderTest, ResultsOfAnotherCommandStay) {
  run_command(out(), kFirst, seams());
  OutputFolder results(out(), "other", seams());
  write_results(results.path(), kSecond);
  results.commit();
  EXPECT_EQ(content(), both(kSecond, kFirst));
}

TEST_P(OutputFolderTest, ALogThatLiesInTheFolderIsReadToItsEndAndThenReplaced) {
  const auto write_log = [](const fs::path& path, int events) {
    OutputFile file(path);
    EventLogWriter log(file);
    for (int i = 0; i < events; ++i) {
      log.write("LIDAR", std::vector<uint8_t>(10000, 7), Utime::from_us(i));
    }
    file.finish();
  };
  {
    OutputFolder results(out(), "test", seams());
    write_log(results.path() / "slam.lcm", 100);
    results.commit();
  }
  OutputFolder results(out(), "test", seams());
  EventLogReader reader((out() / "slam.lcm").string());
  write_log(results.path() / "slam.lcm", 3);
  results.commit();
  int events = 0;
  while (reader.next()) ++events;
  EXPECT_EQ(events, 100);
  EventLogReader now((out() / "slam.lcm").string());
  for (events = 0; now.next();) ++events;
  EXPECT_EQ(events, 3);
}

TEST_P(OutputFolderTest, OnlyOneProgramWritesThere) {
  run_command(out(), kFirst, seams());
  OutputFolder results(out(), "test", seams());
  EXPECT_THAT(complaint([&] { OutputFolder(out(), "test", seams()); }),
              HasSubstr("another program is writing"));
  write_results(results.path(), kSecond);
  results.commit();
  EXPECT_EQ(content(), kSecond);
}

TEST_P(OutputFolderTest, EveryNameOfAFolderIsTheFolder) {
  run_command(out(), kFirst, seams());
  fs::create_symlink("out", folder_.path() / "link");
  fs::permissions(out(), static_cast<fs::perms>(0750));
  const fs::path before = fs::current_path();
  fs::current_path(folder_.path());
  run_command("link", {{"a", "1"}}, seams());
  EXPECT_TRUE(fs::is_symlink("link"));
  EXPECT_EQ(content(), (Files{{"a", "1"}}));
  run_command("out/", {{"b", "2"}}, seams());
  run_command("./out/../out", {{"c", "3"}}, seams());
  EXPECT_EQ(content(), (Files{{"c", "3"}}));
  fs::current_path("out");
  run_command(".", {{"d", "4"}}, seams());
  EXPECT_EQ(fs::current_path(), fs::canonical(out()));  // a shell that stands there still does
  EXPECT_EQ(content_of("."), (Files{{"d", "4"}}));
  fs::current_path(before);
  EXPECT_EQ(fs::status(out()).permissions(), static_cast<fs::perms>(0750));
  run_command(folder_.path() / "new/deep/", {{"e", "5"}}, seams());
  EXPECT_EQ(content_of(folder_.path() / "new/deep"), (Files{{"e", "5"}}));
  expect_no_leftovers();
}

TEST_P(OutputFolderTest, AFolderOfSomebodysOwnIsNotTakenForUnfinishedWork) {
  run_command(out(), kFirst, seams());
  write_results(folder_.path() / "out.part", kOwn);
  run_command(out(), kSecond, seams());
  EXPECT_EQ(content(), kSecond);
  EXPECT_EQ(content_of(folder_.path() / "out.part"), kOwn);
  write_results(folder_.path() / "fresh.part", kOwn);
  EXPECT_THAT(complaint([&] { OutputFolder(folder_.path() / "fresh", "test"); }),
              HasSubstr("fresh.part: cannot be used"));
}

TEST_P(OutputFolderTest, AFileIsNoFolderAndAFolderNoFile) {
  folder_.write("file", "mine");
  EXPECT_THAT(complaint([&] { OutputFolder(folder_.path() / "file", "test", seams()); }),
              HasSubstr("is a file"));
  write_results(out(), {{"map.png/a", "mine"}});
  EXPECT_THAT(complaint([&] { run_command(out(), kSecond, seams()); }), HasSubstr("is a folder"));
  EXPECT_EQ(content(), (Files{{"map.png/a", "mine"}}));
}

TEST_P(OutputFolderTest, WhatSomebodyPutsInMeanwhileIsNotLost) {
  run_command(out(), kFirst, seams());
  FolderSeams late = seams();
  late.at_step = [&](const char* step) {
    if (std::string(step) == "exchange") write_whole_file(out() / "late.txt", "just now");
  };
  run_command(out(), kSecond, late);
  EXPECT_EQ(content(), both(kSecond, {{"late.txt", "just now"}}));
}

// A program that ends at step N of a commit, as after kill -9. @returns the step's name, "" when
// it came to its end.
std::string die_at_step(const fs::path& out, int step, FolderSeams seams) {
  const std::string told = out.parent_path() / "step";
  const pid_t child = fork();
  if (child == 0) {
    int left = step;
    seams.at_step = [&](const char* name) {
      if (left-- > 0) return;
      std::ofstream(told) << name;
      _exit(9);
    };
    run_command(out, kSecond, seams);
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WEXITSTATUS(status) == 9 ? read_whole_file(told) : "";
}

TEST(OutputFolder, KilledAtAnyStepTheFolderIsTheOldOneOrTheNewOne) {
  TemporaryFolder folder;
  const fs::path out = folder.path() / "out";
  const Files before = both(kFirst, kOwn), after = both(kSecond, kOwn);
  int steps = 0, old = 0;
  for (std::string name = "?"; !name.empty(); ++steps) {
    ASSERT_LT(steps, 50);
    fs::remove_all(out);
    run_command(out, kFirst);
    write_results(out, kOwn);
    name = die_at_step(out, steps, {});
    const Files found = content_of(out);
    EXPECT_TRUE(found == before || found == after) << "killed at: " << name;
    old += found == before ? 1 : 0;
    // Whoever writes next is not in the way of what was left, and leaves nothing of it.
    run_command(out, kFirst);
    EXPECT_EQ(content_of(out), before) << "killed at: " << name;
    EXPECT_FALSE(fs::exists(folder.path() / "out.part"));
    EXPECT_FALSE(fs::exists(out / kWorkMark));
  }
  EXPECT_GT(old, 1);
  EXPECT_GT(steps - old, 3);
}

// Without an exchange a kill may leave no folder, or results of both runs; but nothing of the
// user's is lost, each file is whole, and the next run of the command leaves what it would have.
TEST_P(OutputFolderTest, KilledAtAnyStepTheNextRunPutsItRight) {
  const Files all = both(both(kFirst, kOwn), kSecond);
  for (int step = 0;; ++step) {
    ASSERT_LT(step, 50);
    fs::remove_all(out());
    run_command(out(), kFirst);
    write_results(out(), kOwn);
    const std::string name = die_at_step(out(), step, seams());
    if (name.empty()) break;
    const fs::path left = fs::exists(out()) ? out() : folder_.path() / "out.part.old";
    const Files found = content_of(left);
    for (const auto& [file, text] : kOwn) EXPECT_EQ(found.at(file), text) << "killed at: " << name;
    for (const auto& [file, text] : found) {
      EXPECT_TRUE(text == all.at(file) || text == kSecond.at(file)) << "killed at: " << name;
    }
    run_command(out(), kSecond, seams());
    EXPECT_EQ(content(), both(kSecond, kOwn)) << "killed at: " << name;
    expect_no_leftovers();
  }
}

INSTANTIATE_TEST_SUITE_P(Ways,
                         OutputFolderTest,
                         ::testing::Values(Way::exchange, Way::renames, Way::moves),
                         [](const auto& way) {
                           if (way.param == Way::exchange) return "Exchange";
                           return way.param == Way::renames ? "Renames" : "Moves";
                         });

}  // namespace
}  // namespace marco::files
