#include "lcm_tools/files/output_file.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>
#include <thread>

#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/tests/support/temporary_folder.hpp"

namespace marco::files {
namespace {

namespace fs = std::filesystem;
using ::marco::testing::complaint;
using ::marco::testing::TemporaryFolder;
using ::testing::HasSubstr;

class OutputFileTest : public ::testing::Test {
 protected:
  fs::path at(const char* name) const { return folder_.path() / name; }
  TemporaryFolder folder_;
};

TEST_F(OutputFileTest, APlantedLinkIsNotWrittenThrough) {
  folder_.write("precious", "good");
  fs::create_symlink("precious", at("map.pgm.part"));
  write_whole_file(at("map.pgm"), "picture");
  EXPECT_EQ(read_whole_file(at("precious")), "good");
  EXPECT_EQ(read_whole_file(at("map.pgm")), "picture");
  EXPECT_FALSE(fs::is_symlink(at("map.pgm")));
  EXPECT_TRUE(fs::is_symlink(at("map.pgm.part")));
}

TEST_F(OutputFileTest, ALinksTargetIsReplacedAndKeepsItsPermissions) {
  fs::create_directory(at("sub"));
  folder_.write("sub/target", "old");
  fs::permissions(at("sub/target"), static_cast<fs::perms>(0640));
  fs::create_symlink("sub/target", at("link"));
  fs::create_symlink("sub/later", at("dangling"));
  write_whole_file(at("link"), "new");
  write_whole_file(at("dangling"), "made");
  EXPECT_TRUE(fs::is_symlink(at("link")));
  EXPECT_EQ(read_whole_file(at("sub/target")), "new");
  EXPECT_EQ(fs::status(at("sub/target")).permissions(), static_cast<fs::perms>(0640));
  EXPECT_TRUE(fs::is_symlink(at("dangling")));
  EXPECT_EQ(read_whole_file(at("sub/later")), "made");
  fs::create_symlink("circle", at("circle"));
  EXPECT_THAT(complaint([&] { write_whole_file(at("circle"), "x"); }), HasSubstr("circle"));
}

TEST_F(OutputFileTest, WhatIsNoFileIsWrittenIntoAndNeverReplaced) {
  ASSERT_EQ(mkfifo(at("pipe").c_str(), 0600), 0);
  std::string got;
  std::thread reader([&] {
    std::ifstream pipe(at("pipe"));
    std::getline(pipe, got);
  });
  write_whole_file(at("pipe"), "through");
  reader.join();
  EXPECT_EQ(got, "through");
  EXPECT_TRUE(fs::is_fifo(at("pipe")));
  fs::create_symlink("/dev/null", at("null"));
  write_whole_file(at("null"), "gone");
  EXPECT_TRUE(fs::is_symlink(at("null")));
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
  EXPECT_THAT(complaint([] { write_whole_file("/dev/full", "x"); }), HasSubstr("/dev/full"));
  EXPECT_THAT(complaint([&] { write_whole_file(folder_.path(), "x"); }), HasSubstr("is a folder"));
}

TEST_F(OutputFileTest, UntilItIsFinishedTheOldFileStands) {
  folder_.write("out", "old");
  {
    OutputFile file(at("out"));
    file.write("half");
    file.flush();
    EXPECT_EQ(read_whole_file(at("out")), "old");
  }
  EXPECT_EQ(read_whole_file(at("out")), "old");
  EXPECT_FALSE(fs::exists(at("out.part")));
}

TEST_F(OutputFileTest, TwoWritersOfOneFileDoNotMixAndALeftOverGoes) {
  folder_.write("out.part", "of a program that was killed");
  OutputFile one(at("out"));
  OutputFile two(at("out"));
  EXPECT_EQ(one.unfinished_path(), fs::canonical(folder_.path()) / "out.part");
  EXPECT_NE(two.unfinished_path(), one.unfinished_path());
  one.write("one");
  two.write("two");
  two.finish();
  EXPECT_EQ(read_whole_file(at("out")), "two");
  one.finish();
  EXPECT_EQ(read_whole_file(at("out")), "one");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_.path()), fs::directory_iterator()), 1);
}

TEST_F(OutputFileTest, ARecordingStandsUnderItsNameFromTheFirstByte) {
  OutputFile file(at("log"), Appears::at_once);
  file.write("event");
  file.flush();
  EXPECT_EQ(read_whole_file(at("log")), "event");
}

}  // namespace
}  // namespace marco::files
