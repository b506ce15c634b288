#include "slam/matching/line_fit.hpp"

#include <gtest/gtest.h>

#include <random>

#include "slam/matching/calculated_points.hpp"
#include "slam/matching/estimator.hpp"

namespace marco::slam {
namespace {

double tilt_deg(const Line& line) {
  return rad_to_deg(std::atan(line.direction.y() / line.direction.x()));
}

// Figure 3.7 of the thesis: six points, one an outlier.
TEST(LineFit, OneOutlierInSixMovesLeastSquaresAndPrincipalComponentsNotLorentzian) {
  Points2 points(2, 6);
  points << 0.0, 1.0, 2.0, 3.0, 4.0, 5.0,  //
      0.0, 0.0, 0.0, 0.0, 4.0, 0.0;
  EXPECT_GT(std::abs(tilt_deg(fit_least_squares(points))), 10.0);
  EXPECT_GT(std::abs(tilt_deg(fit_principal_components(points))), 10.0);
  // The outlier's pull: influence 2/4 m against five points of curvature 1/sigma^2 = 100 on a 5 m
  // base: some 1e-3 rad.
  const Line robust = fit_lorentzian(points, 0.1);
  EXPECT_LT(std::abs(tilt_deg(robust)), 0.2);
  EXPECT_LT(robust.distance_m({2.0, 0.0}), 0.005);
}

TEST(LineFit, AllThreeAgreeOnPointsOfALine) {
  Points2 points(2, 5);
  points << 100.0, 101.0, 102.5, 104.0, 105.0, 250.0, 250.5, 251.25, 252.0, 252.5;
  for (const Line& line : {fit_least_squares(points), fit_lorentzian(points, 0.05),
                           fit_principal_components(points)}) {
    EXPECT_NEAR(std::tan(deg_to_rad(tilt_deg(line))), 0.5, 1e-9);
    EXPECT_LT(line.rms_m, 1e-6);  // root of rounding in squares of 5 m
    EXPECT_LT((line.project({100.0, 251.25}) - Eigen::Vector2d(100.5, 250.25)).norm(), 1e-6);
  }
}

TEST(LineFit, PrincipalComponentsFitSteepLinesWhereYOnXCannot) {
  Points2 points(2, 3);
  points << 2.0, 2.0, 2.0, 0.0, 1.0, 5.0;
  EXPECT_NEAR(std::abs(fit_principal_components(points).direction.y()), 1.0, 1e-12);
  EXPECT_THROW(fit_least_squares(points), std::invalid_argument);
  EXPECT_THROW(fit_principal_components(points.leftCols(1)), std::invalid_argument);
}

TEST(LineFit, SumsForgetARemovedPoint) {
  LineSums sums;
  for (int i = 0; i < 4; ++i) sums.add({1.0 * i, 2.0 * i});
  sums.add({9.0, -3.0});
  sums.remove({9.0, -3.0});
  EXPECT_EQ(sums.size(), 4);
  EXPECT_NEAR(sums.line().direction.y() / sums.line().direction.x(), 2.0, 1e-12);
}

TEST(Estimator, InfluenceAndCurvatureAreTheDerivativesOfRho) {
  for (const char* name : {"least_squares", "lorentzian", "geman_mcclure"}) {
    const Estimator estimator{estimator_kind(name), 0.3};
    for (const double e : {-2.0, -0.3, 0.0, 0.1, 0.9}) {
      const double h = 1e-4;  // central differences: error h^2 times a third derivative of ~100
      EXPECT_NEAR(estimator.influence(e), (estimator.rho(e + h) - estimator.rho(e - h)) / (2 * h),
                  1e-5);
      EXPECT_NEAR(estimator.curvature(e),
                  (estimator.influence(e + h) - estimator.influence(e - h)) / (2 * h), 1e-4);
      EXPECT_NEAR(estimator.weight(e) * e, estimator.influence(e), 1e-12);
    }
  }
  EXPECT_THROW(estimator_kind("median"), std::invalid_argument);
}

TEST(CalculatedPoints, ProjectsOnWallsAndKeepsRawPointsAtCornersAndGaps) {
  Points2 points(2, 21);  // 11 points up to the corner (1, 0), ten up from it
  for (int i = 0; i <= 10; ++i) points.col(i) << 0.1 * i, 0.0;
  for (int i = 1; i <= 10; ++i) points.col(10 + i) << 1.0, 0.1 * i;
  const CalculatedPoints calculated(points);
  const auto on_wall = calculated.partner({0.52, 0.3}, 5);
  ASSERT_NE(on_wall.line, nullptr);
  EXPECT_LT((on_wall.point - Eigen::Vector2d(0.52, 0.0)).norm(), 1e-9);
  EXPECT_EQ(calculated.line(10), nullptr);
  EXPECT_EQ(calculated.partner({1.2, -0.1}, 10).point, points.col(10));
  EXPECT_NE(calculated.line(0), nullptr);
  points.col(6) << 0.6, 3.0;  // one beam past the wall: its neighbours start no line
  EXPECT_EQ(CalculatedPoints(points).line(5), nullptr);
  EXPECT_NE(CalculatedPoints(points).line(3), nullptr);
  EXPECT_EQ(CalculatedPoints(points.leftCols(2)).line(0), nullptr);
}

}  // namespace
}  // namespace marco::slam
