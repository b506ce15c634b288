// The landmark SLAM on simulated drives among posts: `posts_statistics [seeds] [first seed]`.
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "tests/post_run.hpp"

namespace marco {
namespace {

struct Case {
  std::string name;
  testing::PostWorld world;
  slam::LandmarkSlamOptions options;
  bool set_up_is_drawn = false;  ///< from the options' standard deviations, by the seed
};

// A world whose wheels and sensor are as wrong as the options say they may be.
testing::PostWorld drawn(testing::PostWorld world, const slam::SetUpOptions& by, unsigned seed) {
  std::mt19937 random(seed);
  const auto normal = [&](double sigma) {
    return sigma * std::normal_distribution<double>()(random);
  };
  world.speed_scale = 1.0 / (1.0 + normal(by.speed_scale_sigma));
  world.turn_scale = 1.0 / (1.0 + normal(by.turn_scale_sigma));
  world.turn_bias_rad_per_s = normal(by.turn_bias_sigma_rad_per_s);
  world.sensor_ahead_m = normal(by.sensor_sigma_m);
  world.sensor_left_m = normal(by.sensor_sigma_m);
  world.sensor_yaw_rad = normal(by.sensor_yaw_sigma_rad);
  return world;
}

std::vector<Case> cases() {
  std::vector<Case> all;
  const auto add = [&](const std::string& name) -> Case& {
    all.push_back({name, {}, {}, false});
    return all.back();
  };
  add("10 Hz");
  add("set-up drawn").set_up_is_drawn = true;
  Case& known = add("all known");
  known.options.set_up = {0, 0, 0, 0, 0, 0, 0, 0};
  known.options.learn_noise = false;
  known.options.noise = {0.033, 0.026, 0.0122, 0.0365};
  Case& drawn05 = add("drawn, start 0.05");
  drawn05.set_up_is_drawn = true;
  drawn05.options.noise.move_sigma_m = drawn05.options.noise.turn_sigma_rad = 0.05;
  add("1 Hz").world.scan_every = 10;
  add("5 % clutter").world.clutter_part = 0.05;
  add("30 % missed").world.missed_part = 0.3;
  Case& both = add("both, ahead only");
  both.world.clutter_part = 0.05;
  both.world.missed_part = 0.3;
  both.world.view_rad = 4.2;
  add("pairs 40 cm apart").world.pairs = 4;
  Case& blind = add("blind for 30 s");
  blind.world.blind_from_s = 400.0;
  blind.world.blind_to_s = 430.0;
  Case& bias = add("wheels biased");
  bias.world.speed_scale = 1.04;
  bias.world.turn_scale = 0.96;
  bias.world.turn_bias_rad_per_s = 0.01;
  add("sensor 22 cm ahead").world.sensor_ahead_m = 0.22;
  Case& hall = add("60 posts, 40 x 30 m");
  hall.world.posts = 60;
  hall.world.width_m = 40.0;
  hall.world.height_m = 30.0;
  hall.world.least_gap_m = 2.0;
  hall.world.reach_m = 10.0;
  hall.world.speed_m_per_s = 0.8;
  hall.world.way_m = 1000.0;
  Case& few = add("6 posts, 3 m reach");
  few.world.posts = 6;
  few.world.width_m = 5.0;
  few.world.height_m = 4.0;
  few.world.reach_m = 3.0;
  Case& slip = add("wheels slip");
  slip.world.speed_sigma_m_per_s = 0.05;
  slip.world.turn_sigma_rad_per_s = 0.15;
  Case& crisp = add("crisp: 5 mm, 3 mrad");
  crisp.world.range_sigma_m = 0.005;
  crisp.world.bearing_sigma_rad = 0.003;
  return all;
}

void run(const Case& one, int seeds, unsigned first) {
  std::printf("%-20s", one.name.c_str());
  double rms = 0.0, worst = 0.0, nees = 0.0, ms = 0.0, dead = 0.0, post = 0.0;
  int found = 0, landmarks = 0, posts = 0, whole = 0;
  slam::SightingNoise noise;
  double factor = 0.0;
  for (int seed = 0; seed < seeds; ++seed) {
    const unsigned number = first + static_cast<unsigned>(seed);
    const auto world =
        one.set_up_is_drawn ? drawn(one.world, one.options.set_up, number) : one.world;
    const auto drive = testing::PostSimulation(world, number).run();
    const testing::PostResult result = testing::run_posts(drive, one.options);
    rms += result.path_rms_m / seeds;
    dead += result.dead_reckoning_rms_m / seeds;
    nees += result.mean_nees / seeds;
    ms = std::max(ms, result.ms_per_scan);
    worst = std::max(worst, result.path_rms_m);
    post = std::max(post, result.worst_post_m);
    found += result.found;
    landmarks += result.landmarks;
    posts += static_cast<int>(drive.posts.size());
    whole += result.found == static_cast<int>(drive.posts.size()) &&
             result.landmarks == static_cast<int>(drive.posts.size());
    noise = result.noise;
    factor = result.noise_factor;
  }
  std::printf(
      " path %5.2f cm (worst %6.2f; wheels %4.0f), posts %4d of %4d, landmarks %4d, all and no "
      "other "
      "%2d of %2d, worst %5.1f cm, NEES %5.2f, %.3f ms; noise %.3f m %.4f rad, %.3f m %.4f rad, x "
      "%.2f\n",
      100.0 * rms, 100.0 * worst, 100.0 * dead, found, posts, landmarks, whole, seeds, 100.0 * post,
      nees, ms, noise.range_sigma_m, noise.bearing_sigma_rad, noise.move_sigma_m,
      noise.turn_sigma_rad, factor);
  std::fflush(stdout);
}

}  // namespace
}  // namespace marco

int main(int argc, char** argv) {
  const int seeds = argc > 1 ? std::atoi(argv[1]) : 20;
  const unsigned first = argc > 2 ? static_cast<unsigned>(std::atoi(argv[2])) : 1U;
  for (const auto& one : marco::cases()) marco::run(one, seeds, first);
}
