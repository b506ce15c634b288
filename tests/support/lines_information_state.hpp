#pragma once

#include <map>
#include <vector>

#include "slam/line_slam/ekf/sparse_rows.hpp"
#include "tests/support/slow_matrices.hpp"

namespace marco::testing {

/// The slowest filter: it keeps the information on everything that was ever drawn independently
/// (the start, each move's error, each new wall's error) and forgets none of it. What a block of
/// the state is, is a map from these; to remove a block is to look at it no more, to join two is
/// another map, and every covariance is rebuilt by inverting all the information. Nothing here is
/// shared with slam::EkfState or LinesDenseState but the numbers of the blocks.
class LinesInformationState {
 public:
  LinesInformationState(const Eigen::Vector3d& robot, const Eigen::Matrix3d& covariance) {
    draw(covariance);
    blocks_[0] = {Eigen::MatrixXd::Identity(3, 3), robot};
  }

  void predict(const Eigen::Vector3d& robot, const Eigen::Matrix3d& f, const Eigen::Matrix3d& v) {
    const Eigen::Index from = draw(v);
    Eigen::MatrixXd map = times(f, wide(0));
    map.middleCols(from, 3).setIdentity();
    set(0, map, robot);
  }

  void append(int block,
              const Eigen::Vector4d& mean,
              const Eigen::Matrix<double, 4, 3>& by_robot,
              const Eigen::Matrix4d& noise) {
    const Eigen::Index from = draw(noise);
    Eigen::MatrixXd map = times(by_robot, wide(0));
    map.middleCols(from, 4).setIdentity();
    set(block, map, mean);
  }

  /// @param change  its noise 4 x 4 or zero: then nothing is drawn
  void replace(int block, const slam::SparseRows& change, const Eigen::Vector4d& mean) {
    const bool exact = change.noise.cwiseAbs().maxCoeff() == 0.0;
    const Eigen::Index from = exact ? 0 : draw(change.noise);
    Eigen::MatrixXd map = of_roots(change);
    if (!exact) map.middleCols(from, 4).setIdentity();
    set(block, map, mean);
  }

  void remove(int block) { blocks_.erase(block); }

  void correct(const slam::SparseRows& rows) {
    const Eigen::MatrixXd h = of_roots(rows);
    const Eigen::VectorXd expected = h.lazyProduct(roots());
    const Eigen::MatrixXd weighted = times(h.transpose(), inverse(rows.noise));
    information_ += times(weighted, h);
    pull_ += weighted.lazyProduct(rows.innovation + expected);
  }

  Eigen::VectorXd mean(int block) {
    return blocks_[block].offset + wide(block).lazyProduct(roots());
  }

  /// Of the given blocks, one after the other.
  Eigen::MatrixXd covariance(const std::vector<int>& blocks) {
    Eigen::MatrixXd map(0, information_.cols());
    for (const int block : blocks) {
      const Eigen::MatrixXd part = wide(block);
      map.conservativeResize(map.rows() + part.rows(), Eigen::NoChange);
      map.bottomRows(part.rows()) = part;
    }
    return times(times(map, inverse(information_)), map.transpose());
  }

 private:
  struct Block {
    Eigen::MatrixXd map;  ///< of the roots there were when it was made
    Eigen::VectorXd offset;
  };

  // More independent errors. @returns their first index.
  Eigen::Index draw(const Eigen::MatrixXd& covariance) {
    const Eigen::Index n = information_.rows(), more = covariance.rows();
    information_.conservativeResize(n + more, n + more);
    information_.rightCols(more).setZero();
    information_.bottomRows(more).setZero();
    information_.bottomRightCorner(more, more) = inverse(covariance);
    pull_.conservativeResize(n + more);
    pull_.tail(more).setZero();
    return n;
  }

  Eigen::VectorXd roots() const { return inverse(information_).lazyProduct(pull_); }

  Eigen::MatrixXd wide(int block) {
    const Eigen::MatrixXd& map = blocks_[block].map;
    Eigen::MatrixXd result = Eigen::MatrixXd::Zero(map.rows(), information_.cols());
    result.leftCols(map.cols()) = map;
    return result;
  }

  Eigen::MatrixXd of_roots(const slam::SparseRows& rows) {
    Eigen::MatrixXd map = Eigen::MatrixXd::Zero(rows.rows(), information_.cols());
    for (int k = 0; k < rows.num_blocks; ++k) {
      const Eigen::MatrixXd block = wide(rows.blocks[static_cast<std::size_t>(k)]);
      map += times(rows.jacobian.middleCols(4 * k, block.rows()), block);
    }
    return map;
  }

  void set(int block, const Eigen::MatrixXd& map, const Eigen::VectorXd& mean) {
    blocks_[block] = {map, mean - Eigen::VectorXd(map.lazyProduct(roots()))};
  }

  Eigen::MatrixXd information_;
  Eigen::VectorXd pull_;
  std::map<int, Block> blocks_;
};

}  // namespace marco::testing
