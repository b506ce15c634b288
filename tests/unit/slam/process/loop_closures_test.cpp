// LOOP_CLOSURES, as both SLAMs publish it beside TRAJECTORY.
#include <map>
#include <numbers>

#include "marco/map_request_t.hpp"
#include "slam/back_end/loops_in_force.hpp"
#include "slam/process/line_slam_adapter.hpp"
#include "tests/unit/slam/process/slam_adapter_fixture.hpp"

namespace marco::slam {
namespace {

TEST(LoopsInForce, AreAtTheirKeyframesAndWithoutThoseRefused) {
  std::vector<Keyframe> keys(3);
  for (std::size_t i = 0; i < keys.size(); ++i) {
    keys[i].utime = Utime::from_us(10 + static_cast<int64_t>(i));
    keys[i].world_from_robot = Pose2{static_cast<double>(i), 2.0, 0.5 * std::numbers::pi};
  }
  Loop taken, refused;
  taken.from = 0;
  taken.to = 2;
  taken.from_from_to = {0.5, -2.0, 0.25};  // the map has it at 0, -2, 0
  taken.overlap = 0.75;
  refused.to = 1;
  refused.is_inlier = false;
  const LoopClosures loops = loops_in_force({refused, taken}, keys);
  ASSERT_EQ(loops.size(), 1U);
  EXPECT_EQ(loops[0].from_utime.us, 10);
  EXPECT_EQ(loops[0].to_utime.us, 12);
  EXPECT_EQ(loops[0].from_m, Eigen::Vector2d(0.0, 2.0));
  EXPECT_EQ(loops[0].to_m, Eigen::Vector2d(2.0, 2.0));
  EXPECT_NEAR(loops[0].residual_m, 0.5, 1e-12);
  EXPECT_NEAR(loops[0].residual_rad, 0.25, 1e-12);
  EXPECT_EQ(loops[0].overlap, 0.75);
}

// What was heard of an adapter that drove twice round.
class LoopClosuresOf : public SlamAdapterFixture {
 protected:
  LoopClosuresOf() {
    record({0.1, 0, 0.065}, 190);
    bus_.subscribe<trajectory_t>(channels::kTrajectory, heard_,
                                 [this](const auto& path, const auto&) { paths_.push_back(path); });
    bus_.subscribe<loop_closures_t>(
        channels::kLoopClosures, heard_,
        [this](const auto& loops, const auto&) { loops_.push_back(loops); });
  }
  void drive(Mapper2dAdapter& slam) {
    for (const Sample& sample : samples_) send(bus_, sample);
    slam.finish();
    bus_.deliver_published();
  }
  void expect_loops_beside_each_trajectory(const Mapper2d& mapper) {
    ASSERT_EQ(loops_.size(), paths_.size());
    EXPECT_LT(loops_.size(), samples_.size() / 8) << "they are not for every scan";
    for (std::size_t i = 0; i < loops_.size(); ++i) {
      EXPECT_EQ(loops_[i].utime, paths_[i].utime);
      EXPECT_EQ(loops_[i].revision, paths_[i].revision);
    }
    EXPECT_EQ(loops_.front().num_loops, 0);
    const LoopClosures loops = from_message(loops_.back());
    EXPECT_EQ(loops.size(), loops_in_force(mapper.loops(), mapper.keys()).size());
    ASSERT_GT(loops.size(), 3U);
    std::map<int64_t, Pose2> keyframes;
    for (const StampedPose2& pose : from_message(paths_.back())) {
      keyframes[pose.utime.us] = pose.world_from_robot;
    }
    for (const LoopClosure& loop : loops) {
      EXPECT_EQ(loop.from_m, keyframes.at(loop.from_utime.us).translation_m());
      EXPECT_EQ(loop.to_m, keyframes.at(loop.to_utime.us).translation_m());
      EXPECT_GT((loop.to_utime - loop.from_utime).seconds(), 10.0);  // the first round took 19 s
      EXPECT_LT((loop.to_m - loop.from_m).norm(), 2.0);
      EXPECT_LT(loop.residual_m, 0.1);  // matches of noisy scans contradict each other by less
      EXPECT_GT(loop.overlap, 0.6);
    }
  }

  process::BatchBus bus_;
  process::DropCounter heard_;
  std::vector<trajectory_t> paths_;
  std::vector<loop_closures_t> loops_;
};

TEST_F(LoopClosuresOf, ScanSlam) {
  SlamAdapter slam(bus_, {});
  drive(slam);
  expect_loops_beside_each_trajectory(slam.mapper2d());
}

TEST_F(LoopClosuresOf, LineSlam) {
  LineSlamAdapter slam({}, bus_);
  drive(slam);
  expect_loops_beside_each_trajectory(slam.mapper2d());
}

TEST_F(LoopClosuresOf, ANewMapHasNone) {
  SlamAdapter slam(bus_, {});
  drive(slam);
  order(bus_, slam_command_t::RESET);
  map_request_t request{};
  request.channel = channels::kTrajectory;
  bus_.deliver(channels::kMapRequest, encode_message(request), {});
  EXPECT_EQ(loops_.back().num_loops, 0);
}

}  // namespace
}  // namespace marco::slam
