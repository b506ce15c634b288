#include "tests/experiments/figures/matching_figures.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <functional>
#include <utility>

#include "lcm_tools/base/check.hpp"
#include "slam/matching/nlm_matcher.hpp"
#include "viewer/film.hpp"
#include "viewer/image_io.hpp"
#include "viewer/map_picture.hpp"

namespace marco {
namespace {

constexpr std::size_t kPanels = 4;  // odometry, and each scan with the one before three ways
constexpr std::size_t kFigures = 9;

slam::NlmMatcher matcher_of(const std::string& estimator, bool calculated_points) {
  slam::NlmOptions options;
  options.estimator = estimator;
  options.calculated_points = calculated_points;
  return slam::NlmMatcher(options);
}

Points2 joined(const Points2& all, const Points2& more) {
  Points2 result(2, all.cols() + more.cols());
  result << all, more;
  return result;
}

/// @param match  the pose of scan `at`, from those before and a guess
using Match = std::function<Pose2(std::size_t at, const std::vector<Pose2>&, const Pose2& guess)>;

MatchedWalk walk_by(const std::string& name,
                    const std::vector<WalkScan>& scans,
                    const Match& match) {
  MatchedWalk walk;
  walk.name = name;
  walk.world_from_robot.emplace_back();
  const std::clock_t begin = std::clock();
  for (std::size_t at = 1; at < scans.size(); ++at) {
    const Pose2 step = between(scans[at - 1].odom_from_robot, scans[at].odom_from_robot);
    walk.world_from_robot.push_back(
        match(at, walk.world_from_robot, walk.world_from_robot.back() * step));
  }
  const double cpu_s = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  walk.ms_per_match = 1e3 * cpu_s / static_cast<double>(std::max<std::size_t>(1, scans.size() - 1));
  double squares = 0.0, count = 0.0;
  for (std::size_t at = 0; at < scans.size(); ++at) {
    if (!scans[at].world_from_robot || !scans.front().world_from_robot) continue;
    const Pose2 truth = between(*scans.front().world_from_robot, *scans[at].world_from_robot);
    const double off_m = (walk.world_from_robot[at].translation_m() - truth.translation_m()).norm();
    squares += off_m * off_m;
    count += 1.0;
    walk.max_m = std::max(walk.max_m, off_m);
  }
  walk.rms_m = count > 0.0 ? std::sqrt(squares / count) : 0.0;
  return walk;
}

MatchedWalk walk_with_before(const std::string& name,
                             const std::vector<WalkScan>& scans,
                             const slam::NlmMatcher& matcher) {
  return walk_by(
      name, scans, [&](std::size_t at, const std::vector<Pose2>& poses, const Pose2& guess) {
        const slam::NlmTarget before(scans[at - 1].points_in_robot);
        const slam::MatchResult found =
            matcher.match(before, scans[at].points_in_robot, between(poses.back(), guess));
        return found.status == slam::MatchStatus::no_overlap
                   ? guess
                   : poses.back() * found.target_from_source;
      });
}

MatchedWalk walk_with_all(const std::string& name,
                          const std::vector<WalkScan>& scans,
                          const slam::NlmMatcher& matcher) {
  Points2 history(2, 0);
  return walk_by(
      name, scans, [&](std::size_t at, const std::vector<Pose2>& poses, const Pose2& guess) {
        history = joined(history, poses.back() * scans[at - 1].points_in_robot);
        const slam::MatchResult found =
            matcher.match(slam::NlmTarget(history), scans[at].points_in_robot, guess);
        return found.status == slam::MatchStatus::no_overlap ? guess : found.target_from_source;
      });
}

viewer::PointsItem points_item(const Points2& points, viewer::Rgb color, const std::string& label) {
  viewer::PointsItem item;
  item.color = color;
  item.label = label;
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    item.points_m.emplace_back(static_cast<float>(points(0, i)), static_cast<float>(points(1, i)),
                               0.0F);
  }
  return item;
}

viewer::MapPictureOptions panel_options() {
  viewer::MapPictureOptions options;
  options.long_side_px = 620.0;
  options.point_radius_px = 1.0;
  return options;
}

viewer::Picture panel(const std::vector<WalkScan>& scans, const MatchedWalk& walk, std::size_t at) {
  viewer::Scene scene;
  Points2 map(2, 0);
  for (std::size_t i = 0; i <= at; ++i) {
    map = joined(map, walk.world_from_robot[i] * scans[i].points_in_robot);
  }
  const Pose2& pose = walk.world_from_robot[at];
  viewer::RaysItem rays;
  rays.origin_m = {pose.x_m, pose.y_m, 0.0};
  const Points2 hits = pose * scans[at].points_in_robot;
  for (Eigen::Index i = 0; i < hits.cols(); i += 4) {
    rays.ends_m.emplace_back(static_cast<float>(hits(0, i)), static_cast<float>(hits(1, i)), 0.0F);
  }
  scene.rays.push_back(std::move(rays));
  scene.points.push_back(points_item(map, viewer::palette::kOccupied, walk.name));
  scene.robots.push_back({pose});
  return viewer::draw_map(scene, panel_options()).picture;
}

// The step between two scans at which least squares errs most.
std::size_t worst_pair(const std::vector<WalkScan>& scans, const MatchedWalk& walk) {
  std::size_t worst = 1;
  double worst_m = -1.0;
  for (std::size_t at = 1; at < scans.size(); ++at) {
    if (!scans[at].world_from_robot || !scans[at - 1].world_from_robot) continue;
    const Pose2 truth = between(*scans[at - 1].world_from_robot, *scans[at].world_from_robot);
    const Pose2 found = between(walk.world_from_robot[at - 1], walk.world_from_robot[at]);
    const double off_m = between(truth, found).translation_m().norm();
    if (off_m > worst_m) {
      worst_m = off_m;
      worst = at;
    }
  }
  return worst;
}

/// @param within_m  only what lies so near the middle of the newer scan's points is drawn
viewer::Picture pair_panel(const std::vector<WalkScan>& scans,
                           const MatchedWalk& walk,
                           std::size_t at,
                           double within_m) {
  const Pose2 step = between(walk.world_from_robot[at - 1], walk.world_from_robot[at]);
  const Points2& older = scans[at - 1].points_in_robot;
  const Points2 newer = step * scans[at].points_in_robot;
  const Eigen::Vector2d middle = older.col(older.cols() / 2);
  const auto near = [&](const Points2& points) {
    Points2 kept(2, points.cols());
    Eigen::Index count = 0;
    for (Eigen::Index i = 0; i < points.cols(); ++i) {
      const bool inside = (points.col(i) - middle).cwiseAbs().maxCoeff() <= within_m;
      if (inside) kept.col(count++) = points.col(i);
    }
    kept.conservativeResize(2, count);
    return kept;
  };
  viewer::Scene scene;
  scene.points.push_back(points_item(near(older), viewer::palette::kTruth, "the scan before"));
  scene.points.push_back(points_item(near(newer), viewer::palette::kEstimate, walk.name));
  viewer::MapPictureOptions options = panel_options();
  options.point_radius_px = 2.0;
  options.margin_m = 0.1;
  return viewer::draw_map(scene, options).picture;
}

// Ways that err differently make maps of different extents: paper is added right and below.
std::vector<viewer::Picture> of_one_size(std::vector<viewer::Picture> pictures) {
  int width_px = 0, height_px = 0;
  for (const viewer::Picture& picture : pictures) {
    width_px = std::max(width_px, picture.width_px);
    height_px = std::max(height_px, picture.height_px);
  }
  for (viewer::Picture& picture : pictures) {
    viewer::Picture larger(width_px, height_px, viewer::palette::kPaper);
    for (int row = 0; row < picture.height_px; ++row) {
      std::copy_n(picture.pixels.begin() + std::ptrdiff_t{row} * picture.width_px, picture.width_px,
                  larger.pixels.begin() + std::ptrdiff_t{row} * width_px);
    }
    picture = std::move(larger);
  }
  return pictures;
}

}  // namespace

std::vector<MatchedWalk> match_walks(const std::vector<WalkScan>& scans) {
  require(scans.size() >= 2, "match_walks: fewer than two scans");
  return {
      walk_by("odometry", scans,
              [](std::size_t, const std::vector<Pose2>&, const Pose2& guess) { return guess; }),
      walk_with_before("least squares", scans, matcher_of("least_squares", false)),
      walk_with_before("Lorentzian", scans, matcher_of("lorentzian", false)),
      walk_with_before("Lorentzian, calculated points", scans, matcher_of("lorentzian", true)),
      walk_with_all("Lorentzian, calculated points, all scans before", scans,
                    matcher_of("lorentzian", true)),
  };
}

std::vector<Figure> draw_matching_figures(const std::filesystem::path& folder,
                                          const std::vector<WalkScan>& scans,
                                          const std::vector<MatchedWalk>& walks) {
  require(scans.size() >= 2 && walks.size() >= kPanels,
          "draw_matching_figures: fewer than two scans, or walks missing");
  std::filesystem::create_directories(folder);
  std::vector<Figure> figures;
  const auto write = [&](const std::string& file, const std::string& what,
                         const std::vector<viewer::Picture>& panels) {
    viewer::write_png(viewer::contact_sheet(of_one_size(panels), 2), (folder / file).string());
    figures.push_back({file, what});
  };
  for (std::size_t i = 0; i < kFigures; ++i) {
    const auto scan_of = [&](std::size_t figure) {
      return figure * (scans.size() - 1) / (kFigures - 1);
    };
    const std::size_t at = scan_of(i);
    if (i > 0 && at == scan_of(i - 1)) continue;  // fewer scans than figures
    std::vector<viewer::Picture> panels;
    for (std::size_t way = 0; way < kPanels; ++way) panels.push_back(panel(scans, walks[way], at));
    char file[48];
    std::snprintf(file, sizeof file, "5_03_to_09_scan_%03d.png", static_cast<int>(at));
    write(file, "5.3-5.9, scan " + std::to_string(at) + " and the map so far, by four methods",
          panels);
  }
  const std::size_t pair = worst_pair(scans, walks[1]);
  const std::string what = "one pair of scans, least squares against the Lorentzian";
  constexpr double kAllM = 1e3, kNearM = 1.0;
  write("5_10_pair.png", "5.10, " + what,
        {pair_panel(scans, walks[1], pair, kAllM), pair_panel(scans, walks[2], pair, kAllM)});
  write("5_11_pair_closer.png", "5.11, closer",
        {pair_panel(scans, walks[1], pair, kNearM), pair_panel(scans, walks[2], pair, kNearM)});
  return figures;
}

}  // namespace marco
