// SLAM killed at 20 random moments of a real log, each time going on from its checkpoint's bytes.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <random>

#include "lcm_tools/process/batch_bus.hpp"
#include "lcmtypes/convert.hpp"
#include "recordings/recording.hpp"
#include "slam/process/slam_adapter.hpp"
#include "tests/support/real_data.hpp"

namespace marco::slam {
namespace {

struct Life {
  process::BatchBus bus;
  SlamAdapter slam;
  explicit Life(const SlamAdapterOptions& options) : slam(bus, options) {}
};

SlamAdapterOptions options() {
  SlamAdapterOptions options;
  options.map_period_s = 0.0;
  // Thins while it is killed, too.
  options.slam.culling.after_keyframes = 300;
  return options;
}

Trajectory path_of(const std::vector<EncodedMessage>& messages, std::vector<std::size_t> deaths) {
  auto life = std::make_unique<Life>(options());
  for (std::size_t i = 0; i < messages.size(); ++i) {
    if (!deaths.empty() && deaths.back() == i) {
      const std::string checkpoint = encode_adapter_state(life->slam.state());
      life = std::make_unique<Life>(options());
      life->slam.restore(decode_adapter_state(checkpoint));
      deaths.pop_back();
    }
    life->bus.deliver(messages[i].channel, messages[i].bytes, messages[i].utime);
  }
  life->slam.finish();
  return life->slam.slam().trajectory();
}

TEST(ResumedInIntel, KilledAtTwentyRandomMomentsItEndsWithTheSamePath) {
  const char* folder = marco::testing::real_data();
  if (folder == nullptr) return;
  std::vector<EncodedMessage> messages;
  const auto recording = open_recording(std::string(folder) + "/intel/intel.log");
  while (const auto sample = recording->next()) messages.push_back(encode_sample(*sample));
  std::mt19937 random(20);
  std::uniform_int_distribution<std::size_t> any(1, messages.size() - 1);
  std::vector<std::size_t> deaths(20);
  for (std::size_t& death : deaths) death = any(random);
  std::sort(deaths.rbegin(), deaths.rend());
  deaths.erase(std::unique(deaths.begin(), deaths.end()), deaths.end());
  ASSERT_EQ(deaths.size(), 20U);
  const Trajectory whole = path_of(messages, {}), resumed = path_of(messages, deaths);
  ASSERT_EQ(whole.size(), resumed.size());
  double worst_m = 0.0;
  for (std::size_t i = 0; i < whole.size(); ++i) {
    worst_m = std::max(
        worst_m,
        between(whole[i].world_from_robot, resumed[i].world_from_robot).translation_m().norm());
  }
  std::printf("killed 20 times: the path is off by %.2g m at most\n", worst_m);
  EXPECT_LE(worst_m, 0.001);
}

}  // namespace
}  // namespace marco::slam
