#include <cstdio>

#include "common/files/relations.hpp"
#include "common/files/tum.hpp"
#include "common/relations_metric.hpp"
#include "common/trajectory_fit.hpp"
#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/event_log.hpp"
#include "lcm_tools/process/arguments.hpp"
#include "lcm_tools/process/exit_code.hpp"
#include "lcmtypes/channels.hpp"
#include "marco/slam_pose_t.hpp"
#include "recordings/recording.hpp"

namespace marco {
namespace {

void print(const RelationsError& error) {
  const auto print_spread = [](const char* name, const ErrorSpread& spread) {
    std::printf("%s mean=%.4f std=%.4f p95=%.4f max=%.3f", name, spread.mean, spread.std,
                spread.p95, spread.max);
  };
  print_spread("translation_m", error.translation_m);
  print_spread(" rotation_deg", error.rotation_deg);
  std::puts("");
}

int evaluate_relations(const Trajectory& trajectory, const std::string& path, double tolerance_s) {
  const RelationsReport report =
      compare_with_relations(trajectory, files::read_relations(path), tolerance_s);
  if (report.all.count == 0) {
    std::printf("n=0 skipped=%zu: no relation has both ends in the trajectory\n", report.skipped);
    return 1;
  }
  std::printf("n=%zu skipped=%zu ", report.all.count, report.skipped);
  print(report.all);
  if (report.far_apart.count > 0) {
    std::printf("apart>60s n=%zu ", report.far_apart.count);
    print(report.far_apart);
  }
  return 0;
}

RecordedTruth recorded_truth(const std::string& path) {
  const auto recording = open_recording(path);
  RecordedTruth truth;
  while (const auto sample = recording->next()) {
    if (const auto* pose = std::get_if<TruePose>(&*sample)) truth.add(*pose);
  }
  return truth;
}

// The poses that a live SLAM published, in the order of their stamps.
Trajectory recorded_path(const std::string& path) {
  files::EventLogReader log(path);
  Trajectory poses;
  while (const auto event = log.next()) {
    slam_pose_t message{};
    const auto size = static_cast<int>(event->bytes.size());
    if (event->channel != channels::kSlamPose ||
        message.decode(event->bytes.data(), 0, size) != size)
      continue;
    const Trajectory::value_type pose{Utime{message.utime},
                                      Pose2{message.x_m, message.y_m, message.theta_rad}};
    if (poses.empty() || poses.back().utime < pose.utime) poses.push_back(pose);
  }
  return poses;
}

int print_fit(const Trajectory& trajectory, const RecordedTruth& truth, const std::string& path) {
  const TrajectoryFit fit = fit_to_truth(trajectory, truth);
  if (fit.count < 2) {
    std::printf("n=%zu: no pose of the trajectory has a counterpart in %s\n", fit.count,
                path.c_str());
    return 1;
  }
  std::printf("n=%zu position_m rms=%.4f max=%.4f", fit.count, fit.rms_m, fit.max_m);
  if (truth.is_by_arrival) std::printf(" truth_late_s=%.3f", fit.truth_late.seconds());
  std::puts("");
  return 0;
}

}  // namespace
}  // namespace marco

int main(int argc, char** argv) {
  return marco::process::run_main("marco-evaluate", [&] {
    marco::process::CommandLine app(
        "Error of a trajectory against RELATIONS (verified relative poses), against the true "
        "poses of a log, or against the SLAM poses in a log.\n"
        "  marco evaluate out/trajectory.tum intel.relations\n"
        "  marco evaluate out/trajectory.tum --truth simulated.lcm\n"
        "  marco evaluate out/trajectory_live.tum --recorded replayed.lcm");
    std::string trajectory_path, relations_path, truth_path, recorded_path;
    double tolerance_s = 2e-6;
    app.add_option("TRAJECTORY", trajectory_path,
                   "'time x y z qx qy qz qw' (TUM) or 'time x y theta' per line")
        .required();
    auto relations =
        app.add_option("RELATIONS", relations_path,
                       "'time1 time2 x y z roll pitch yaw' per line: pose 2 seen from pose 1");
    auto truth = app.add_option("--truth", truth_path, "a log with TRUE_POSE").excludes(relations);
    app.add_option("--recorded", recorded_path, "a log with SLAM_POSE")
        .excludes(relations)
        .excludes(truth);
    app.add_option("--tolerance", tolerance_s,
                   "[s] largest gap between a relation's time and a pose");
    if (const auto code = app.parse(argc, argv)) return *code;
    marco::process::require_usage(
        !relations_path.empty() || !truth_path.empty() || !recorded_path.empty(),
        "give RELATIONS, --truth LOG or --recorded LOG");
    const marco::Trajectory trajectory = marco::files::read_tum(trajectory_path);
    if (!truth_path.empty())
      return marco::print_fit(trajectory, marco::recorded_truth(truth_path), truth_path);
    if (!recorded_path.empty()) {
      return marco::print_fit(trajectory, {marco::recorded_path(recorded_path)}, recorded_path);
    }
    return marco::evaluate_relations(trajectory, relations_path, tolerance_s);
  });
}
