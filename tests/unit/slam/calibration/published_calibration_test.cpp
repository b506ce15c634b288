#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "slam/calibration/closed_form.hpp"
#include "slam/calibration/refinement.hpp"
#include "tests/support/real_data.hpp"

// A robot of 9 cm with its laser mounted in three ways: wheel turns, scan matches, and what the
// authors found (Censi et al. 2013, github.com/AndreaCensi/calibration).
namespace marco::slam {
namespace {

std::vector<MotionSample> published_samples(const std::string& path) {
  std::ifstream lines(path);
  std::vector<MotionSample> samples;
  for (std::string line; std::getline(lines, line);) {
    const auto json = nlohmann::json::parse(line);
    const double seconds = json["T"];
    MotionSample sample;
    sample.wheels.push_back(
        {seconds * json["phi_l"].get<double>(), seconds * json["phi_r"].get<double>(), 0.0});
    sample.laser_moved = {json["sm"][0], json["sm"][1], json["sm"][2]};
    samples.push_back(sample);
  }
  return samples;
}

struct Published {
  std::vector<MotionSample> samples;
  RobotModel model;
};

/// Nothing without the data.
std::optional<Published> published(const std::string& name) {
  const char* data = marco::testing::real_data();
  if (data == nullptr) return std::nullopt;
  const std::string path = std::string(data) + "/calibration/" + name;
  std::ifstream file(path + "_results.json");
  if (!file) {
    std::printf("SKIPPED: no %s\n", path.c_str());
    return std::nullopt;
  }
  const auto json = nlohmann::json::parse(file);
  return Published{published_samples(path + ".tuple"),
                   {0.5 * json["l_diam"].get<double>(),
                    0.5 * json["r_diam"].get<double>(),
                    json["axle"],
                    {json["l_x"], json["l_y"], json["l_theta"]}}};
}

class PublishedCalibration : public ::testing::TestWithParam<const char*> {};

TEST_P(PublishedCalibration, IsRepeatedToSixDigits) {
  const auto data = published(GetParam());
  if (!data) GTEST_SKIP();
  const auto found = calibrate_in_closed_form(data->samples);
  ASSERT_TRUE(found.has_value());
  const ModelVector values = to_vector(found->model, 0.0), expected = to_vector(data->model, 0.0);
  for (int i = 0; i < kLate; ++i) {
    EXPECT_NEAR(values[i], expected[i], 5e-6 * std::abs(expected[i])) << "parameter " << i;
  }
  EXPECT_GT(found->heading_ratio, 14.0) << "trimming decides: without it, 1.0 to 1.4";
}

// Another way: all parameters together, outliers weighed down in place of cut off.
TEST_P(PublishedCalibration, IsRepeatedByRefinement) {
  const auto data = published(GetParam());
  if (!data) GTEST_SKIP();
  const ModelPrior prior{to_vector({0.02, 0.02, 0.09, {}}, 0.0),
                         (ModelVector() << 0.006, 0.006, 0.03, 0.3, 0.3, 0.5, 0.3).finished()};
  const auto start = calibrate_in_closed_form(data->samples);
  ASSERT_TRUE(start.has_value());
  const RefinedModel found =
      refine([&](double) { return data->samples; }, to_vector(start->model, 0.0), prior);
  const ModelVector expected = to_vector(data->model, 0.0);
  EXPECT_NEAR(found.parameters[kLaserX], expected[kLaserX], 3e-4);
  EXPECT_NEAR(found.parameters[kLaserY], expected[kLaserY], 3e-4);
  EXPECT_NEAR(found.parameters[kLaserYaw], expected[kLaserYaw], deg_to_rad(0.3));
  EXPECT_NEAR(found.parameters[kTrack], expected[kTrack], 3e-4);
  EXPECT_NEAR(found.parameters[kLeftScale], expected[kLeftScale], 1e-4);
  EXPECT_NEAR(found.parameters[kRightScale], expected[kRightScale], 1e-4);
  EXPECT_FALSE(found.observed[kLate]) << "one reading a motion says nothing of time";
}

INSTANTIATE_TEST_SUITE_P(Mounts,
                         PublishedCalibration,
                         ::testing::Values("lstraight_0", "l90_0", "lmov_0"));

}  // namespace
}  // namespace marco::slam
