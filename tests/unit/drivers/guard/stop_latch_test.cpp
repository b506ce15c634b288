#include "drivers/base/stop_latch.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

namespace marco::drivers {
namespace {

class StopOnDisk : public ::testing::Test {
 protected:
  StopOnDisk() {
    std::string pattern = (std::filesystem::temp_directory_path() / "latchXXXXXX").string();
    folder_ = mkdtemp(pattern.data());
    setenv("XDG_STATE_HOME", folder_.c_str(), 1);
  }
  ~StopOnDisk() override {
    unsetenv("XDG_STATE_HOME");
    std::filesystem::remove_all(folder_);
  }
  std::filesystem::path folder_;
};

TEST_F(StopOnDisk, OutlivesTheDriverUntilItIsReleased) {
  const StopLatch latch("kobuki", "");
  EXPECT_FALSE(latch.load());
  latch.save(EmergencyStop{Utime::from_us(1234567), true, "she\nriff", "a child\nand a dog"});
  const auto stop = StopLatch("kobuki", "udpm://239.255.76.67:7667?ttl=1").load();
  ASSERT_TRUE(stop);
  EXPECT_EQ(stop->utime.us, 1234567);
  EXPECT_TRUE(stop->engaged);
  EXPECT_EQ(stop->sender, "she riff");
  EXPECT_EQ(stop->reason, "a child and a dog");
  latch.save(std::nullopt);
  EXPECT_FALSE(latch.load());
}

TEST_F(StopOnDisk, IsOfOneBaseAndNetwork) {
  StopLatch("kobuki", "").save(EmergencyStop{Utime::from_us(1), true, "sheriff", ""});
  EXPECT_FALSE(StopLatch("create", "").load());
  EXPECT_FALSE(StopLatch("kobuki", "udpm://239.255.76.67:7668").load());
}

TEST_F(StopOnDisk, AFileThatCannotBeReadIsAStop) {
  const StopLatch latch("kobuki", "");
  latch.save(EmergencyStop{Utime::from_us(1), true, "sheriff", "a child"});
  for (const auto& file : std::filesystem::recursive_directory_iterator(folder_)) {
    if (file.is_regular_file()) std::ofstream(file.path(), std::ios::trunc);
  }
  ASSERT_TRUE(latch.load());
  EXPECT_EQ(latch.load()->sender, "somebody");
}

}  // namespace
}  // namespace marco::drivers
