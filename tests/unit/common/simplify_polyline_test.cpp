#include "common/simplify_polyline.hpp"

#include <gtest/gtest.h>

namespace marco {
namespace {

using Points = std::vector<Eigen::Vector2d>;

TEST(SimplifyPolyline, KeepsCornersAndEnds) {
  const Points points{{0, 0}, {1, 0.05}, {2, -0.05}, {3, 0}, {3, 1}, {3.05, 2}, {3, 3}};
  EXPECT_EQ(simplify_polyline(points, 0.1), (Points{{0, 0}, {3, 0}, {3, 3}}));
  EXPECT_EQ(simplify_polyline(points, 0.03).size(), points.size() - 1) << "but {3, 1}";
}

TEST(SimplifyPolyline, ARingIsNotLost) {
  const Points ring{{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0, 0}};
  EXPECT_EQ(simplify_polyline(ring, 0.1).size(), ring.size());
}

TEST(SimplifyPolyline, TakesAPointAndNothing) {
  EXPECT_TRUE(simplify_polyline({}, 0.1).empty());
  EXPECT_EQ(simplify_polyline(Points{{2, 3}}, 0.1), (Points{{2, 3}}));
}

}  // namespace
}  // namespace marco
