#include "slam/line_slam/ekf/ekf_state.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <random>

#include "tests/support/lines_dense_state.hpp"
#include "tests/support/lines_information_state.hpp"

namespace marco::slam {
namespace {

using testing::LinesDenseState;
using testing::LinesInformationState;

enum class Twin { none, dense, information };

// Drives the fast and the slow filter through the same random life of a map.
class TwinLife {
 public:
  TwinLife(unsigned seed, Twin twin) : random_(seed), fast_(start_, start_covariance_) {
    if (twin == Twin::dense) dense_.emplace(start_, start_covariance_);
    if (twin == Twin::information) information_.emplace(start_, start_covariance_);
  }

  void step(int max_walls) {
    const double choice = uniform(0.0, 1.0);
    if (walls_.size() < 3 || (choice < 0.12 && static_cast<int>(walls_.size()) < max_walls)) {
      append();
    } else if (choice < 0.15 && walls_.size() > 6) {
      remove();
    } else if (choice < 0.18 && walls_.size() > 6) {
      join();
    } else if (choice < 0.22) {
      replace();
    } else if (choice < 0.33) {
      predict();
    } else {
      correct();
    }
  }

  void expect_equal(double tolerance) {
    const Eigen::VectorXd mean = fast_.dense_mean(walls_);
    const Eigen::MatrixXd p = fast_.dense_covariance(walls_);
    std::vector<Eigen::Index> order{0, 1, 2};
    for (const int wall : walls_) {
      for (int i = 0; i < 4; ++i) order.push_back(dense_->place(wall) + i);
    }
    EXPECT_LE((mean - dense_->mean()(order)).cwiseAbs().maxCoeff(), tolerance);
    EXPECT_LE((p - dense_->covariance()(order, order)).cwiseAbs().maxCoeff(), tolerance);
  }

  void expect_equal_to_information(double tolerance) {
    const Eigen::VectorXd mean = fast_.dense_mean(walls_);
    std::vector<int> blocks{0};
    Eigen::VectorXd expected(mean.size());
    expected.head<3>() = information_->mean(0);
    for (std::size_t k = 0; k < walls_.size(); ++k) {
      expected.segment<4>(3 + 4 * static_cast<Eigen::Index>(k)) = information_->mean(walls_[k]);
      blocks.push_back(walls_[k]);
    }
    EXPECT_LE((mean - expected).cwiseAbs().maxCoeff(), tolerance);
    const Eigen::MatrixXd p = fast_.dense_covariance(walls_);
    EXPECT_LE((p - information_->covariance(blocks)).cwiseAbs().maxCoeff(), tolerance);
  }

  void expect_positive() {
    const Eigen::MatrixXd p = fast_.dense_covariance(walls_);
    EXPECT_EQ((p - p.transpose()).cwiseAbs().maxCoeff(), 0.0);
    // Exact conditions of a positive matrix, less rounding of its largest entries.
    EXPECT_TRUE(testing::eigenvalues_reach(p, -1e-13 * p.cwiseAbs().maxCoeff()));
  }

  std::size_t num_walls() const { return walls_.size(); }
  int num_removed() const { return num_removed_; }
  int num_joined() const { return num_joined_; }
  void expect_equal_blocks(double tolerance) {
    for (const int a : walls_) {
      EXPECT_LE((fast_.mean(a) - dense_->wall_mean(a)).cwiseAbs().maxCoeff(), tolerance);
      for (const int b : walls_) {
        const Eigen::Matrix4d expected =
            dense_->covariance().block<4, 4>(dense_->place(a), dense_->place(b));
        EXPECT_LE((fast_.covariance(a, b) - expected).cwiseAbs().maxCoeff(), tolerance);
      }
    }
  }

 private:
  double uniform(double a, double b) {
    return std::uniform_real_distribution<double>(a, b)(random_);
  }
  template <class Matrix>
  Matrix random_matrix() {
    Matrix m;
    for (Eigen::Index i = 0; i < m.size(); ++i) m.data()[i] = uniform(-1.0, 1.0);
    return m;
  }
  int any_wall() {
    return walls_[std::uniform_int_distribution<std::size_t>(0, walls_.size() - 1)(random_)];
  }

  void append() {
    const Eigen::Vector4d mean = 5.0 * random_matrix<Eigen::Vector4d>();
    Eigen::Matrix<double, 4, 3> g = random_matrix<Eigen::Matrix<double, 4, 3>>();
    const Eigen::Matrix4d half = 0.02 * random_matrix<Eigen::Matrix4d>();
    const Eigen::Matrix4d noise = half * half.transpose() + 1e-4 * Eigen::Matrix4d::Identity();
    const int block = fast_.append(mean, mean, g, noise);
    if (dense_) dense_->append(block, mean, g, noise);
    if (information_) information_->append(block, mean, g, noise);
    walls_.push_back(block);
  }
  void remove() {
    const int block = any_wall();
    fast_.remove(block);
    ++num_removed_;
    if (dense_) dense_->remove(block);
    if (information_) information_->remove(block);
    walls_.erase(std::find(walls_.begin(), walls_.end(), block));
  }
  // As WallFilter::join: both measured to lie on one line, an end of each kept, the second removed.
  void join() {
    const int kept = any_wall();
    int other = any_wall();
    while (other == kept) other = any_wall();
    SparseRows rows;
    rows.resize(2);
    rows.num_blocks = 2;
    rows.blocks = {kept, other, 0};
    rows.jacobian.leftCols<8>() = random_matrix<Eigen::Matrix<double, 2, 8>>();
    rows.innovation.setConstant(0.01);
    rows.noise.diagonal().setConstant(1e-4);
    fast_.correct(rows);
    fast_.finish_corrections();
    SparseRows choice;
    choice.resize(4);
    choice.num_blocks = 2;
    choice.blocks = {kept, other, 0};
    choice.jacobian.block<2, 2>(0, 0).setIdentity();
    choice.jacobian.block<2, 2>(2, 6).setIdentity();
    Eigen::Vector4d mean;
    mean << fast_.mean(kept).head<2>(), fast_.mean(other).tail<2>();
    fast_.replace(kept, choice, mean, mean);
    fast_.remove(other);
    ++num_joined_;
    const auto repeat = [&](auto& slow) {
      slow.correct(rows);
      slow.replace(kept, choice, mean);
      slow.remove(other);
    };
    if (dense_) repeat(*dense_);
    if (information_) repeat(*information_);
    walls_.erase(std::find(walls_.begin(), walls_.end(), other));
  }
  void replace() {
    const int block = any_wall();
    SparseRows change;
    change.resize(4);
    change.num_blocks = 3;
    int other = any_wall();
    if (other == block) other = 0, change.num_blocks = 2;
    change.blocks = {0, block, other};
    if (change.num_blocks == 2) change.blocks[2] = 0;
    change.jacobian.setZero();
    change.jacobian.leftCols<3>() = 0.1 * random_matrix<Eigen::Matrix<double, 4, 3>>();
    change.jacobian.middleCols<4>(4) =
        0.7 * Eigen::Matrix4d::Identity() + 0.1 * random_matrix<Eigen::Matrix4d>();
    if (change.num_blocks == 3) {
      change.jacobian.middleCols<4>(8) = 0.2 * random_matrix<Eigen::Matrix4d>();
    }
    change.noise = 1e-5 * Eigen::Matrix4d::Identity();
    const Eigen::Vector4d mean = 5.0 * random_matrix<Eigen::Vector4d>();
    fast_.replace(block, change, mean, mean);
    if (dense_) dense_->replace(block, change, mean);
    if (information_) information_->replace(block, change, mean);
  }
  void predict() {
    const Eigen::Vector3d robot = random_matrix<Eigen::Vector3d>();
    Eigen::Matrix3d f = Eigen::Matrix3d::Identity();
    f.topRightCorner<2, 1>() = 0.3 * random_matrix<Eigen::Vector2d>();
    const Eigen::Matrix3d half = 0.02 * random_matrix<Eigen::Matrix3d>();
    const Eigen::Matrix3d noise = half * half.transpose() + 1e-6 * Eigen::Matrix3d::Identity();
    fast_.predict(robot, f, noise);
    if (dense_) dense_->predict(robot, f, noise);
    if (information_) information_->predict(robot, f, noise);
  }
  void correct() {
    const int times = std::uniform_int_distribution<int>(1, 6)(random_);
    for (int k = 0; k < times; ++k) {
      SparseRows rows;
      rows.resize(std::uniform_int_distribution<int>(1, 4)(random_));
      rows.num_blocks = 2;
      rows.blocks = {0, any_wall(), 0};
      for (Eigen::Index i = 0; i < rows.rows(); ++i) {
        rows.jacobian.row(i).head<3>() = random_matrix<Eigen::Vector3d>().transpose();
        rows.jacobian.row(i).segment<4>(4) = random_matrix<Eigen::Vector4d>().transpose();
        rows.innovation(i) = uniform(-0.05, 0.05);
        rows.noise(i, i) = uniform(1e-4, 1e-2);
      }
      fast_.correct(rows);
      if (dense_) dense_->correct(rows);
      if (information_) information_->correct(rows);
    }
    fast_.finish_corrections();
  }

  const Eigen::Vector3d start_{1.0, 2.0, 0.5};
  const Eigen::Matrix3d start_covariance_ = Eigen::Vector3d(1e-4, 1e-4, 1e-5).asDiagonal();
  std::mt19937 random_;
  EkfState fast_;
  std::optional<LinesDenseState> dense_;
  std::optional<LinesInformationState> information_;
  std::vector<int> walls_;
  int num_removed_ = 0, num_joined_ = 0;
};

// Equal to rounding: entries are below 10 and some hundred operations each lose a few 1e-16 of it.
TEST(EkfState, EqualsTheDenseTextbookFilter) {
  for (const unsigned seed : {1U, 2U}) {
    TwinLife life(seed, Twin::dense);
    for (int step = 0; step < 300; ++step) {
      life.step(40);
      if (step % 100 == 37) life.expect_equal_blocks(1e-9);
      if (step % 100 == 99) life.expect_equal(1e-9);
    }
    EXPECT_GT(life.num_walls(), 16U);
  }
}

// Removal and joining among all the rest. The information's inverse loses what its condition takes:
// entries up to 1e10 beside 1e2, so 1e-8 of the largest covariances.
TEST(EkfState, RemovesAndJoinsAsOneRebuiltFromTheInformation) {
  TwinLife life(4, Twin::information);
  for (int step = 0; step < 120; ++step) {
    life.step(10);
    if (step % 20 == 19) life.expect_equal_to_information(1e-7);
  }
  EXPECT_GT(life.num_removed(), 2);
  EXPECT_GT(life.num_joined(), 2);
}

TEST(EkfState, CovarianceStaysSymmetricAndPositiveOverTenThousandOperations) {
  TwinLife life(9, Twin::none);
  for (int step = 0; step < 10000; ++step) {
    life.step(20);
    if (step % 1000 == 999) life.expect_positive();
  }
}

}  // namespace
}  // namespace marco::slam
