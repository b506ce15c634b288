// Your own subscriber: prints each pose from SLAM.   follow_the_robot [NUMBER]
#include <cstdio>
#include <cstdlib>

#include "lcm_tools/process/lcm_bus.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"

int main(int argc, char** argv) {
  long left = argc > 1 ? std::atol(argv[1]) : -1;
  marco::process::LcmBus bus("");
  marco::process::DropCounter drops;  // counts messages that cannot be decoded
  bus.subscribe<marco::slam_pose_t>(
      marco::channels::kSlamPose, drops, [&left](const auto& message, const auto&) {
        const marco::PoseEstimate estimate = from_message(message);
        const marco::Pose2& pose = estimate.world_from_robot;
        std::printf(
            "x %.2f m, y %.2f m, heading %.0f deg%s\n", pose.x_m, pose.y_m,
            marco::rad_to_deg(pose.theta_rad),
            estimate.status == marco::PoseEstimate::Status::matched ? "" : " (not matched)");
        std::fflush(stdout);
        if (left > 0) --left;
      });
  while (left != 0) bus.handle_once(100);
}
