// Thesis B's table 5.1 by our protocol (tests/support/matching_table.hpp): table_5_1 [matches a
// row].
#include <cstdio>
#include <cstdlib>
#include <string>

#include "slam/matching/nlm_matcher.hpp"
#include "slam/matching/surfel_matcher.hpp"
#include "tests/support/matching_table.hpp"

namespace marco::slam {
namespace {

using testing::MatchTrial;

std::function<Pose2(const MatchTrial&)> nlm(const std::string& estimator, bool calculated_points) {
  NlmOptions options;
  options.estimator = estimator;
  options.calculated_points = calculated_points;
  options.max_pair_m = 40.0;  // as in the thesis: every point has a partner
  options.min_overlap = 0.0;
  const NlmMatcher matcher(options);
  return [matcher](const MatchTrial& trial) {
    return matcher.match(NlmTarget(trial.target), trial.source, trial.start).target_from_source;
  };
}

Pose2 local(const MatchTrial& trial) {
  SurfelPyramid map({}, {0, 0});
  map.add(orient(trial.target, {0, 0}, {}), Pose2{});
  return SurfelMatcher()
      .match(map, orient(trial.source, {0, 0}, {}), trial.start, nullptr)
      .map_from_robot;
}

void print_row(const char* name, double part, const testing::MatchTable& t) {
  std::printf("%-26s %3.0f %%  %7.3f %6.3f %6.2f  %7.3f %6.3f %7.2f   %5.3f %5.3f  %5.3f %5.3f\n",
              name, 100.0 * part, t.angle_deg.mean, t.angle_deg.deviation, t.angle_deg.max,
              t.translation_cm.mean, t.translation_cm.deviation, t.translation_cm.max,
              t.bound.angle_deg, t.bound.translation_cm, t.honest_bound.angle_deg,
              t.honest_bound.translation_cm);
  std::fflush(stdout);
}

void print_table(int count) {
  std::printf(
      "%-26s outl.  angle: mean  std   max [deg]  move: mean  std    max [cm]   bound deg    cm"
      "  of unknown walls\n",
      "method");
  for (const double part : {0.02, 0.2, 0.4}) {
    print_row("least squares", part, match_table(part, count, 51, nlm("least_squares", false)));
    print_row("Lorentzian", part, match_table(part, count, 51, nlm("lorentzian", false)));
    print_row("Lorentzian, calculated", part,
              match_table(part, count, 51, nlm("lorentzian", true)));
    print_row("Geman-McClure, calculated", part,
              match_table(part, count, 51, nlm("geman_mcclure", true)));
    print_row("local map", part, match_table(part, count, 51, local));
  }
}

}  // namespace
}  // namespace marco::slam

int main(int argc, char** argv) {
  marco::slam::print_table(argc > 1 ? std::max(1, std::atoi(argv[1])) : 1000);
  return 0;
}
