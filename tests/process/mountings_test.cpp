// However the laser is mounted and swept, `marco map` alone makes a model of the place: simulated
// in the lab, and judged against its true surfaces.
#include <gtest/gtest.h>

#include <cstdio>

#include "common/trajectory_fit.hpp"
#include "lcm_tools/files/event_log.hpp"
#include "lcm_tools/process/config.hpp"
#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "lcmtypes/convert.hpp"
#include "mapping3d/process/mapping3d_adapter.hpp"
#include "simulator/batch_simulation.hpp"
#include "tools/evaluate/model_fit.hpp"
#include "tools/evaluate/model_judge.hpp"
#include "tools/evaluate/true_beams.hpp"
#include "tools/map/map_job.hpp"

namespace marco {
namespace {

sim::TourStep go(double x_m, double y_m) {
  sim::TourStep step;
  step.to_m = {x_m, y_m};
  return step;
}

sim::TourStep waiting(double seconds) {
  sim::TourStep step;
  step.kind = "wait";
  step.seconds = seconds;
  return step;
}

sim::TourStep panning(double from_deg, double to_deg) {
  sim::TourStep step;
  step.kind = "pan";
  step.pan_from_deg = from_deg;
  step.pan_to_deg = to_deg;
  step.rows = 360.0;
  return step;
}

sim::Tour tour(std::vector<sim::TourStep> steps) {
  sim::Tour tour;
  tour.start_m = {2.0, 3.0};
  tour.steps = std::move(steps);
  tour.steps.insert(tour.steps.begin(), waiting(1.0));
  return tour;
}

class Mountings : public ::testing::Test {
 protected:
  /// Goals are those of a nodding laser: the thesis' surfaces.
  void expect_model(const sim::Tour& tour, const sim::SimulationOptions& options) {
    const sim::RayCaster world(
        sim::build_world(process::load_options<sim::WorldSpec>("config/worlds/lab.toml")));
    const std::filesystem::path log_path = folder_.path() / "simulated.lcm";
    {
      files::OutputFile file(log_path);
      files::EventLogWriter log(file);
      sim::BatchSimulation simulation(world, tour, options, 5);
      simulation.run([&log](const Sample& sample, Utime sent) {
        const EncodedMessage message = encode_sample(sample);
        log.write(message.channel, message.bytes, sent);
      });
      file.finish();
    }
    MapJob job(folder_.path());
    job.read({log_path}, {});
    job.finish();
    const mapping3d::Mapper3d& mapper = job.mapping3d().mapper();
    ASSERT_FALSE(mapper.model().triangles.empty())
        << mapper.rows_without_scene() << " rows in none";
    const TrueBeams beams = true_beams(log_path, world);
    const Pose3 start = lift(fit_to_truth(job.trajectory(), beams.truth).truth_from_estimate);
    const Pose3 world_from_model = fit_model(mapper.model(), world, start).world_from_model;
    const ModelJudgement found =
        judge_model(moved(mapper.model(), world_from_model), world, beams.ends);
    std::printf("%zu scenes: rms %.4f p99 %.4f m, covered %.4f, sheets > 20 mm at %zu of %zu\n",
                mapper.scenes().size(), found.error.rms_m, found.error.p99_m,
                found.coverage->covered, found.sheets->too_far, found.sheets->places);
    EXPECT_LT(found.error.rms_m, rms_m_);
    EXPECT_GT(found.coverage->covered, covered_);
  }

  marco::testing::TemporaryFolder folder_;
  double rms_m_ = 0.010, covered_ = 0.95;
};

// The path is odometry's alone; the two stops are joined by what both see.
TEST_F(Mountings, AVerticalLaserThatIsPanned) {
  sim::SimulationOptions options;
  options.robot.laser_roll_pitch_yaw_deg = {90, 0, 0};
  expect_model(tour({panning(-180, 180), go(3.5, 2.7), panning(180, -180)}), options);
}

// Thesis B fig. 4.2: up and to both sides, while a level one maps.
TEST_F(Mountings, AFixedVerticalLaserThatIsDrivenThroughTheHouse) {
  sim::SimulationOptions options;
  options.robot.pantilt_state_hz = 0.0;
  options.robot.laser_roll_pitch_yaw_deg = {0, -90, 0};
  options.robot.level_laser_m = {0.2, 0.0, 0.3};
  options.robot.speed_m_per_s = 0.3;
  expect_model(tour({go(5.0, 2.4), go(5.4, 4.4), go(3.0, 4.4)}), options);
}

TEST_F(Mountings, ALaserOnASpinner) {
  sim::SimulationOptions options;
  options.robot.laser_roll_pitch_yaw_deg = {90, 0, 0};
  options.robot.spin_deg_per_s = 36.0;
  options.robot.level_laser_m = {0.2, 0.0, 0.3};
  expect_model(tour({waiting(21.0), go(5.0, 2.4), waiting(21.0)}), options);
}

TEST_F(Mountings, ANoddingLaserBesideALevelOne) {
  sim::SimulationOptions options;
  options.robot.level_laser_m = {0.2, 0.0, 0.3};
  sim::TourStep sweep;
  sweep.kind = "sweep";
  sweep.pans_deg = {0, 90, 180, 270};
  expect_model(tour({sweep, go(5.0, 2.4), sweep}), options);
}

}  // namespace
}  // namespace marco
