#include "tools/evaluate/model_fit.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/linear_algebra.hpp"
#include "common/mesh_samples.hpp"
#include "lcm_tools/base/check.hpp"
#include "tools/evaluate/model_judge.hpp"

namespace marco {
namespace {

// At most `wanted` points, even over the surface.
std::vector<Eigen::Vector3f> sample(const TriangleMesh& mesh, std::size_t wanted) {
  const auto each =
      static_cast<float>(std::max(1e-6, surface_area_m2(mesh) / static_cast<double>(wanted)));
  std::vector<Eigen::Vector3f> all;
  // Triangles smaller than `each` give a point each: thinned by the area they carry.
  float carried = 0.0F;
  for_each_sample(mesh, each, [&](const Eigen::Vector3f& point, std::size_t triangle) {
    const auto& t = mesh.triangles[triangle];
    const auto& v = mesh.vertices_m;
    carried += std::min(each, 0.5F * (v[t[1]] - v[t[0]]).cross(v[t[2]] - v[t[0]]).norm());
    if (carried < each) return;
    carried -= each;
    all.push_back(point);
  });
  return all;
}

ModelFit refine(const std::vector<Eigen::Vector3f>& points,
                const sim::RayCaster& world,
                Pose3 pose,
                int iterations) {
  constexpr double kReachM = 0.3;
  ModelFit fit;
  double sigma_m = 0.1;
  for (int iteration = 0; iteration < iterations; ++iteration) {
    NormalEquations<6> sum;
    sum.information.diagonal().setConstant(1e-6);
    std::size_t found = 0;
    double squares = 0.0;
    for (const Eigen::Vector3f& point : points) {
      const Eigen::Vector3d p = pose * point.cast<double>();
      const auto near = world.nearest(p.cast<float>(), static_cast<float>(kReachM));
      if (!near) continue;
      const Eigen::Vector3d n =
          face_normal(world.world().vertices_m, world.world().triangles[near->triangle])
              .cast<double>();
      const double e = n.dot(p - near->point_m.cast<double>());
      const double weight = 1.0 / (1.0 + e * e / (2.0 * sigma_m * sigma_m));
      sum.add((NormalEquations<6>::Vector() << p.cross(n), n).finished(), e, weight);
      ++found;
      squares += static_cast<double>(near->distance_m) * static_cast<double>(near->distance_m);
    }
    fit.samples = found;
    fit.rms_m = found > 0 ? std::sqrt(squares / static_cast<double>(found)) : kReachM;
    fit.world_from_model = pose;
    if (found < 6 || iteration + 1 == iterations) break;
    const NormalEquations<6>::Vector step = sum.step();
    Pose3 move = turn_about(Eigen::Vector3d::Zero(), step.head<3>());
    move.translation() = step.tail<3>();
    pose = move * pose;
    sigma_m = std::max(0.01, 0.7 * sigma_m);
  }
  return fit;
}

// Distances to the nearest surface on a lattice.
class DistanceField {
 public:
  explicit DistanceField(const sim::RayCaster& world) {
    min_m_ = max_m_ = world.world().vertices_m.front();
    for (const Eigen::Vector3f& vertex : world.world().vertices_m) {
      min_m_ = min_m_.cwiseMin(vertex);
      max_m_ = max_m_.cwiseMax(vertex);
    }
    size_ = ((max_m_ - min_m_) / kStepM).cast<int>() + Eigen::Vector3i::Constant(2);
    require(static_cast<double>(size_.x()) * size_.y() * size_.z() < 5e7,
            "the world is too large to search for the model: give its pose");
    for (int z = 0; z < size_.z(); ++z) {
      for (int y = 0; y < size_.y(); ++y) {
        for (int x = 0; x < size_.x(); ++x) {
          const Eigen::Vector3f at = min_m_ + kStepM * Eigen::Vector3i(x, y, z).cast<float>();
          distances_m_.push_back(world.distance_to_surface_m(at, kMostM));
        }
      }
    }
  }
  float at(const Eigen::Vector3f& point) const {
    const Eigen::Vector3i cell =
        ((point - min_m_) / kStepM + Eigen::Vector3f::Constant(0.5F)).cast<int>();
    if ((point - min_m_).minCoeff() < -kMostM || (cell.array() < 0).any() ||
        (cell.array() >= size_.array()).any()) {
      return kMostM;
    }
    const Eigen::Index row = Eigen::Index{cell.z()} * size_.y() + cell.y();
    return distances_m_[static_cast<std::size_t>(row * size_.x() + cell.x())];
  }
  Eigen::Vector3f min_m() const { return min_m_; }
  Eigen::Vector3f max_m() const { return max_m_; }

 private:
  static constexpr float kStepM = 0.1F;
  static constexpr float kMostM = 0.4F;
  Eigen::Vector3f min_m_, max_m_;
  Eigen::Vector3i size_;
  std::vector<float> distances_m_;
};

struct Guess {
  double cost;
  Pose3 pose;
};

std::vector<Guess> coarse_guesses(const std::vector<Eigen::Vector3f>& points,
                                  const DistanceField& field) {
  constexpr int kHeadings = 90;
  constexpr float kPlaceM = 0.25F;
  Eigen::Vector3f middle = Eigen::Vector3f::Zero();
  for (const Eigen::Vector3f& point : points) middle += point / static_cast<float>(points.size());
  std::vector<Guess> guesses;
  for (int heading = 0; heading < kHeadings; ++heading) {
    const double yaw = 2.0 * std::numbers::pi * heading / kHeadings;
    const Eigen::Matrix3f turn =
        make_pose3(Eigen::Vector3d::Zero(), 0, 0, yaw).linear().cast<float>();
    std::vector<Eigen::Vector3f> turned;
    turned.reserve(points.size());
    for (const Eigen::Vector3f& point : points) {
      Eigen::Vector3f p = turn * (point - middle);
      p.z() = point.z();
      turned.push_back(p);
    }
    const Eigen::Vector3i steps = ((field.max_m() - field.min_m()) / kPlaceM).cast<int>();
    for (int column = 0; column <= steps.x(); ++column) {
      for (int row = 0; row <= steps.y(); ++row) {
        const Eigen::Vector3f shift(field.min_m().x() + kPlaceM * static_cast<float>(column),
                                    field.min_m().y() + kPlaceM * static_cast<float>(row), 0.0F);
        double cost = 0.0;
        for (const Eigen::Vector3f& point : turned) {
          cost += static_cast<double>(field.at(point + shift));
        }
        Pose3 pose = Pose3::Identity();
        pose.linear() = turn.cast<double>();
        pose.translation() =
            (shift - turn * Eigen::Vector3f(middle.x(), middle.y(), 0.0F)).cast<double>();
        guesses.push_back({cost, pose});
      }
    }
  }
  constexpr std::size_t kKept = 12;
  const auto kept = static_cast<std::ptrdiff_t>(std::min(kKept, guesses.size()));
  std::partial_sort(guesses.begin(), guesses.begin() + kept, guesses.end(),
                    [](const Guess& a, const Guess& b) { return a.cost < b.cost; });
  guesses.resize(static_cast<std::size_t>(kept));
  return guesses;
}

}  // namespace

ModelFit fit_model(const TriangleMesh& model, const sim::RayCaster& world, const Pose3& guess) {
  return refine(sample(model, 20000), world, guess, 25);
}

ModelFit find_model(const TriangleMesh& model, const sim::RayCaster& world) {
  const DistanceField field(world);
  const std::vector<Eigen::Vector3f> points = sample(model, 2000);
  require(!points.empty(), "the model has no surface");
  std::vector<Eigen::Vector3f> few;
  for (std::size_t i = 0; i < points.size(); i += 8) few.push_back(points[i]);
  Guess best{1e300, Pose3::Identity()};
  for (const Guess& guess : coarse_guesses(few, field)) {
    const ModelFit fit = refine(few, world, guess.pose, 15);
    double cost = 0.0;
    for (const Eigen::Vector3f& point : points) {
      const Eigen::Vector3d p = fit.world_from_model * point.cast<double>();
      cost += static_cast<double>(world.distance_to_surface_m(p.cast<float>(), 0.3F));
    }
    if (cost < best.cost) best = {cost, fit.world_from_model};
  }
  return fit_model(model, world, best.pose);
}

}  // namespace marco
