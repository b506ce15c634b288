#include "common/covariance.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <random>

namespace marco {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Axes turned at random, eigenvalues from 10^low to 10^high: a direction of which nothing is known
// beside one that is known well.
class RandomMatrices {
 public:
  RandomMatrices(double low, double high) : exponent_(low, high) {}
  Matrix3d next() {
    std::normal_distribution<double> gauss;
    const Eigen::Quaterniond turn(gauss(random_), gauss(random_), gauss(random_), gauss(random_));
    const Matrix3d axes = turn.normalized().toRotationMatrix();
    const Vector3d values(std::pow(10.0, exponent_(random_)), std::pow(10.0, exponent_(random_)),
                          std::pow(10.0, exponent_(random_)));
    const Matrix3d matrix = axes * values.asDiagonal() * axes.transpose();
    return 0.5 * (matrix + matrix.transpose());
  }

 private:
  std::mt19937 random_{7};
  std::uniform_real_distribution<double> exponent_;
};

double smallest_eigenvalue(const Matrix3d& matrix) {
  return Eigen::SelfAdjointEigenSolver<Matrix3d>(matrix, Eigen::EigenvaluesOnly).eigenvalues()[0];
}

constexpr int kCases = 20'000;

TEST(Covariance, InformationWithNoiseIsNeverIndefiniteAndNeverMoreThanTheNoiseAllows) {
  RandomMatrices matrices(-12.0, 8.0);
  const Matrix3d noise = rotated(Vector3d(4e-4, 1e-4, 3e-5).asDiagonal(), 0.7);
  const Matrix3d most = noise.inverse();
  int by_plain_inverses = 0;
  for (int i = 0; i < kCases; ++i) {
    const Matrix3d information = matrices.next();
    const Matrix3d softened = with_noise(information, noise);
    ASSERT_TRUE(is_semidefinite(softened)) << information;
    ASSERT_GE(smallest_eigenvalue(most - softened), -1e-9 * most.norm()) << information;
    ASSERT_GE(smallest_eigenvalue(information - softened),
              -1e-12 * (information.norm() + softened.norm()))
        << information;
    const Matrix3d jittered = (information + 1e-6 * Matrix3d::Identity()).inverse();
    by_plain_inverses += is_semidefinite((jittered + noise).inverse()) ? 0 : 1;
  }
  EXPECT_GT(by_plain_inverses, kCases / 100);  // what the plain way does with the same matrices
}

TEST(Covariance, InformationWithNoiseIsThatOfTheSumOfCovariances) {
  RandomMatrices matrices(-1.0, 4.0);
  const Matrix3d noise = rotated(Vector3d(0.04, 0.01, 0.02).asDiagonal(), -0.4);
  for (int i = 0; i < 100; ++i) {
    const Matrix3d information = matrices.next();
    const Matrix3d wanted = (information.inverse() + noise).inverse();
    EXPECT_LT((with_noise(information, noise) - wanted).norm(), 1e-9 * wanted.norm());
  }
  EXPECT_LT((with_noise(1e20 * Matrix3d::Identity(), noise) * noise - Matrix3d::Identity()).norm(),
            1e-9);
  EXPECT_EQ(with_noise(Matrix3d::Zero(), noise), Matrix3d::Zero());
  // What rounding has made negative is unknown.
  EXPECT_EQ(with_noise(-1e-6 * Matrix3d::Identity(), noise), Matrix3d::Zero());
}

TEST(Covariance, InvertedMatricesAreDefiniteHoweverSingularTheyWere) {
  RandomMatrices matrices(-12.0, 8.0);
  for (int i = 0; i < kCases; ++i) {
    const Matrix3d matrix = matrices.next();
    ASSERT_GT(smallest_eigenvalue(covariance_of(matrix)), 0.0) << matrix;
    const Matrix3d information = information_of(matrix);
    // But for rounding.
    ASSERT_GT(smallest_eigenvalue(information), -1e-14 * information.norm()) << matrix;
  }
  RandomMatrices good(-1.0, 3.0);
  for (int i = 0; i < 100; ++i) {
    const Matrix3d matrix = good.next();
    const Matrix3d wanted = matrix.inverse();
    EXPECT_LT((covariance_of(matrix) - wanted).norm(), 2e-5 * wanted.norm());
    EXPECT_LT((information_of(matrix) - wanted).norm(), 2e-8 * wanted.norm());
  }
  EXPECT_NEAR(covariance_of(Matrix3d::Zero())(1, 1), 1e6, 1e-3);
}

TEST(Covariance, SemidefiniteIsWhatAPoseCanHave) {
  EXPECT_TRUE(is_semidefinite(Matrix3d::Zero()));
  EXPECT_TRUE(is_semidefinite(Vector3d(1e8, 0.0, -1e-3).asDiagonal().toDenseMatrix()));
  EXPECT_FALSE(is_semidefinite(Vector3d(1e8, 0.0, -1.0).asDiagonal().toDenseMatrix()));
  EXPECT_FALSE(is_semidefinite(Vector3d(1.0, 1.0, std::nan("")).asDiagonal().toDenseMatrix()));
  Matrix3d skewed = Matrix3d::Identity();
  skewed(0, 1) = 0.1;
  EXPECT_FALSE(is_semidefinite(skewed));
}

TEST(Covariance, TheSemidefinitePartForgetsWhatIsNegative) {
  const Matrix3d good = rotated(Vector3d(5.0, 0.0, 2.0).asDiagonal(), 0.3);
  EXPECT_EQ(semidefinite_part(good), good);
  const Matrix3d poisoned = rotated(Vector3d(5.0, -4.0, 2.0).asDiagonal(), 0.3);
  EXPECT_LT((semidefinite_part(poisoned) - good).norm(), 1e-12);
}

// Oracle: Monte Carlo over small errors of both poses.
TEST(Covariance, AHeadingErrorMovesWhatLiesAheadSideways) {
  const Eigen::Matrix3d start = diagonal_covariance(0.01, 0.02);
  const Eigen::Matrix3d ahead = carried_along(start, {1, 2, 0.5}, {1, 12, 0.7});
  // 10 m along y: the heading's error moves it along x.
  EXPECT_NEAR(std::sqrt(ahead(0, 0)), std::hypot(0.01, 10 * 0.02), 1e-12);
  EXPECT_NEAR(std::sqrt(ahead(1, 1)), 0.01, 1e-12);
  EXPECT_NEAR(ahead(0, 2), -10 * 0.02 * 0.02, 1e-12);
}

TEST(Covariance, RotatedMatricesAreThoseOfTheTurnedFrame) {
  const Eigen::Matrix3d covariance = Eigen::Vector3d(4.0, 1.0, 0.25).asDiagonal();
  const Eigen::Matrix3d turned = rotated(covariance, std::numbers::pi / 2);
  EXPECT_NEAR(turned(0, 0), 1.0, 1e-12);
  EXPECT_NEAR(turned(1, 1), 4.0, 1e-12);
  EXPECT_NEAR(turned(2, 2), 0.25, 1e-12);
}

// A frame 2 m to the left sees a turn of the other one as a move along x.
TEST(Covariance, TransformedIsTheAdjoint) {
  const Eigen::Matrix3d error = Eigen::Vector3d(0.0, 0.0, 0.01).asDiagonal();
  const Eigen::Matrix3d seen = transformed(error, {0, 2, 0});
  EXPECT_NEAR(seen(0, 0), 0.04, 1e-12);
  EXPECT_NEAR(seen(1, 1), 0.0, 1e-12);
  EXPECT_NEAR(seen(0, 2), 0.02, 1e-12);
}

// P(chi2 of 3 degrees of freedom > q) = erfc(sqrt(q/2)) + sqrt(2 q / pi) exp(-q/2).
TEST(Covariance, TheQuantilesAreThoseOfChiSquare) {
  const auto beyond = [](double q) {
    return std::erfc(std::sqrt(q / 2)) + std::sqrt(2 * q / std::numbers::pi) * std::exp(-q / 2);
  };
  EXPECT_NEAR(beyond(kChi2Dof3Quantile999), 0.001, 1e-6);
  EXPECT_NEAR(beyond(kChi2Dof3Quantile75), 0.25, 1e-3);
}

}  // namespace
}  // namespace marco
