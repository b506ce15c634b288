#include <gtest/gtest.h>

#include <Eigen/Core>
#include <functional>
#include <random>

#include "slam/line_slam/ekf/motion.hpp"
#include "slam/line_slam/ekf/wall_filter.hpp"
#include "slam/line_slam/ekf/wall_observation.hpp"

namespace marco::slam {
namespace {

// Central differences with step 1e-6: error about 1e-12 (curvature) + 1e-10 (rounding).
constexpr double kTolerance = 1e-8;

Eigen::MatrixXd numeric(const std::function<Eigen::VectorXd(const Eigen::VectorXd&)>& f,
                        const Eigen::VectorXd& at) {
  constexpr double kStep = 1e-6;
  const Eigen::Index rows = f(at).size();
  Eigen::MatrixXd jacobian(rows, at.size());
  for (Eigen::Index i = 0; i < at.size(); ++i) {
    Eigen::VectorXd plus = at, minus = at;
    plus(i) += kStep;
    minus(i) -= kStep;
    jacobian.col(i) = (f(plus) - f(minus)) / (2.0 * kStep);
  }
  return jacobian;
}

const Eigen::Vector3d kRobot(1.2, -0.7, 0.9);
const Eigen::Vector4d kWall(3.0, 1.0, 2.5, 4.0);

ObservedWall observed_wall() {
  ObservedWall wall;
  wall.direction_rad = 1.1;
  wall.center_m = {2.5, 0.4};
  wall.start_m = wall.center_m - 1.0 * wall.along();
  wall.end_m = wall.center_m + 1.5 * wall.along();
  wall.across_sigma_m = 0.004;
  wall.direction_sigma_rad = 0.003;
  wall.start_sigma_m = 0.02;
  wall.end_sigma_m = 0.03;
  wall.num_points = 30;
  return wall;
}

TEST(Jacobians, MotionAgainstCentralDifferences) {
  for (const Pose2& step : {Pose2{0.3, 0.1, 0.2}, Pose2{-0.3, 0.0, 0.0}, Pose2{0.0, 0.0, -0.4}}) {
    const auto f = [&](const Eigen::VectorXd& x) -> Eigen::VectorXd {
      return moved(Pose2::from_vector(x.head<3>()), step).vector();
    };
    const Eigen::Vector3d after = f(kRobot);
    const Eigen::Matrix3d f_r = motion_jacobian(kRobot.head<2>(), after.head<2>());
    EXPECT_LT((f_r - numeric(f, kRobot)).cwiseAbs().maxCoeff(), kTolerance);
  }
}

TEST(Jacobians, WallSeenFromTheRobotAgainstCentralDifferences) {
  Eigen::Matrix<double, 4, 3> by_robot;
  Eigen::Matrix4d by_wall;
  seen_from_robot_jacobians(kRobot, kWall, by_robot, by_wall);
  const auto of_robot = [](const Eigen::VectorXd& x) -> Eigen::VectorXd {
    return seen_from_robot(x.head<3>(), kWall);
  };
  const auto of_wall = [](const Eigen::VectorXd& x) -> Eigen::VectorXd {
    return seen_from_robot(kRobot, x.head<4>());
  };
  EXPECT_LT((by_robot - numeric(of_robot, kRobot)).cwiseAbs().maxCoeff(), kTolerance);
  EXPECT_LT((by_wall - numeric(of_wall, kWall)).cwiseAbs().maxCoeff(), kTolerance);
}

// As kWall is seen from kRobot, less a bit at its ends: where nothing is left to correct across it,
// the rows are exact.
ObservedWall observed_where_it_is() {
  const Eigen::Vector4d seen = seen_from_robot(kRobot, kWall);
  ObservedWall wall = observed_wall();
  const Eigen::Vector2d way = seen.tail<2>() - seen.head<2>();
  wall.direction_rad = std::atan2(way.y(), way.x());
  wall.center_m = 0.5 * (seen.head<2>() + seen.tail<2>());
  wall.start_m = seen.head<2>() + 0.03 * wall.along();
  wall.end_m = seen.tail<2>() - 0.02 * wall.along();
  return wall;
}

TEST(Jacobians, WallRowsAgainstCentralDifferences) {
  const auto rows_at = [](const Eigen::VectorXd& x) {
    return wall_rows(observed_where_it_is(),
                     {x.head<3>(), x.head<3>(), x.tail<4>(), x.tail<4>(), 1}, {true, true});
  };
  Eigen::VectorXd at(7);
  at << kRobot, kWall;
  const SparseRows rows = rows_at(at);
  Eigen::MatrixXd h(4, 7);
  h << rows.jacobian.leftCols<3>(), rows.jacobian.middleCols<4>(4);
  const auto innovation = [&](const Eigen::VectorXd& x) -> Eigen::VectorXd {
    return rows_at(x).innovation;
  };
  // The innovation is what was measured minus what is predicted: the sign turns.
  EXPECT_LT((h + numeric(innovation, at)).cwiseAbs().maxCoeff(), kTolerance);
}

// Its error would be in H and in the innovation at once: their product, always of one sign, dragged
// the robot along a wall by half a metre.
TEST(Jacobians, RowsDoNotDependOnTheObservedDirection) {
  ObservedWall turned = observed_where_it_is();
  turned.direction_rad += 0.02;
  const WallContext at{kRobot, kRobot, kWall, kWall, 1};
  const SparseRows straight = wall_rows(observed_where_it_is(), at, {true, true});
  const SparseRows crooked = wall_rows(turned, at, {true, true});
  EXPECT_EQ(straight.jacobian, crooked.jacobian);
  EXPECT_GT((straight.innovation - crooked.innovation).head<2>().norm(), 0.01);
}

// Turning and moving robot and map together must stay invisible to every row (first estimates).
TEST(Jacobians, RowsSeeNothingOfAMoveOfTheWholeWorld) {
  const Eigen::Vector3d first_robot = kRobot + Eigen::Vector3d(0.1, -0.05, 0.02);
  const Eigen::Vector4d first_wall = kWall + Eigen::Vector4d(0.05, 0.02, -0.1, 0.04);
  const SparseRows rows =
      wall_rows(observed_wall(), {kRobot, first_robot, kWall, first_wall, 1}, {true, true});
  Eigen::MatrixXd move(8, 3);  // robot block (x y theta -), wall block; by x, y, turn
  move << 1, 0, -first_robot.y(), 0, 1, first_robot.x(), 0, 0, 1, 0, 0, 0,  //
      1, 0, -first_wall(1), 0, 1, first_wall(0), 1, 0, -first_wall(3), 0, 1, first_wall(2);
  EXPECT_LT((rows.jacobian.leftCols<8>() * move).cwiseAbs().maxCoeff(), 1e-12);
}

// 200 000 draws: a sample covariance is good to about 1/sqrt(100 000) of its entries' size.
constexpr int kDraws = 200000;
constexpr double kMonteCarlo = 0.02;

TEST(Jacobians, CovarianceOfANewWallAgainstMonteCarlo) {
  WallFilterOptions options;
  options.start_sigma_m = 0.02;
  options.start_sigma_rad = 0.01;
  options.across_floor_m = 0.0;
  options.direction_floor_rad = 0.0;
  WallFilter filter(options, Pose2::from_vector(kRobot));
  const ObservedWall seen = observed_wall();
  const std::size_t index = filter.add(seen);
  const int block = filter.wall(index).block;
  Eigen::Matrix<double, 7, 7> predicted;
  predicted << filter.robot_covariance(), filter.state().covariance(0, block).topRows<3>(),
      filter.state().covariance(block, 0).leftCols<3>(), filter.state().covariance(block, block);

  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  Eigen::Matrix<double, 7, 1> mean = Eigen::Matrix<double, 7, 1>::Zero();
  Eigen::Matrix<double, 7, 7> sum = Eigen::Matrix<double, 7, 7>::Zero();
  for (int i = 0; i < kDraws; ++i) {
    const Pose2 robot{kRobot.x() + 0.02 * normal(random), kRobot.y() + 0.02 * normal(random),
                      kRobot.z() + 0.01 * normal(random)};
    const double offset_m = seen.across_sigma_m * normal(random);
    const double turn_rad = seen.direction_sigma_rad * normal(random);
    const Eigen::Vector2d u(std::cos(seen.direction_rad + turn_rad),
                            std::sin(seen.direction_rad + turn_rad));
    const Eigen::Vector2d center = seen.center_m + offset_m * Eigen::Vector2d(-u.y(), u.x());
    Eigen::Matrix<double, 7, 1> x;
    x << robot.vector(),
        robot * Eigen::Vector2d(center + (-1.0 + seen.start_sigma_m * normal(random)) * u),
        robot * Eigen::Vector2d(center + (1.5 + seen.end_sigma_m * normal(random)) * u);
    x -= (Eigen::Matrix<double, 7, 1>() << kRobot, filter.wall_mean(index)).finished();
    mean += x;
    sum += x * x.transpose();
  }
  mean /= kDraws;
  const Eigen::Matrix<double, 7, 7> sampled = sum / kDraws - mean * mean.transpose();
  for (Eigen::Index i = 0; i < 7; ++i) {
    for (Eigen::Index j = 0; j < 7; ++j) {
      const double scale = std::sqrt(predicted(i, i) * predicted(j, j));
      EXPECT_NEAR(sampled(i, j), predicted(i, j), kMonteCarlo * scale) << i << "," << j;
    }
  }
}

TEST(Jacobians, InnovationCovarianceAgainstMonteCarlo) {
  const ObservedWall seen = observed_wall();
  const Pose2 robot = Pose2::from_vector(kRobot);
  Eigen::Vector4d wall;
  wall << robot * seen.start_m, robot * seen.end_m;
  EkfState state(kRobot, Eigen::Vector3d(4e-4, 4e-4, 1e-4).asDiagonal());
  const Eigen::Matrix4d prior = Eigen::Vector4d(1e-4, 2e-4, 3e-4, 4e-4).asDiagonal();
  const int block = state.append(wall, wall, Eigen::Matrix<double, 4, 3>::Zero(), prior);
  const SparseRows rows = wall_rows(seen, {kRobot, kRobot, wall, wall, block}, {true, true});
  const SparseRows::Square predicted = state.innovation_covariance(rows);

  std::mt19937 random(4);
  std::normal_distribution<double> normal;
  Eigen::Matrix4d sum = Eigen::Matrix4d::Zero();
  for (int i = 0; i < kDraws; ++i) {
    const Eigen::Vector3d true_robot =
        kRobot +
        Eigen::Vector3d(0.02 * normal(random), 0.02 * normal(random), 0.01 * normal(random));
    Eigen::Vector4d true_wall = wall;
    for (Eigen::Index k = 0; k < 4; ++k) true_wall(k) += std::sqrt(prior(k, k)) * normal(random);
    const Eigen::Vector4d ends = seen_from_robot(true_robot, true_wall);
    // What a scan says of this wall: a line through it with errors of its own.
    ObservedWall noisy = seen;
    const Eigen::Vector2d way = ends.tail<2>() - ends.head<2>();
    noisy.direction_rad = std::atan2(way.y(), way.x()) + seen.direction_sigma_rad * normal(random);
    const Eigen::Vector2d u = way.normalized();
    noisy.center_m = ends.head<2>() + u * u.dot(seen.center_m - ends.head<2>()) +
                     seen.across_sigma_m * normal(random) * Eigen::Vector2d(-u.y(), u.x());
    noisy.start_m = ends.head<2>() + seen.start_sigma_m * normal(random) * u;
    noisy.end_m = ends.tail<2>() + seen.end_sigma_m * normal(random) * u;
    const SparseRows drawn = wall_rows(noisy, {kRobot, kRobot, wall, wall, block}, {true, true});
    sum += drawn.innovation * drawn.innovation.transpose();
  }
  for (Eigen::Index i = 0; i < 4; ++i) {
    for (Eigen::Index j = 0; j < 4; ++j) {
      const double scale = std::sqrt(predicted(i, i) * predicted(j, j));
      EXPECT_NEAR(sum(i, j) / kDraws, predicted(i, j), kMonteCarlo * scale) << i << "," << j;
    }
  }
}

TEST(MotionNoise, HasFloorsAndIsTheSameForwardsAndBackwards) {
  const MotionNoiseOptions options;
  const Eigen::Matrix3d ahead = motion_noise(options, 0.0, {1.0, 0.0, 0.0});
  const Eigen::Matrix3d back = motion_noise(options, 0.0, {-1.0, 0.0, 0.0});
  EXPECT_LT((ahead - back).cwiseAbs().maxCoeff(), 1e-15);
  EXPECT_GE(ahead(1, 1), options.floor_m * options.floor_m);
  EXPECT_GE(ahead(2, 2), options.floor_rad * options.floor_rad);
  EXPECT_EQ(motion_noise(options, 0.3, {}), Eigen::Matrix3d::Zero());
}

// A wall is added where the corrected robot sees it, but linearized where the robot was predicted:
// else the filter would believe that it had measured its heading.
TEST(Jacobians, ANewWallIsLinearizedAtTheFirstEstimate) {
  WallFilterOptions options;
  options.start_sigma_m = 0.2;
  options.start_sigma_rad = 0.1;
  WallFilter filter(options, Pose2::from_vector(kRobot));
  ObservedWall seen = observed_wall();
  filter.add(seen);
  filter.predict(Pose2{1.0, 0.0, 0.1}, Eigen::Vector3d(0.04, 0.04, 0.01).asDiagonal());
  seen.center_m += 0.3 * seen.across();
  filter.correct({seen}, {WallMatch{0, 0.0}});
  const Eigen::Vector2d first_m = filter.state().first_estimate(0).head<2>();
  ASSERT_GT((filter.world_from_robot().translation_m() - first_m).norm(), 0.05);
  const std::size_t index = filter.add(observed_wall());
  const Eigen::Vector4d mean = filter.wall_mean(index);
  Eigen::Matrix<double, 4, 3> by_robot;
  by_robot << 1, 0, -(mean(1) - first_m.y()), 0, 1, mean(0) - first_m.x(),  //
      1, 0, -(mean(3) - first_m.y()), 0, 1, mean(2) - first_m.x();
  const Eigen::Matrix<double, 4, 3> with_robot =
      filter.state().covariance(filter.wall(index).block, 0).leftCols<3>();
  EXPECT_LT((with_robot - by_robot * filter.robot_covariance()).cwiseAbs().maxCoeff(), 1e-12);
}

// Both offsets come from one line: its error across moves them together, its direction's apart.
TEST(Jacobians, TheTwoOffsetsOfALineAreCorrelated) {
  const ObservedWall seen = observed_where_it_is();
  const SparseRows rows = wall_rows(seen, {kRobot, kRobot, kWall, kWall, 1}, {});
  const Eigen::Vector4d ends = seen_from_robot(kRobot, kWall);
  const double s = seen.along().dot(ends.head<2>() - seen.center_m);
  const double e = seen.along().dot(ends.tail<2>() - seen.center_m);
  const double across2 = std::pow(seen.across_sigma_m, 2);
  const double direction2 = std::pow(seen.direction_sigma_rad, 2);
  EXPECT_NEAR(rows.noise(0, 0), across2 + s * s * direction2, 1e-15);
  EXPECT_NEAR(rows.noise(0, 1), across2 + s * e * direction2, 1e-15);
  EXPECT_NE(rows.noise(0, 1), 0.0);
}

TEST(MotionNoise, TheHeadingDriftsWithTheWay) {
  const MotionNoiseOptions options{0.0, 0.0, 0.0, 0.1, 0.0, 0.0};
  EXPECT_NEAR(motion_noise(options, 0.7, {2.0, 0.0, 0.0})(2, 2), 0.2 * 0.2, 1e-15);
  EXPECT_NEAR(motion_noise(options, 0.7, {-4.0, 0.0, 0.0})(2, 2), 0.4 * 0.4, 1e-15);
}

}  // namespace
}  // namespace marco::slam
