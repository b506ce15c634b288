// How honest the pose graph's covariances are: edges LOG... (recordings with TRUE_POSE, as
// marco-simulate writes them).
//
// For the edges between keyframes that follow each other, and for the loops in force: the
// normalised estimation error squared (NEES) e^T Omega e of the measured pose against the true one.
// An honest covariance gives 3 in the mean, 2.4 in the median, and above 11.3 in 1 %. Beside it the
// mean of e^2 / sigma^2 for x, y and heading, 1 each where honest, and the median of the
// covariance's sigmas. Of a laser that turns slowly, truth is that of a scan's first beam, while a
// match finds the pose of its middle: the turn between both, as far as its rate is not known,
// counts as error.
#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <map>

#include "common/covariance.hpp"
#include "recordings/foreign.hpp"
#include "slam/process/mapper2d_adapter.hpp"
#include "slam/session/mapping_session.hpp"
#include "tools/map/judge.hpp"
#include "tools/map/map_job.hpp"

namespace marco {
namespace {

struct Normalised {
  std::vector<double> nees;
  std::array<double, 3> by_axis{};
  std::array<std::vector<double>, 3> sigmas;

  void add(const slam::PoseGraphEdge& edge, const Pose2& from, const Pose2& to) {
    const Eigen::Vector3d error = slam::edge_error(edge, from, to);
    const Eigen::Matrix3d covariance = covariance_of(edge.information);
    nees.push_back(error.dot(edge.information * error));
    for (int axis = 0; axis < 3; ++axis) {
      const auto at = static_cast<std::size_t>(axis);
      by_axis[at] += error(axis) * error(axis) / covariance(axis, axis);
      sigmas[at].push_back(std::sqrt(covariance(axis, axis)));
    }
  }
};

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

void print(const char* what, const Normalised& edges) {
  if (edges.nees.empty()) return;
  const auto n = static_cast<double>(edges.nees.size());
  double sum = 0.0, above = 0.0;
  for (const double nees : edges.nees) {
    sum += nees;
    above += nees > kChi2Dof3Quantile99 ? 1.0 : 0.0;
  }
  std::printf(
      "  %-8s n %5.0f  NEES mean %6.2f  median %5.2f  above 11.3: %4.1f %%  largest %7.1f   x "
      "%5.2f  "
      "y %5.2f  heading %5.2f   sigma %.4f m  %.4f m  %.3f deg\n",
      what, n, sum / n, median(edges.nees), 100.0 * above / n,
      *std::max_element(edges.nees.begin(), edges.nees.end()), edges.by_axis[0] / n,
      edges.by_axis[1] / n, edges.by_axis[2] / n, median(edges.sigmas[0]), median(edges.sigmas[1]),
      rad_to_deg(median(edges.sigmas[2])));
}

void run(const std::filesystem::path& log) {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "marco_edges";
  std::filesystem::create_directories(folder);
  MapJob job(folder);
  job.read({log}, ForeignTable{});
  job.finish();
  std::map<int64_t, Pose2> truth;
  for (const StampedPose2& pose : job.recorded().truth.poses)
    truth[pose.utime.us] = pose.world_from_robot;
  std::vector<Pose2> keys;
  for (const slam::Keyframe& key : job.keyframes()) keys.push_back(truth.at(key.utime.us));
  Normalised steps, loops;
  for (const slam::PoseGraphEdge& edge : job.session()->slam().edges()) {
    if (edge.is_loop) continue;
    steps.add(edge, keys[static_cast<std::size_t>(edge.from)],
              keys[static_cast<std::size_t>(edge.to)]);
  }
  for (const slam::Loop& loop : job.mapper().loops()) {
    if (!loop.is_inlier) continue;
    loops.add({loop.from, loop.to, loop.from_from_to, loop.information, true},
              keys[static_cast<std::size_t>(loop.from)], keys[static_cast<std::size_t>(loop.to)]);
  }
  std::printf("%s: path rms %.4f m\n", log.filename().c_str(),
              judge_path(job).at("path error rms_m"));
  print("steps", steps);
  print("loops", loops);
  std::fflush(stdout);
}

}  // namespace
}  // namespace marco

int main(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) marco::run(argv[i]);
  return argc > 1 ? 0 : 1;
}
