#include "lcm_tools/files/inside_folder.hpp"

#include <gmock/gmock.h>
#include <sys/stat.h>

#include "lcm_tools/tests/support/temporary_folder.hpp"

namespace marco::files {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

/// A folder as a stranger packs it, beside what is none of theirs.
class StrangersFolder : public ::testing::Test {
 protected:
  StrangersFolder() {
    fs::create_directories(map_ / "sub");
    fs::create_directories(top_.path() / "home");
    top_.write("home/key", "secret");
    top_.write("map/sub/a.tum", "1");
  }
  std::string refused(const fs::path& name) const {
    try {
      return "not refused: " + inside_folder(map_, name).string();
    } catch (const std::invalid_argument& why) {
      return why.what();
    }
  }
  ::marco::testing::TemporaryFolder top_;
  fs::path map_ = top_.path() / "map";
};

TEST_F(StrangersFolder, FilesAndLinksWithinItAreRead) {
  fs::create_symlink("sub/a.tum", map_ / "link.tum");
  fs::create_directory_symlink("sub", map_ / "other");
  const fs::path whole = fs::canonical(map_ / "sub/a.tum");
  for (const char* name : {"sub/a.tum", "link.tum", "other/a.tum", "sub/../link.tum"}) {
    EXPECT_EQ(inside_folder(map_, name), whole) << name;
  }
  EXPECT_EQ(inside_folder(map_, "gone"), map_ / "gone");
  fs::create_directory_symlink(map_, top_.path() / "mine");  // the user's own
  EXPECT_EQ(inside_folder(top_.path() / "mine", "link.tum"), whole);
}

TEST_F(StrangersFolder, NoLinkLeadsOut) {
  fs::create_symlink("../home/key", map_ / "relative");
  fs::create_symlink(fs::absolute(top_.path() / "home/key"), map_ / "absolute");
  fs::create_directory_symlink("../home", map_ / "folder");
  fs::create_symlink("folder/key", map_ / "second");
  fs::create_symlink("/dev/zero", map_ / "device");
  for (const char* name : {"relative", "absolute", "folder/key", "second", "device", "folder"}) {
    EXPECT_THAT(refused(name), HasSubstr("is a link that points outside its folder")) << name;
  }
  for (const char* name : {"../home/key", "/etc/passwd", "sub/../../home/key"}) {
    EXPECT_THAT(refused(name), HasSubstr("is outside its folder")) << name;
  }
  // A folder whose name begins alike is another one.
  fs::create_directories(top_.path() / "map2");
  top_.write("map2/key", "secret");
  fs::create_symlink("../map2/key", map_ / "alike");
  EXPECT_THAT(refused("alike"), HasSubstr("points outside"));
}

TEST_F(StrangersFolder, WhatIsNoFileIsNotWaitedFor) {
  ASSERT_EQ(mkfifo((map_ / "pipe").c_str(), 0600), 0);
  fs::create_symlink("pipe", map_ / "link");
  fs::create_symlink("loop", map_ / "loop");
  EXPECT_THAT(refused("pipe"), HasSubstr("is not a file"));
  EXPECT_THAT(refused("link"), HasSubstr("is not a file"));
  EXPECT_EQ(inside_folder(map_, "loop"), map_ / "loop");  // cannot be opened
}

}  // namespace
}  // namespace marco::files
