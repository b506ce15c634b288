#include "recordings/ros/temporary_file.hpp"

#include <gmock/gmock.h>

#include <cstdlib>
#include <stdexcept>
#include <vector>

#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "recordings/ros/byte_file.hpp"

namespace marco::ros {
namespace {

using ::marco::testing::TemporaryFolder;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

class Temporary : public ::testing::Test {
 protected:
  Temporary() { ::setenv("TMPDIR", folder_.path().c_str(), 1); }
  ~Temporary() override { ::unsetenv("TMPDIR"); }

  TemporaryFolder folder_;
  std::vector<uint8_t> some_ = std::vector<uint8_t>(3'000'000, 7);
};

TEST_F(Temporary, HasNoNameThatCouldBeLeftBehind) {
  TemporaryFile file("to try");
  file.append(some_);
  file.append(some_);
  EXPECT_TRUE(std::filesystem::is_empty(folder_.path()));
  const ByteFile read(file.path());
  EXPECT_EQ(read.size(), 6'000'000);
  EXPECT_TRUE(read.bytes(3'000'000, 3'000'000) == some_);
}

TEST_F(Temporary, LeavesSpaceOnTheDiskToOthers) {
  TemporaryFile file("to try", uint64_t{1} << 62U);
  EXPECT_THAT([&] { file.append(some_); },
              ThrowsMessage<std::runtime_error>(
                  AllOf(HasSubstr(folder_.path().string()),
                        HasSubstr("to try: there is too little space"), HasSubstr("TMPDIR"))));
}

TEST_F(Temporary, SaysWhichFolderIsNone) {
  ::setenv("TMPDIR", (folder_.path() / "none").c_str(), 1);
  EXPECT_THAT([] { TemporaryFile("to try"); },
              ThrowsMessage<std::runtime_error>(HasSubstr((folder_.path() / "none").string())));
}

}  // namespace
}  // namespace marco::ros
