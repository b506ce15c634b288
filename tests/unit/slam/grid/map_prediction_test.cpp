#include "slam/grid/map_prediction.hpp"

#include <gtest/gtest.h>

#include "slam/grid/occupancy_grid.hpp"
#include "tests/support/flat_world.hpp"

namespace marco::slam {
namespace {

GridMap map_of_room() {
  const testing::FlatWorld room = testing::small_room();
  OccupancyGrid grid;
  for (int i = 0; i < 12; ++i) {
    const Pose2 pose{0.0, 0.0, i * 0.5};
    for (int repeat = 0; repeat < 3; ++repeat) grid.insert(pose * room.hits(pose), {0, 0});
  }
  return grid.to_map();
}

TEST(MapPrediction, AMapPredictsItsOwnRoomToACell) {
  const Pose2 pose{0.5, 0.2, 0.3};
  const PredictionQuality quality =
      judge_prediction(map_of_room(), {{pose, testing::small_room().hits(pose)}});
  EXPECT_GT(quality.beams, 200);
  EXPECT_LT(quality.median_error_m, 0.05);
  EXPECT_LT(quality.through_walls, 0.02);
}

TEST(MapPrediction, BeamsThroughAndShortOfWallsAreTold) {
  const Pose2 pose{0.0, 0.0, 0.0};
  const Points2 hits = testing::small_room().hits(pose);
  EXPECT_GT(judge_prediction(map_of_room(), {{pose, 1.3 * hits}}).through_walls, 0.9);
  EXPECT_GT(judge_prediction(map_of_room(), {{pose, 0.8 * hits}}).short_of_walls, 0.9);
}

TEST(MapPrediction, NothingKnownIsNothingJudged) {
  EXPECT_EQ(judge_prediction({}, {{{}, testing::small_room().hits({})}}).beams, 0);
  EXPECT_EQ(judge_prediction(map_of_room(), {}).beams, 0);
}

}  // namespace
}  // namespace marco::slam
