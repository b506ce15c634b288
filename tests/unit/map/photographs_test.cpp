#include "tools/map/photographs.hpp"

#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "bot_core/image_t.hpp"
#include "lcm_tools/files/event_log.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/process/config.hpp"
#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "mapping3d/surface/photograph_list.hpp"

namespace marco {
namespace {

using bot_core::image_t;
using ::testing::ElementsAre;
using ::testing::Pair;

image_t jpeg() {
  image_t image{};
  image.width = image.height = 2;
  image.pixelformat = image_t::PIXEL_FORMAT_MJPEG;
  image.data = {0xFF, 0xD8, 0xFF, 0xE0, 0x00, 0x10};
  image.size = static_cast<int32_t>(image.data.size());
  return image;
}

image_t grey() {
  image_t image{};
  image.width = 3;
  image.height = 2;
  image.row_stride = 3;
  image.pixelformat = image_t::PIXEL_FORMAT_GRAY;
  image.data = {1, 2, 3, 4, 5, 6};
  image.size = 6;
  return image;
}

// A robot that drives ahead at 1 m/s for 10 s, turns left at 45 degrees/s for 4 s, and drives on.
class Photographs : public ::testing::Test {
 protected:
  Photographs() : log_(std::make_unique<files::EventLogWriter>(log_name())) {
    for (int i = 0; i <= 100; ++i) path_.push_back({stamp(0.1 * i), {0.1 * i, 0, 0}});
    for (int i = 1; i <= 40; ++i) path_.push_back({stamp(10.0 + 0.1 * i), {10, 0, turn_rad(i)}});
    for (int i = 1; i <= 50; ++i) {
      path_.push_back({stamp(14.0 + 0.1 * i), {10.0 - 0.1 * i, 0, std::numbers::pi}});
    }
    SensorInfo info;
    info.channel = "CAMERA";
    info.focal_length_px = 500.0;
    info.parent_from_sensor.translation() = Eigen::Vector3d(0.2, 0.1, 1.0);
    sensors_ = {{"CAMERA", info}};
  }
  static double turn_rad(int tenths) { return deg_to_rad(4.5 * tenths); }
  static Utime stamp(double seconds) { return Utime::from_seconds(100.0 + seconds); }
  std::string log_name() const { return (folder_.path() / "a.lcm").string(); }
  void take(double seconds, image_t image = jpeg(), const std::string& channel = "CAMERA") {
    image.utime = stamp(seconds).us;
    std::vector<uint8_t> bytes(static_cast<std::size_t>(image.getEncodedSize()));
    image.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
    log_->write(channel, bytes, stamp(seconds));
  }
  PhotographCounts choose() {
    log_->flush();
    return write_photographs(folder_.path(), {log_name()}, path_, sensors_, options_);
  }
  std::vector<PhotographSpec> written() const {
    const auto list = (folder_.path() / "photographs.toml").string();
    return process::load_options<PhotographList>(list).photographs;
  }
  std::vector<double> written_x_m() const {
    std::vector<double> x_m;
    for (const PhotographSpec& one : written()) x_m.push_back(one.position_m[0]);
    return x_m;
  }

  testing::TemporaryFolder folder_;
  std::unique_ptr<files::EventLogWriter> log_;
  Trajectory path_;
  std::map<std::string, SensorInfo> sensors_;
  PhotographOptions options_;
};

TEST_F(Photographs, HaveThePoseOfTheirCameraAtTheirStampAndLookAhead) {
  take(2.53);
  std::reverse(path_.begin(), path_.end());
  const PhotographCounts counts = choose();
  EXPECT_EQ(counts.recorded, 1);
  EXPECT_EQ(counts.chosen, 1);
  EXPECT_TRUE(counts.dropped.empty());
  const PhotographSpec one = written().at(0);
  EXPECT_NEAR(one.position_m[0], 2.73, 1e-6);
  EXPECT_NEAR(one.position_m[1], 0.1, 1e-6);
  EXPECT_NEAR(one.position_m[2], 1.0, 1e-6);
  EXPECT_THAT(one.focal_px, ElementsAre(500.0));
  const std::vector<double>& q = one.quaternion_xyzw;
  const Eigen::Matrix3d model_from_camera = Eigen::Quaterniond(q[3], q[0], q[1], q[2]).matrix();
  EXPECT_LT((model_from_camera.col(2) - Eigen::Vector3d::UnitX()).norm(), 1e-6) << "z is ahead";
  EXPECT_LT((model_from_camera.col(1) + Eigen::Vector3d::UnitZ()).norm(), 1e-6) << "y is down";
  EXPECT_EQ(one.file, "photographs/000.jpg");
  EXPECT_EQ(files::read_whole_file(folder_.path() / one.file).size(), 6U);
}

TEST_F(Photographs, OfOnePlaceAndViewOneIsKept) {
  for (int i = 0; i < 20; ++i) take(0.1 * i);
  take(12.0 + 1e-3);            // turned by 90 degrees, but too fast
  take(18.5);                   // at the first ones' place, looking back
  take(1.0, jpeg(), "CAMERA");  // seen already
  const PhotographCounts counts = choose();
  EXPECT_EQ(counts.recorded, 23);
  EXPECT_THAT(counts.dropped, ElementsAre(Pair("taken during a fast turn", 1)));
  EXPECT_EQ(counts.chosen, 5) << "each 0.6 m, and the one back";
  const std::vector<double> x_m = written_x_m();
  for (std::size_t i = 0; i + 2 < x_m.size(); ++i) EXPECT_NEAR(x_m[i + 1] - x_m[i], 0.65, 0.06);
}

TEST_F(Photographs, OfAnotherCameraTheSamePlaceIsAnotherView) {
  sensors_["CAMERA_LEFT"] = sensors_["CAMERA"];
  sensors_["CAMERA_LEFT"].parent_from_sensor.linear() =
      Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitZ()).matrix();
  take(1.0);
  take(1.0, grey(), "CAMERA_LEFT");
  EXPECT_EQ(choose().chosen, 2);
  EXPECT_EQ(written()[1].file, "photographs/001.pgm");
  EXPECT_EQ(files::read_whole_file(folder_.path() / written()[1].file),
            "P5\n3 2\n255\n\x01\x02\x03\x04\x05\x06");
}

TEST_F(Photographs, WhatCannotBeUsedIsCountedByItsCause) {
  take(-1.0);  // before the path, and after it
  take(25.0);
  take(1.0, jpeg(), "CAMERA_TOP");  // nobody says where it is
  sensors_["CAMERA_ARM"] = sensors_["CAMERA"];
  sensors_["CAMERA_ARM"].mount = SensorInfo::Mount::pantilt;
  take(2.0, jpeg(), "CAMERA_ARM");
  sensors_["CAMERA_BLIND"] = sensors_["CAMERA"];
  sensors_["CAMERA_BLIND"].focal_length_px = 0.0;
  take(2.0, jpeg(), "CAMERA_BLIND");
  image_t broken = jpeg();
  broken.data[1] = 0;
  take(3.0, broken);
  image_t small = grey();
  small.width = small.row_stride = 1;
  take(4.0, small);
  EXPECT_EQ(choose().chosen, 0);
  EXPECT_THAT(choose().dropped, ElementsAre(Pair("camera without SENSOR_INFO or focal length", 2),
                                            Pair("camera without pan-tilt angles", 1),
                                            Pair("taken where the path is unknown", 2),
                                            Pair("unknown picture format", 2)));
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "photographs.toml"));
}

TEST_F(Photographs, InAGapOfThePathTheirPlaceIsUnknown) {
  path_.erase(path_.begin() + 21, path_.begin() + 30);
  take(2.0);
  take(2.5);
  take(3.05);
  EXPECT_THAT(choose().dropped, ElementsAre(Pair("taken where the path is unknown", 1)));
  EXPECT_THAT(written_x_m(),
              ElementsAre(::testing::DoubleNear(2.2, 1e-6), ::testing::DoubleNear(3.25, 1e-6)));
}

// Its angles come after the picture, as a servo's do; one that fell silent delays nothing.
TEST_F(Photographs, OfAPanTiltWaitForItsAnglesAndAreTurnedByThem) {
  sensors_["CAMERA"].mount = SensorInfo::Mount::pantilt;
  sensors_["CAMERA"].parent_from_sensor = Pose3::Identity();
  SensorInfo base;
  base.channel = channels::kPanTiltState;
  base.parent_from_sensor.translation() = Eigen::Vector3d(0.0, 0.0, 0.8);
  sensors_[base.channel] = base;
  const auto pan = [this](double seconds, double pan_rad) {
    const EncodedMessage state =
        encode_sample(Sample{PanTiltState{stamp(seconds), pan_rad, 0.0, 0.0, 0.0}});
    log_->write(state.channel, state.bytes, stamp(seconds));
  };
  pan(1.0, 0.2);
  take(1.03);
  pan(1.06, 0.4);
  take(5.0);  // nothing follows
  const PhotographCounts counts = choose();
  EXPECT_EQ(counts.chosen, 1);
  EXPECT_THAT(counts.dropped, ElementsAre(Pair("camera without pan-tilt angles", 1)));
  const PhotographSpec one = written().at(0);
  const std::vector<double>& q = one.quaternion_xyzw;
  const Eigen::Vector3d ahead =
      Eigen::Quaterniond(q[3], q[0], q[1], q[2]) * Eigen::Vector3d::UnitZ();
  EXPECT_NEAR(std::atan2(ahead.y(), ahead.x()), 0.3, 1e-6);
  EXPECT_NEAR(one.position_m[2], 0.8, 1e-6);
}

TEST_F(Photographs, NoMoreAreKeptThanWanted) {
  for (int i = 0; i < 99; ++i) take(0.1 * i);
  EXPECT_GT(choose().chosen, 10);
  options_.most = 4;
  EXPECT_GE(choose().chosen, 3);
  const std::vector<double> x_m = written_x_m();
  EXPECT_LE(x_m.size(), 4U);
  for (std::size_t i = 0; i + 1 < x_m.size(); ++i) EXPECT_GT(x_m[i + 1] - x_m[i], 1.5);
  EXPECT_GT(x_m.back(), 7.0) << "from the whole way, not from where it began";
  options_.most = 0;
  EXPECT_EQ(choose().recorded, 0);
}

}  // namespace
}  // namespace marco
