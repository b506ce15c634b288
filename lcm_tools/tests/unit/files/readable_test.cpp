#include "lcm_tools/files/readable.hpp"

#include <gmock/gmock.h>
#include <sys/stat.h>

#include "lcm_tools/files/event_log.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/tests/support/temporary_folder.hpp"

namespace marco::files {
namespace {

using ::marco::testing::complaint;
using ::marco::testing::TemporaryFolder;
using ::testing::HasSubstr;

// Who opens a pipe waits for its writer, and who reads a device may never end.
TEST(Readable, RefusesWhatIsNoFileAtOnce) {
  const TemporaryFolder folder;
  const std::string pipe = folder.path() / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  std::filesystem::create_symlink(pipe, folder.path() / "link");
  for (const std::string& path : {pipe, (folder.path() / "link").string()}) {
    EXPECT_EQ(why_not_readable(path), "it is a pipe, not a file");
    EXPECT_THAT(complaint([&] { open_readable(path); }), HasSubstr("it is a pipe"));
    EXPECT_THAT(complaint([&] { read_whole_file(path); }), HasSubstr("it is a pipe"));
    EXPECT_THAT(complaint([&] { EventLogReader log(path); }), HasSubstr("it is a pipe"));
    EXPECT_EQ(first_bytes(path, 10), "");
  }
  EXPECT_EQ(why_not_readable("/dev/zero"), "it is a device, not a file");
  EXPECT_EQ(why_not_readable(folder.path()), "");
  EXPECT_EQ(first_bytes(folder.path(), 10), "");
}

TEST(Readable, GivesTheFirstBytesAndWholeFilesUpToASize) {
  const TemporaryFolder folder;
  const auto path = folder.write("a", std::string(2 << 20, 'a'));
  EXPECT_EQ(first_bytes(path, 3), "aaa");
  EXPECT_EQ(first_bytes(folder.write("b", "b"), 3), "b");
  EXPECT_EQ(read_whole_file(path, 2 << 20).size(), std::size_t{2} << 20U);
  EXPECT_THAT(complaint([&] { read_whole_file(path, 1 << 20); }), HasSubstr("larger than 1 MB"));
}

}  // namespace
}  // namespace marco::files
