#include "tests/experiments/figures/matching_figures.hpp"

#include <gmock/gmock.h>

#include <filesystem>
#include <random>

#include "tests/support/flat_world.hpp"
#include "viewer/image_io.hpp"

namespace marco {
namespace {

using ::testing::SizeIs;

// Along the long side of a room with odometry that is 10 % long and drifts aside.
std::vector<WalkScan> walk_through_a_room() {
  marco::testing::FlatWorld world;
  world.add_box(-5, -3, 5, 3);
  world.add_box(-1, 1, 0.5, 2);
  world.add_box(2, -2.5, 3, -1.5);
  std::mt19937 random(8);
  std::vector<WalkScan> scans;
  for (int i = 0; i < 7; ++i) {
    const Pose2 truth{-3.0 + 0.5 * i, -0.5, 0.1};
    const Pose2 odometry{0.55 * i, 0.03 * i, 0.02 * i};
    scans.push_back({world.hits(truth, 0.01, &random), odometry, truth});
  }
  return scans;
}

TEST(MatchingFigures, TheLorentzianFollowsTheRoomWhereOdometryDoesNot) {
  const std::vector<MatchedWalk> walks = match_walks(walk_through_a_room());
  ASSERT_THAT(walks, SizeIs(5));
  EXPECT_GT(walks[0].rms_m, 0.2) << walks[0].name;
  EXPECT_LT(walks[2].rms_m, 0.03) << walks[2].name;
  EXPECT_LT(walks[3].rms_m, 0.03) << walks[3].name;
  EXPECT_LT(walks[4].rms_m, 0.02) << walks[4].name;
  for (const MatchedWalk& walk : walks) EXPECT_THAT(walk.world_from_robot, SizeIs(7));
  EXPECT_THROW(match_walks({}), std::invalid_argument);
}

TEST(MatchingFigures, AreNineScansAtMostByFourMethodsAndAPairTwice) {
  const std::filesystem::path folder =
      std::filesystem::path(::testing::TempDir()) / "marco_matching_figures";
  std::filesystem::remove_all(folder);
  const std::vector<WalkScan> scans = walk_through_a_room();
  const std::vector<MatchedWalk> walks = match_walks(scans);
  const auto figures = draw_matching_figures(folder, scans, walks);
  ASSERT_THAT(figures, SizeIs(7 + 2));
  const auto picture = [&](std::size_t figure) {
    return viewer::read_picture((folder / figures[figure].file).string());
  };
  // Of two by two panels, the upper left is odometry's map, the lower right the matched one. Scans
  // that do not fit draw the same walls at several places.
  const viewer::Picture last = picture(6);
  const auto walls_px = [&](int column, int row) {
    int count = 0;
    for (int y = row * last.height_px / 2; y < (row + 1) * last.height_px / 2; ++y) {
      for (int x = column * last.width_px / 2; x < (column + 1) * last.width_px / 2; ++x) {
        const viewer::Rgb& pixel = last.pixels[static_cast<std::size_t>(y * last.width_px + x)];
        count += pixel.blue < 100 ? 1 : 0;
      }
    }
    return count;
  };
  EXPECT_GT(walls_px(1, 1), 1000);
  EXPECT_GT(walls_px(0, 0), 1.25 * walls_px(1, 1));
  // One pair of scans, and a part of it.
  for (const std::size_t pair : {7U, 8U}) EXPECT_GT(picture(pair).width_px, 600);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace marco
