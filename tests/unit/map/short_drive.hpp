#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <memory>

#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "slam/map/keyframe.hpp"
#include "tests/support/ring_log.hpp"
#include "tools/map/map_job.hpp"

namespace marco::testing {

/// Of a drive: a round of 40 s, and 12 s more over the same places.
inline constexpr std::size_t kScans = 520;

/// That drive, mapped within this process, once for all tests.
class ShortDrive : public ::testing::Test {
 protected:
  void SetUp() override {
    if (job_) return;
    folder_ = std::make_unique<TemporaryFolder>();
    std::string log = ring_log(1.02, 1.0);
    std::size_t end = 0;
    for (std::size_t line = 0; line < kScans; ++line) end = log.find('\n', end) + 1;
    const auto name = folder_->write("drive.log", log.substr(0, end));
    job_ = std::make_unique<MapJob>(folder_->path());
    job_->read({name});
    job_->finish();
  }
  static const slam::Keyframe& key(int at) {
    return job_->keyframes()[static_cast<std::size_t>(at)];
  }
  static inline std::unique_ptr<TemporaryFolder> folder_;
  static inline std::unique_ptr<MapJob> job_;
};

}  // namespace marco::testing
