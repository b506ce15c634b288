// The seeds from which the readers of saved maps and checkpoints are fuzzed lie behind the
// checksum: whenever that layout changes they are of no use until they are written anew. With
// MARCO_WRITE_SEEDS=1 this test does so.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>

#include "common/byte_archive.hpp"
#include "lcm_tools/process/batch_bus.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "slam/process/checkpoint.hpp"
#include "slam/process/slam_adapter.hpp"

namespace marco::slam {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kEnvelopeBytes = 8 + sizeof(uint32_t) + sizeof(uint64_t);

std::string payload_of(const std::string& sealed) {
  return sealed.substr(kEnvelopeBytes, sealed.size() - kEnvelopeBytes - sizeof(uint32_t));
}

/// Five scans of a room, half a metre apart: keyframes (cut, so that the seed is short), edges, a
/// path.
AdapterState five_scans() {
  constexpr int kBeams = 24, kPointsKept = 1;
  process::BatchBus bus;
  SlamAdapter adapter(bus, {});
  SensorInfo info;
  info.channel = channels::kLidar;
  info.range_max_m = 30.0;
  bus.deliver(channels::kSensorInfo, encode_message(to_message(info)), Utime::from_us(1));
  for (int i = 0; i < 5; ++i) {
    const Utime utime = Utime::from_us(1'000'000 * (i + 1));
    const double x_m = 0.5 * i;
    bus.deliver(channels::kOdometry, encode_message(to_message(OdometrySample{utime, {x_m, 0, 0}})),
                utime);
    LaserScan scan;
    scan.utime = utime;
    scan.channel = channels::kLidar;
    scan.first_bearing_rad = -M_PI / 2;
    scan.bearing_step_rad = M_PI / (kBeams - 1);
    for (int beam = 0; beam < kBeams; ++beam) {
      const double bearing = scan.first_bearing_rad + beam * scan.bearing_step_rad;
      const double to_front_m = (6.0 - x_m) / std::max(1e-9, std::cos(bearing));
      const double to_side_m = 2.0 / std::max(1e-9, std::abs(std::sin(bearing)));
      scan.ranges_m.push_back(static_cast<float>(std::min(to_front_m, to_side_m)));
    }
    const EncodedMessage message = encode_sample(scan);
    bus.deliver(message.channel, message.bytes, utime);
  }
  AdapterState state = adapter.state();
  for (Keyframe& key : state.map.slam.keyframes.keys) {
    key.points_in_robot.points.conservativeResize(2, kPointsKept);
    key.points_in_robot.normals.conservativeResize(2, kPointsKept);
  }
  return state;
}

std::string read(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

/// @param decode  a payload; throws where it cannot be read
void expect_read(const fs::path& path,
                 const std::string& payload_today,
                 const std::function<void(const std::string&)>& decode) {
  if (std::getenv("MARCO_WRITE_SEEDS") != nullptr) {
    std::ofstream(path, std::ios::binary) << payload_today;
  }
  EXPECT_NO_THROW(decode(read(path))) << path << ": MARCO_WRITE_SEEDS=1 writes it anew";
}

uint32_t version_of(const std::string& sealed) {
  uint32_t version = 0;
  sealed.copy(reinterpret_cast<char*>(&version), sizeof(version), 8);
  return version;
}

TEST(Seeds, OfSavedMapsAndCheckpointsAreOfTodaysLayout) {
  const fs::path corpus = "tests/fuzz/corpus";
  const AdapterState five = five_scans();
  ASSERT_GE(five.map.slam.keyframes.keys.size(), 3U);
  ASSERT_GE(five.map.slam.back_end.edges.size(), 2U);
  for (const auto& [name, map] :
       {std::pair{"none", SavedMap{"", {0}, {}}}, std::pair{"five_scans", five.map}}) {
    const std::string sealed = encode_saved_map(map);
    expect_read(corpus / "saved_map" / name, payload_of(sealed), [&](const std::string& payload) {
      decode_saved_map(seal("MARCOMAP", version_of(sealed), payload));
    });
  }
  AdapterState nothing;
  nothing.map.session_starts = {0};
  for (const auto& [name, state] : {std::pair{"none", nothing}, std::pair{"five_scans", five}}) {
    const std::string sealed = encode_adapter_state(state);
    expect_read(corpus / "slam_checkpoint" / name, payload_of(sealed),
                [&](const std::string& payload) {
                  decode_adapter_state(seal("MARCOCHK", version_of(sealed), payload));
                });
  }
}

}  // namespace
}  // namespace marco::slam
