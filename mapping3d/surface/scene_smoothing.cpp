#include "mapping3d/surface/scene_smoothing.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace marco::mapping3d {
namespace {

// Sums over a window: q qT (6), q / r (3), 1 / r^2, count.
constexpr std::size_t kSums = 11;
using Sums = std::array<double, kSums>;

struct Plane {
  Eigen::Vector3d m = Eigen::Vector3d::Zero();                ///< m x = 1, about the mean sensor
  double residual = std::numeric_limits<double>::infinity();  ///< rms of 1/r
  double count = 0.0;
};

class Smoother {
 public:
  Smoother(const ScenePoints& scene, const SmoothingOptions& options)
      : scene_(scene), options_(options) {
    validate(options, "scene_smoothing");
    find_centre();
    add_up();
  }

  SmoothScene run() {
    result_.rows = scene_.rows;
    result_.columns = scene_.columns;
    result_.origins_m = scene_.origins_m;
    result_.points_m = scene_.points_m;
    const std::size_t count = scene_.points_m.size();
    result_.normals.resize(count, Eigen::Vector3f::Zero());
    result_.sigmas_m.resize(count, 0.0F);
    result_.kinds.resize(count, SmoothScene::Kind::none);
    fit_largest();
    sigma_m_ = find_sigma();
    result_.sigma_m = sigma_m_;
    for (int row = 0; row < rows(); ++row) {
      for (int column = 0; column < columns(); ++column) place_beam(row, column);
    }
    return std::move(result_);
  }

 private:
  static constexpr int kLargest = 3;  ///< half-width of the largest window

  int rows() const { return static_cast<int>(scene_.rows); }
  int columns() const { return static_cast<int>(scene_.columns); }
  std::size_t at(int row, int column) const {
    return scene_.index(static_cast<std::size_t>(row), static_cast<std::size_t>(column));
  }
  Sums& sums_at(int row, int column) {
    return sums_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns() + 1) +
                 static_cast<std::size_t>(column)];
  }

  void find_centre() {
    for (const Eigen::Vector3f& origin : scene_.origins_m) centre_ += origin.cast<double>();
    if (!scene_.origins_m.empty()) centre_ /= static_cast<double>(scene_.origins_m.size());
  }

  // The summed-area table.
  void add_up() {
    sums_.assign((scene_.rows + 1) * (scene_.columns + 1), Sums{});
    ranges_m_.assign(scene_.points_m.size(), 0.0);
    for (int row = 0; row < rows(); ++row) {
      Sums line{};
      for (int column = 0; column < columns(); ++column) {
        const std::size_t index = at(row, column);
        const Eigen::Vector3d p = scene_.points_m[index].cast<double>() - centre_;
        const double r = p.norm();
        if (scene_.valid[index] != 0 && r > 1e-3) {
          ranges_m_[index] = r;
          const double inverse = 1.0 / r;
          const Eigen::Vector3d q = inverse * p;
          const Sums own{q.x() * q.x(),
                         q.x() * q.y(),
                         q.x() * q.z(),
                         q.y() * q.y(),
                         q.y() * q.z(),
                         q.z() * q.z(),
                         q.x() * inverse,
                         q.y() * inverse,
                         q.z() * inverse,
                         inverse * inverse,
                         1.0};
          for (std::size_t i = 0; i < kSums; ++i) line[i] += own[i];
        }
        const Sums& above = sums_at(row, column + 1);
        Sums& here = sums_at(row + 1, column + 1);
        for (std::size_t i = 0; i < kSums; ++i) here[i] = above[i] + line[i];
      }
    }
  }

  Plane fit(int row, int column, int half) {
    const int top = std::max(0, row - half), bottom = std::min(rows(), row + half + 1);
    const int left = std::max(0, column - half), right = std::min(columns(), column + half + 1);
    const Sums &a = sums_at(top, left), &b = sums_at(top, right), &c = sums_at(bottom, left),
               &d = sums_at(bottom, right);
    Sums s;
    for (std::size_t i = 0; i < kSums; ++i) s[i] = d[i] - b[i] - c[i] + a[i];
    Plane plane;
    plane.count = s[10];
    if (plane.count < 0.6 * (2 * half + 1) * (2 * half + 1)) return plane;
    // Cramer's rule on the symmetric matrix of q qT.
    const double c00 = s[3] * s[5] - s[4] * s[4], c01 = s[2] * s[4] - s[1] * s[5];
    const double c02 = s[1] * s[4] - s[2] * s[3], c11 = s[0] * s[5] - s[2] * s[2];
    const double c12 = s[1] * s[2] - s[0] * s[4], c22 = s[0] * s[3] - s[1] * s[1];
    const double determinant = s[0] * c00 + s[1] * c01 + s[2] * c02;
    if (!(determinant > 1e-12)) return plane;
    plane.m =
        Eigen::Vector3d(c00 * s[6] + c01 * s[7] + c02 * s[8], c01 * s[6] + c11 * s[7] + c12 * s[8],
                        c02 * s[6] + c12 * s[7] + c22 * s[8]) /
        determinant;
    const double squares = s[9] - (plane.m.x() * s[6] + plane.m.y() * s[7] + plane.m.z() * s[8]);
    plane.residual = std::sqrt(std::max(0.0, squares) / (plane.count - 3.0));
    return plane;
  }

  void fit_largest() {
    largest_.resize(scene_.points_m.size());
    for (int row = 0; row < rows(); ++row) {
      for (int column = 0; column < columns(); ++column) {
        largest_[at(row, column)] = fit(row, column, kLargest);
      }
    }
  }

  // Most windows lie within one surface: the lower third of their residuals is the laser's noise.
  double find_sigma() const {
    std::vector<float> residuals_m;
    for (std::size_t i = 0; i < largest_.size(); ++i) {
      const double residual_m = largest_[i].residual * ranges_m_[i] * ranges_m_[i];
      if (ranges_m_[i] > 0.0 && std::isfinite(residual_m)) {
        residuals_m.push_back(static_cast<float>(residual_m));
      }
    }
    if (residuals_m.empty()) return options_.max_sigma_m;
    const auto third = residuals_m.begin() + static_cast<std::ptrdiff_t>(residuals_m.size() / 3);
    std::nth_element(residuals_m.begin(), third, residuals_m.end());
    return std::clamp(static_cast<double>(*third), options_.min_sigma_m, options_.max_sigma_m);
  }

  void place_beam(int row, int column) {
    const std::size_t index = at(row, column);
    if (ranges_m_[index] <= 0.0) return;
    const Eigen::Vector3d origin = scene_.origins_m[static_cast<std::size_t>(row)].cast<double>();
    const Eigen::Vector3d beam = scene_.points_m[index].cast<double>() - origin;
    for (int half = kLargest; half >= 1; --half) {
      if (move_to_plane(row, column, half)) return;
    }
    result_.kinds[index] = SmoothScene::Kind::loose;
    result_.normals[index] = (-beam.normalized()).cast<float>();
    result_.sigmas_m[index] = static_cast<float>(sigma_m_);
  }

  bool move_to_plane(int row, int column, int half) {
    const std::size_t index = at(row, column);
    const double r = ranges_m_[index];
    const double limit = options_.plane_residual * sigma_m_ / (r * r);
    const Eigen::Vector3d q = (scene_.points_m[index].cast<double>() - centre_) / r;
    Plane best;
    double best_score = std::numeric_limits<double>::infinity(), best_leverage = 1.0;
    const int shift = half > 1 ? half - 1 : 1;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const int y = row + dy * shift, x = column + dx * shift;
        if (y < 0 || x < 0 || y >= rows() || x >= columns()) continue;
        const Plane plane = half == kLargest ? largest_[at(y, x)] : fit(y, x, half);
        if (!(plane.residual < limit)) continue;
        if (std::abs(plane.m.dot(q) - 1.0 / r) * r * r > options_.own_residual * sigma_m_) continue;
        // The fit must be better by as much as an off-centre window costs in variance.
        const int off = dx * dx + dy * dy;
        const double score = plane.residual * (1.0 + 0.15 * off);
        if (score >= best_score) continue;
        best_score = score;
        best = plane;
        best_leverage = (1.0 + 2.0 * off) / plane.count;
      }
    }
    return best_score < std::numeric_limits<double>::infinity() &&
           settle(row, index, best, best_leverage);
  }

  bool settle(int row, std::size_t index, const Plane& plane, double leverage) {
    const Eigen::Vector3d origin = scene_.origins_m[static_cast<std::size_t>(row)].cast<double>();
    const Eigen::Vector3d beam = scene_.points_m[index].cast<double>() - origin;
    const double range_m = beam.norm();
    const double slope = plane.m.dot(beam) / range_m;
    if (!(slope > 0.0)) return false;
    const double moved_m = (1.0 - plane.m.dot(origin - centre_)) / slope;
    if (std::abs(moved_m - range_m) > 2.0 * options_.own_residual * sigma_m_) return false;
    result_.points_m[index] = (origin + beam * (moved_m / range_m)).cast<float>();
    result_.normals[index] = (-plane.m.normalized()).cast<float>();
    const double cosine = slope / plane.m.norm();
    result_.sigmas_m[index] = static_cast<float>(sigma_m_ * cosine * std::sqrt(leverage));
    result_.kinds[index] = SmoothScene::Kind::plane;
    return true;
  }

  const ScenePoints& scene_;
  SmoothingOptions options_;
  Eigen::Vector3d centre_ = Eigen::Vector3d::Zero();
  std::vector<Sums> sums_;
  std::vector<double> ranges_m_;  ///< from the mean sensor
  std::vector<Plane> largest_;
  double sigma_m_ = 0.0;
  SmoothScene result_;
};

}  // namespace

SmoothScene smooth(const ScenePoints& scene, const SmoothingOptions& options) {
  return Smoother(scene, options).run();
}

}  // namespace marco::mapping3d
