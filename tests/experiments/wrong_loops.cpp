// Public pose graphs with random wrong loops: wrong_loops FOLDER [seeds]. FOLDER holds *.g2o files.
// Wrong loops join two random nodes by a random pose of the graph's own loops' sizes, as sure of
// themselves as a loop of the graph. Printed: chi2 of the clean optimum from several starts, and
// for each share of wrong loops the rms distance of all nodes to it (node 0 is fixed in both).
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <random>
#include <string>

#include "slam/back_end/graph/pose_graph.hpp"
#include "tests/support/g2o_graph.hpp"

namespace marco::slam {
namespace {

double rms_m(const std::vector<Pose2>& a, const std::vector<Pose2>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    sum += (a[i].translation_m() - b[i].translation_m()).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(a.size()));
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void run(const std::string& path, int seeds) {
  const PoseGraph clean = testing::read_g2o(path);
  PoseGraph optimum = clean;
  testing::initialize_from_edges(optimum);
  optimum.optimize();
  const auto loops = std::count_if(clean.edges().begin(), clean.edges().end(),
                                   [](const PoseGraphEdge& edge) { return edge.is_loop; });
  std::printf("%s: %zu nodes, %td loops; chi2 %.3f from rotations first", path.c_str(),
              clean.node_count(), loops, optimum.chi2());
  PoseGraph chain = clean;
  testing::place_along_odometry(chain);
  chain.optimize();
  std::printf(", %.3f from odometry\n", chain.chi2());
  for (const int percent : {0, 5, 20, 50}) {
    for (int seed = 1; seed <= seeds; ++seed) {
      PoseGraph graph = clean;
      const int wrong = static_cast<int>(loops) * percent / 100;
      std::mt19937 random(static_cast<unsigned>(seed));
      testing::add_wrong_loops(graph, wrong, random);
      testing::place_along_odometry(graph);
      const auto start = std::chrono::steady_clock::now();
      const PoseGraphResult result = graph.optimize_robustly();
      const double time_s = seconds_since(start);
      int wrong_kept = 0, right_lost = 0;
      for (std::size_t i = 0; i < graph.edges().size(); ++i) {
        const bool is_wrong = i >= clean.edges().size();
        wrong_kept += is_wrong && result.edge_is_inlier[i] ? 1 : 0;
        right_lost += !is_wrong && !result.edge_is_inlier[i] ? 1 : 0;
      }
      std::printf(
          "  %2d %% wrong (%4d), seed %d: rms %.4f m, wrong kept %d, right lost %d, %.2f s\n",
          percent, wrong, seed, rms_m(graph.poses(), optimum.poses()), wrong_kept, right_lost,
          time_s);
      std::fflush(stdout);
      if (percent == 0) break;
    }
  }
}

}  // namespace
}  // namespace marco::slam

int main(int argc, char** argv) {
  if (argc < 2) return 1;
  for (const char* name : {"INTEL.g2o", "MITb.g2o", "M3500.g2o"}) {
    const std::filesystem::path path = std::filesystem::path(argv[1]) / name;
    if (std::filesystem::exists(path)) {
      marco::slam::run(path.string(), argc > 2 ? std::atoi(argv[2]) : 3);
    }
  }
  return 0;
}
