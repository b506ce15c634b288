// Bags that hold nothing to map, or nothing that can be read.
#include <gmock/gmock.h>

#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "recordings/recording.hpp"
#include "recordings/ros/bag_writer.hpp"
#include "recordings/ros/encode_messages.hpp"
#include "recordings/ros/open_messages.hpp"
#include "tests/support/recorded.hpp"

namespace marco::ros {
namespace {

using ::marco::testing::TemporaryFolder;
using ::testing::Contains;
using ::testing::HasSubstr;

// @param topics  types by name, ten messages each
void write_bag(const std::filesystem::path& path,
               const std::map<std::string, std::string>& topics) {
  files::OutputFile out(path);
  BagWriter bag(out);
  for (const auto& [name, type] : topics) {
    Topic topic;
    topic.name = name;
    topic.type = type;
    const uint32_t number = bag.add_topic(topic);
    for (int64_t i = 1; i <= 10; ++i) {
      const int64_t at_ns = 100'000'000 * i;
      LaserScanMessage scan;
      scan.header = {at_ns, "laser"};
      scan.angle_increment = 0.1F;
      scan.ranges.assign(30, 2.0F);
      const std::vector<TransformMessage> transforms{{{at_ns, "a"}, "b", Pose3::Identity()}};
      const bool is_scan = type == "sensor_msgs/LaserScan";
      bag.write(number, at_ns, at_ns, is_scan ? encode("ros1", scan) : encode("ros1", transforms));
    }
  }
  bag.finish();
  out.finish();
}

TEST(OddBags, WithoutALaserSayWhatIsInThem) {
  const TemporaryFolder folder;
  const auto says = [&](const std::map<std::string, std::string>& topics, const char* what) {
    write_bag(folder.path() / "a.bag", topics);
    EXPECT_THAT([&] { open_recording(folder.path() / "a.bag"); },
                ::testing::ThrowsMessage<std::invalid_argument>(HasSubstr(what)));
  };
  says({}, "no laser: it holds no messages");
  says({{"/tf", "tf2_msgs/TFMessage"}}, "no laser: it holds /tf (tf2_msgs/TFMessage)");
}

TEST(OddBags, OfACompressionThatIsNotKnownSayItsName) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "a.bag";
  write_bag(path, {{"/scan", "sensor_msgs/LaserScan"}});
  std::string content = files::read_whole_file(path);
  const std::string told = "compression=lz4";
  content.replace(content.find(told), told.size(), "compression=xz5");
  files::write_whole_file(path, content);
  const auto source = open_messages(path);
  EXPECT_FALSE(source->next().has_value());
  EXPECT_EQ(source->damage().places, 1);
  EXPECT_THAT(source->notes(), Contains(HasSubstr("compression 'xz5' is not known")));
  // What is wrong is said where nothing is left, too.
  EXPECT_THAT([&] { open_recording(path); },
              ::testing::ThrowsMessage<std::invalid_argument>(HasSubstr("'xz5' is not known")));
}

}  // namespace
}  // namespace marco::ros
