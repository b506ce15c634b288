// Hours of simulated driving through marco-slam's adapter at batch clock, with the short path that
// it keeps live, the same tour again and again: what a scan costs and how much memory is held, hour
// by hour. Exit 1 when the last hour's cost is more than 10 % above the first's, or more memory is
// in use in the second half than in the first, by 10 % of the most there (keyframes come and go).
#include <malloc.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "lcm_tools/process/arguments.hpp"
#include "lcm_tools/process/batch_bus.hpp"
#include "lcm_tools/process/config.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "marco/slam_pose_t.hpp"
#include "simulator/batch_simulation.hpp"
#include "slam/process/slam_adapter.hpp"

namespace marco {
namespace {

double cpu_now_s() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double resident_mb() {
  std::ifstream file("/proc/self/statm");
  long pages = 0, resident = 0;
  file >> pages >> resident;
  return static_cast<double>(resident) * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

/// What was asked for and not given back; the rest of resident_mb() is code, and holes.
double in_use_mb() {
  const struct mallinfo2 heap = mallinfo2();
  return static_cast<double>(heap.uordblks + heap.hblkhd) / 1e6;
}

/// The tour `rounds` times; it ends where it began.
sim::Tour repeated(const sim::Tour& tour, int rounds) {
  sim::Tour all = tour;
  for (int i = 1; i < rounds; ++i) {
    all.steps.insert(all.steps.end(), tour.steps.begin(), tour.steps.end());
    sim::TourStep home;
    home.to_m = tour.start_m;
    all.steps.push_back(home);
  }
  return all;
}

struct Period {
  int64_t scans = 0;
  double cpu_s = 0.0;
};

class Soak {
 public:
  Soak(const sim::Tour& tour, const sim::RayCaster& rays, double hours, double report_every_s)
      : period_s_(report_every_s), end_s_(3600.0 * hours) {
    const double round_s = sim::BatchSimulation(rays, tour, {}, 1).duration_s();
    const int rounds = static_cast<int>(end_s_ / round_s) + 1;
    std::printf("%.2f h in rounds of %.0f s\n", hours, round_s);
    std::printf("%8s %9s %12s %10s %10s %8s %8s %8s %8s %9s %9s\n", "hour", "scans", "us a scan",
                "memory MB", "in use MB", "keys", "edges", "loops", "poses", "error m", "at worst");
    std::fflush(stdout);
    sim::BatchSimulation simulation(rays, repeated(tour, rounds), {}, 1);
    process::BatchBus bus;
    slam::SlamAdapter adapter(bus, slam::SlamAdapterOptions{});
    adapter.keep_short_path();
    process::DropCounter drops;
    bus.subscribe<slam_pose_t>(channels::kSlamPose, drops, [this](const auto& pose, auto&) {
      live_ = {Utime::from_us(pose.utime), {pose.x_m, pose.y_m, pose.theta_rad}};
    });
    try {
      simulation.run([&](const Sample& sample, Utime sent) { take(bus, adapter, sample, sent); });
    } catch (const Over&) {
    }
    const GridMap map = adapter.slam().grid().to_map();
    const auto known = std::count_if(map.occupancy.begin(), map.occupancy.end(),
                                     [](uint8_t cell) { return cell != GridMap::kUnknown; });
    area_m2_ = static_cast<double>(known) * map.resolution_m * map.resolution_m;
  }

  int verdict() const {
    if (periods_.size() < 2) return 0;
    const double first = periods_.front().cpu_s / static_cast<double>(periods_.front().scans);
    const double last = periods_.back().cpu_s / static_cast<double>(periods_.back().scans);
    const double hours = period_s_ / 3600.0 * static_cast<double>(periods_.size() - 1);
    const auto half = used_mb_.begin() + static_cast<std::ptrdiff_t>(used_mb_.size() / 2);
    const double early_mb = *std::max_element(used_mb_.begin(), half);
    const double late_mb = *std::max_element(half, used_mb_.end());
    std::printf(
        "cost of a scan, last period to first: %+.1f %%; resident memory %+.2f MB an hour; "
        "%.0f MB for %.0f m2 of map: %.4f MB a m2; most in use in the first half %.1f MB, in the "
        "second %.1f\n",
        100.0 * (last / first - 1.0), (memory_mb_.back() - memory_mb_.front()) / hours,
        memory_mb_.back(), area_m2_, memory_mb_.back() / area_m2_, early_mb, late_mb);
    return last <= 1.1 * first && late_mb <= 1.1 * early_mb ? 0 : 1;
  }

 private:
  struct Over {};

  void take(process::BatchBus& bus, slam::SlamAdapter& adapter, const Sample& sample, Utime sent) {
    const double at_s = (sent - sim::BatchSimulation::kStart).seconds();
    if (const auto* truth = std::get_if<TruePose>(&sample)) {
      truth_ = truth->world_from_robot;
      if (!first_truth_) first_truth_ = truth_;
    }
    const EncodedMessage message = encode_sample(sample);
    const double before = cpu_now_s();
    bus.deliver(message.channel, message.bytes, sent);
    now_.cpu_s += cpu_now_s() - before;
    if (message.channel == channels::kLidar) {  // LIDAR_RAW carries the same scans
      ++now_.scans;
      note_error(adapter, at_s);
    }
    if (at_s < period_s_ * static_cast<double>(periods_.size() + 1)) return;
    periods_.push_back(now_);
    memory_mb_.push_back(resident_mb());
    used_mb_.push_back(in_use_mb());
    const slam::SlamState state = adapter.slam().state();
    std::printf("%8.2f %9lld %12.1f %10.1f %10.1f %8zu %8zu %8zu %8zu %9.3f %9.3f\n", at_s / 3600.0,
                static_cast<long long>(now_.scans),
                1e6 * now_.cpu_s / static_cast<double>(now_.scans), memory_mb_.back(),
                used_mb_.back(), state.keyframes.keys.size(), state.back_end.edges.size(),
                state.back_end.loops.size(),
                state.path.scans.size() + state.path.keyframe_poses.size(), error_m_, worst_m_);
    forget_truths(adapter.slam());
    worst_m_ = 0.0;
    std::fflush(stdout);
    now_ = {};
    if (at_s >= end_s_) throw Over{};
  }

  /// Of the live pose; says when it is off by more than kOffM, and when it is back.
  void note_error(const slam::SlamAdapter& adapter, double at_s) {
    if (!live_ || !first_truth_) return;
    if (adapter.slam().keys().back().utime == live_->utime) truth_at_[live_->utime.us] = truth_;
    note_new_loops(adapter.slam(), at_s);
    const Pose2 slam = *first_truth_ * live_->world_from_robot;
    error_m_ = (slam.translation_m() - truth_.translation_m()).norm();
    worst_m_ = std::max(worst_m_, error_m_);
    if (off_ == (error_m_ > (off_ ? kBackM : kOffM))) return;
    off_ = !off_;
    std::printf("  at %.2f s, (%.2f, %.2f): %.3f m off\n", at_s, truth_.x_m, truth_.y_m, error_m_);
    std::fflush(stdout);
  }

  /// Says which are untrue. Where keyframes became one in the same step a new one may be missed.
  void note_new_loops(const slam::Slam& slam, double at_s) {
    const auto truth_of = [&](int key) {
      return truth_at_.at(slam.keys()[static_cast<std::size_t>(key)].utime.us);
    };
    for (std::size_t i = std::min(loops_, slam.loops().size()); i < slam.loops().size(); ++i) {
      const slam::Loop& loop = slam.loops()[i];
      const Pose2 off = between(between(truth_of(loop.from), truth_of(loop.to)), loop.from_from_to);
      if (off.translation_m().norm() < kUntrueM) continue;
      std::printf(
          "  at %.2f s, (%.2f, %.2f): a loop %.2f m off, by %.2f m from what was believed\n", at_s,
          truth_.x_m, truth_.y_m, off.translation_m().norm(), loop.shift_m);
    }
    loops_ = slam.loops().size();
  }

  /// Of keyframes that are no more: what is measured is SLAM's memory.
  void forget_truths(const slam::Slam& slam) {
    std::set<int64_t> kept;
    for (const slam::Keyframe& key : slam.keys()) kept.insert(key.utime.us);
    std::erase_if(truth_at_, [&kept](const auto& entry) { return !kept.contains(entry.first); });
  }

  static constexpr double kOffM = 0.10, kBackM = 0.08, kUntrueM = 0.20;
  double error_m_ = 0.0, worst_m_ = 0.0;
  bool off_ = false;
  std::size_t loops_ = 0;
  std::map<int64_t, Pose2> truth_at_;  ///< the robot's, by a keyframe's time
  double period_s_, end_s_;
  Period now_;
  std::vector<Period> periods_;
  std::vector<double> memory_mb_, used_mb_;
  double area_m2_ = 0.0;
  std::optional<StampedPose2> live_;
  Pose2 truth_;
  std::optional<Pose2> first_truth_;
};

}  // namespace
}  // namespace marco

int main(int argc, char** argv) {
  return marco::process::run_main("slam_soak", [&] {
    marco::process::CommandLine app(
        "Hours of simulated driving at batch clock: memory and cost per scan");
    double hours = 12.0, every = 1.0;
    std::string world = "config/worlds/office.toml", tour = "config/tours/office.toml";
    app.add_option("--hours", hours).shows_default();
    app.add_option("--report-hours", every, "a line each").shows_default();
    app.add_option("--world", world).existing_file();
    app.add_option("--tour", tour).existing_file();
    if (const auto code = app.parse(argc, argv)) return *code;
    const auto built =
        marco::sim::build_world(marco::process::load_options<marco::sim::WorldSpec>(world));
    const marco::sim::RayCaster rays(built);
    return marco::Soak(marco::process::load_options<marco::sim::Tour>(tour), rays, hours,
                       3600.0 * std::min(every, hours / 2.0))
        .verdict();
  });
}
