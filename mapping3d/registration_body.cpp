#include "mapping3d/registration_body.hpp"

#include <Eigen/Eigenvalues>

#include "lcm_tools/base/check.hpp"

namespace marco::mapping3d {
namespace {

// A shift is observable when the mean square of the normals along it reaches this: normals err by
// about 4 deg.
constexpr double kLoose = 0.005;

Eigen::Vector3d middle_of(const std::vector<Eigen::Vector3f>& points_m) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3f& point_m : points_m) sum += point_m.cast<double>();
  return points_m.empty() ? sum : sum / static_cast<double>(points_m.size());
}

}  // namespace

Pose3 RegistrationBody::world_from_placed() const {
  Pose3 pose = turn_about(pivot_m, correction.head<3>());
  pose.translation() += correction.tail<3>();
  return pose;
}

Matrix6d RegistrationBody::origin_from_pivot() const {
  const Eigen::Vector3d at_m = pivot_m + correction.tail<3>();
  Matrix6d twist = Matrix6d::Identity();
  twist(3, 1) = -at_m.z();
  twist(3, 2) = at_m.y();
  twist(4, 0) = at_m.z();
  twist(4, 2) = -at_m.x();
  twist(5, 0) = -at_m.y();
  twist(5, 1) = at_m.x();
  return twist;
}

void RegistrationBody::move(const Vector6d& twist) {
  const Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  const Eigen::AngleAxisd turned(turn_about(origin, twist.head<3>()).linear() *
                                 turn_about(origin, correction.head<3>()).linear());
  correction.head<3>() = turned.angle() * turned.axis();
  correction.tail<3>() += twist.tail<3>();
}

void PairSystem::hold_loose_shifts(const Pose3& world_from_a, const Pose3& world_from_b) {
  if (!(weight > 0.0)) return;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(information.bottomRightCorner<3, 3>());
  const Eigen::Vector3d middle_m = center_m / weight;
  const Eigen::Vector3d by_a = world_from_a * middle_m, by_b = world_from_b * middle_m;
  for (Eigen::Index i = 0; i < 3; ++i) {
    if (solver.eigenvalues()[i] >= kLoose * weight) continue;
    const Eigen::Vector3d loose = solver.eigenvectors().col(i);
    Vector6d jacobian;
    jacobian << by_b.cross(loose), loose;
    add(jacobian, loose.dot(by_b - by_a), weight);
  }
}

std::vector<RegistrationBody> make_bodies(const PlacedScenes& placed,
                                          const std::vector<std::size_t>& body_of,
                                          const SurfelOptions& options) {
  std::vector<std::vector<Surfel>> surfels;
  std::vector<std::vector<Eigen::Vector3f>> origins_m;
  for (std::size_t i = 0; i < placed.count; ++i) {
    const std::size_t body = body_of[i];
    require(body <= surfels.size(), "register_scenes: bodies are numbered as they first appear");
    if (body == surfels.size()) {
      surfels.emplace_back();
      origins_m.emplace_back();
    }
    const ScenePoints scene = placed.at(i);
    const std::vector<Surfel> found = find_surfels(scene, options);
    surfels[body].insert(surfels[body].end(), found.begin(), found.end());
    origins_m[body].insert(origins_m[body].end(), scene.origins_m.begin(), scene.origins_m.end());
  }
  std::vector<RegistrationBody> bodies;
  for (std::size_t body = 0; body < surfels.size(); ++body) {
    bodies.push_back({SurfelIndex(std::move(surfels[body])), middle_of(origins_m[body])});
  }
  return bodies;
}

}  // namespace marco::mapping3d
