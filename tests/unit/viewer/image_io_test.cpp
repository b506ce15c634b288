#include "viewer/image_io.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tests/support/temporary_folder.hpp"

namespace marco::viewer {
namespace {

using ::testing::HasSubstr;

TEST(ImageIo, ReadsBackWhatItWrote) {
  Picture picture(3, 2, {10, 20, 30});
  picture.at(0, 0) = {255, 0, 0};
  picture.at(2, 1) = {0, 0, 255};
  const std::string path = marco::testing::temporary_path("round.png");
  write_png(picture, path);
  const Picture back = read_picture(path);
  EXPECT_EQ(back.width_px, 3);
  EXPECT_EQ(back.height_px, 2);
  EXPECT_EQ(back.pixels, picture.pixels);
  EXPECT_FALSE(std::filesystem::exists(path + ".part"));
  std::filesystem::remove(path);
}

TEST(ImageIo, SaysWhichFileCouldNotBeWrittenOrRead) {
  const Picture picture(3, 2, {});
  const std::string nowhere = marco::testing::temporary_path("no/such/folder.png");
  try {
    write_png(picture, nowhere);
    FAIL() << "a picture was written into a folder that is not there";
  } catch (const std::runtime_error& failure) {
    EXPECT_THAT(failure.what(), HasSubstr(nowhere));
  }
  EXPECT_THROW(write_png({}, nowhere), std::invalid_argument);
  EXPECT_THROW(read_picture(nowhere), std::runtime_error);
  const std::string text = marco::testing::temporary_path("text.png");
  std::ofstream(text) << "not a picture";
  EXPECT_THROW(read_picture(text), std::runtime_error);
  std::filesystem::remove(text);
}

TEST(ImageIo, SaysThatTheDiskIsFullAndLeavesNoPart) {
  const std::string path = marco::testing::temporary_path("full.png");
  std::error_code error;
  std::filesystem::create_symlink("/dev/full", path + ".part", error);
  if (error || !std::filesystem::exists("/dev/full")) {
    std::puts("SKIPPED: no /dev/full here");
    return;
  }
  try {
    write_png(Picture(300, 200, {1, 2, 3}), path);
    FAIL() << "a full disk went unnoticed";
  } catch (const std::runtime_error& failure) {
    EXPECT_THAT(failure.what(), HasSubstr("No space left"));
  }
  EXPECT_FALSE(std::filesystem::exists(path));
  EXPECT_FALSE(std::filesystem::is_symlink(path + ".part"));
}

}  // namespace
}  // namespace marco::viewer
