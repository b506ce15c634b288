#include "recordings/ros/split_recordings.hpp"

#include <gmock/gmock.h>

#include <string>

#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "recordings/recording.hpp"
#include "recordings/recording_folder.hpp"
#include "recordings/ros/bag_writer.hpp"
#include "recordings/ros/open_messages.hpp"

namespace marco::ros {
namespace {

namespace fs = std::filesystem;
using ::marco::testing::complaint;
using ::marco::testing::TemporaryFolder;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

using Names = std::vector<std::vector<std::string>>;

class FolderOfBags : public ::testing::Test {
 protected:
  // A message each 100 ms, on topics of one type.
  void write(const std::string& name,
             double from_s,
             double to_s,
             const std::vector<std::string>& topics = {"/scan", "/odom", "/tf"},
             const std::string& type = "std_msgs/String") {
    fs::create_directories((folder_.path() / name).parent_path());
    files::OutputFile out(folder_.path() / name);
    BagWriter bag(out);
    for (const std::string& name_of_topic : topics) {
      Topic topic;
      topic.name = name_of_topic;
      topic.type = type;
      topic.encoding = "ros1";
      topic.md5 = "992ce8a1687cec8c8bd883ec73ca41d1";
      topic.schema = "string data\n";
      const uint32_t id = bag.add_topic(topic);
      for (double at_s = from_s; at_s < to_s + 0.01; at_s += 0.1) {
        const auto time_ns = static_cast<int64_t>(at_s * 1e9);
        bag.write(id, time_ns, time_ns, std::vector<uint8_t>{1, 0, 0, 0, 'x'});
      }
    }
    bag.finish();
    out.finish();
  }
  static Names names(const std::vector<RecordingParts>& recordings) {
    Names names;
    for (const RecordingParts& parts : recordings) {
      names.emplace_back();
      for (const fs::path& part : parts) names.back().push_back(part.filename().string());
    }
    return names;
  }
  Names found() const { return names(ros::recordings_in(folder_.path())); }

  TemporaryFolder folder_;
};

TEST_F(FolderOfBags, PartsOfASplitRecordingAreOneInTheOrderOfTheirNumbers) {
  write("run_10.bag", 30.1, 40.0);
  write("run_8.bag", 10.0, 20.0);
  write("run_9.bag", 20.1, 30.0, {"/scan", "/odom"});  // no message on /tf came
  EXPECT_EQ(found(), (Names{{"run_8.bag", "run_9.bag", "run_10.bag"}}));
  const auto source = open_messages(folder_.path());
  int64_t last_ns = 0;
  for (auto message = source->next(); message; message = source->next()) {
    EXPECT_GE(message->received_ns, last_ns);
    last_ns = message->received_ns;
  }
  EXPECT_EQ(source->paths().size(), 3U);
  EXPECT_GT(last_ns, 39'900'000'000);
}

TEST_F(FolderOfBags, TheRecordersDateAndAnOpenLastPartDoNotPartThem) {
  write("run_2020-01-31-12-00-00_0.bag", 10.0, 20.0);
  write("run_2020-01-31-12-00-10_1.bag", 20.1, 30.0);
  write("run_2020-01-31-12-00-20_2.bag.active", 30.1, 40.0);
  EXPECT_EQ(found().size(), 1U);
}

TEST_F(FolderOfBags, BagsOfOtherNamesTopicsTypesOrTimesAreRecordingsOfTheirOwn) {
  write("a_0.bag", 10.0, 20.0);
  write("b_1.bag", 20.1, 30.0);  // another name
  write("c.bag", 20.1, 30.0);
  write("topics_0.bag", 10.0, 20.0);
  write("topics_1.bag", 20.1, 30.0, {"/front/scan", "/wheels", "/tf"});
  write("types_0.bag", 10.0, 20.0);
  write("types_1.bag", 20.1, 30.0, {"/scan", "/odom", "/tf"}, "std_msgs/Other");
  write("pause_0.bag", 10.0, 20.0);
  write("pause_1.bag", 40.0, 50.0);
  write("overlap_0.bag", 10.0, 20.0);
  write("overlap_1.bag", 15.0, 25.0);
  write("before_0.bag", 20.1, 30.0);
  write("before_1.bag", 10.0, 20.0);
  folder_.write("broken_0.bag", "#ROSBAG V2.0\n");
  folder_.write("broken_1.bag", "#ROSBAG V2.0\n");
  for (const std::vector<std::string>& parts : found()) {
    EXPECT_EQ(parts.size(), 1U) << parts.front();
  }
  EXPECT_EQ(found().size(), 15U);
}

TEST_F(FolderOfBags, ADatedNameHasNoNumber) {
  write("2020-01-31-12-00-01.bag", 10.0, 20.0);
  write("2020-01-31-12-00-12.bag", 21.0, 30.0);
  EXPECT_EQ(found().size(), 2U);
}

TEST_F(FolderOfBags, WhatMetadataNamesIsOneInItsOrderAndAllThatCounts) {
  write("late.bag", 10.0, 20.0);
  write("early.bag", 90.0, 95.0);
  write("copy_of_late.bag", 10.0, 20.0);
  folder_.write("metadata.yaml",
                "rosbag2_bagfile_information:\n  relative_file_paths:\n"
                "    - where/it/stood/early.bag\n    - \"late.bag\"\n    - gone.bag\n"
                "  duration:\n    - copy_of_late.bag\n");
  EXPECT_EQ(found(), (Names{{"early.bag", "late.bag"}}));
  const std::vector<fs::path> all = {folder_.path() / "late.bag",
                                     folder_.path() / "copy_of_late.bag",
                                     folder_.path() / "early.bag"};
  EXPECT_EQ(names(ros::recordings_of(all)),
            (Names{{"early.bag", "late.bag"}, {"copy_of_late.bag"}}));
}

TEST_F(FolderOfBags, InputsAreJoinedAndKeepTheirOrder) {
  write("z.bag", 10.0, 20.0);
  write("run_0.bag", 10.0, 20.0);
  write("run_1.bag", 20.1, 30.0);
  std::vector<fs::path> inputs;
  for (const char* name : {"z.bag", "run_1.bag", "run_0.bag"}) {
    inputs.push_back(folder_.path() / name);
  }
  EXPECT_EQ(names(marco::recordings_of(inputs)), (Names{{"z.bag"}, {"run_0.bag", "run_1.bag"}}));
}

TEST_F(FolderOfBags, OfDifferentRecordingsIsRefusedAndSaysWhatToDo) {
  write("a.bag", 10.0, 20.0);
  write("b.bag", 10.0, 20.0);
  const auto says = AllOf(HasSubstr("2 different recordings (a.bag, b.bag)"),
                          HasSubstr("map --many " + folder_.path().string()));
  EXPECT_THAT(complaint([&] { open_messages(folder_.path()); }), says);
  EXPECT_THAT(complaint([&] { open_recording(folder_.path()); }), says);
}

TEST_F(FolderOfBags, WithFoldersOfOthersHoldsSeveral) {
  write("a.bag", 10.0, 20.0);
  write("ros2/x_0.bag", 10.0, 20.0);
  write("ros2/x_1.bag", 20.1, 30.0);
  EXPECT_EQ(names(marco::recordings_in(folder_.path())), (Names{{"a.bag"}, {"ros2"}}));
  EXPECT_THAT(complaint([&] { open_recording(folder_.path()); }),
              HasSubstr("2 different recordings (a.bag, ros2)"));
  fs::remove(folder_.path() / "a.bag");
  fs::create_directory_symlink(folder_.path(), folder_.path() / "link");  // to itself
  EXPECT_EQ(names(marco::recordings_in(folder_.path())), (Names{{"ros2"}}));
}

}  // namespace
}  // namespace marco::ros
