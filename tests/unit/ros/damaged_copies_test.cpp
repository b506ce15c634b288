// Copies of other people's recordings, cut off at random or with bits flipped: what is whole is
// used, the rest is told.
#include <gmock/gmock.h>

#include <cstdlib>
#include <filesystem>
#include <random>

#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "recordings/recording.hpp"
#include "tests/support/real_data.hpp"
#include "tests/support/recorded.hpp"

namespace marco {
namespace {

using ::marco::testing::read_all;
using ::marco::testing::Recorded;
using ::marco::testing::TemporaryFolder;

struct Whole {
  const char* name;
  double slack;  // the part of a file that one chunk or page takes, and what tells of others
};
constexpr Whole kRecordings[] = {
    {"rosbags/guardian_3.bag", 0.3},
    {"rosbags/guardian_controller_2.bag", 0.25},
    {"rosbags/ship_interior_with_tilting_laser.bag", 0.25},
    {"rosbags/macfirst_floor_take_2/macfirst_floor_take_2_0.db3", 0.1},
    {"rosbags/macfirst_floor_take_2_mcap/macfirst_floor_take_2_lz4.mcap", 0.2},
    {"rosbags/kitchen_1/my_data_bag_0.db3", 0.1},
    {"mbot/mbot_convex.lcmlog", 0.05},
    {"mbot/maebot_convex.lcmlog", 0.05},
};

// The long test tries more.
int seeds() {
  const char* told = std::getenv("MARCO_DAMAGES");
  return told == nullptr ? 1 : std::atoi(told);
}

class DamagedCopies : public ::testing::TestWithParam<Whole> {
 protected:
  void SetUp() override {
    const char* folder = marco::testing::real_data();
    if (folder == nullptr) GTEST_SKIP();
    content_ = files::read_whole_file(std::string(folder) + "/" + GetParam().name);
  }
  std::size_t scans_in(const std::string& content) {
    files::write_whole_file(copy_, content);
    damage_is_told_ = false;
    try {
      const Recorded recorded = read_all(*open_recording(copy_));
      damage_is_told_ = !recorded.report.dropped.empty();
      for (const std::string& note : recorded.report.notes) {
        damage_is_told_ = damage_is_told_ || note.find("damage") != std::string::npos ||
                          note.find("no index") != std::string::npos ||
                          note.find("checksum") != std::string::npos;
      }
      return recorded.scans.size();
    } catch (const std::invalid_argument&) {  // says what is wrong
      damage_is_told_ = true;
      return 0;
    }
  }

  TemporaryFolder folder_;
  std::filesystem::path copy_ = folder_.path() / "copy";
  std::string content_;
  bool damage_is_told_ = false;
};

INSTANTIATE_TEST_SUITE_P(Recordings, DamagedCopies, ::testing::ValuesIn(kRecordings));

TEST_P(DamagedCopies, ThatAreCutOffGiveWhatIsWhole) {
  const std::size_t whole = scans_in(content_);
  for (int seed = 1; seed <= seeds(); ++seed) {
    std::mt19937 random(static_cast<unsigned>(seed));
    const auto size = std::uniform_int_distribution<std::size_t>(content_.size() / 10,
                                                                 content_.size() - 1)(random);
    const std::size_t found = scans_in(content_.substr(0, size));
    const double part = static_cast<double>(size) / static_cast<double>(content_.size());
    EXPECT_LE(found, whole) << size;
    EXPECT_GE(static_cast<double>(found), (part - GetParam().slack) * static_cast<double>(whole))
        << size;
    EXPECT_TRUE(damage_is_told_) << size;
  }
}

TEST_P(DamagedCopies, WithBitsThatFlippedGiveTheRest) {
  const std::size_t whole = scans_in(content_);
  for (int seed = 1; seed <= seeds(); ++seed) {
    std::mt19937 random(static_cast<unsigned>(1000 + seed));
    std::string flipped = content_;
    std::uniform_int_distribution<std::size_t> byte(content_.size() / 10, content_.size() - 1);
    for (int i = 0; i < 2; ++i) flipped[byte(random)] ^= static_cast<char>(1 << (random() % 8));
    const std::size_t found = scans_in(flipped);
    EXPECT_LE(found, whole);
    EXPECT_GE(static_cast<double>(found),
              (1.0 - 2.0 * GetParam().slack) * static_cast<double>(whole))
        << seed;
  }
}

}  // namespace
}  // namespace marco
