#include "simulator/camera_view.hpp"

#include <algorithm>
#include <cmath>

namespace marco::sim {
namespace {

constexpr float kSightM = 100.0F;
const Eigen::Vector3f kNothing(40, 44, 56);

Eigen::Vector3f look(const RayCaster& rays, Eigen::Vector3f origin, Eigen::Vector3f direction) {
  constexpr int kMostPanes = 5;
  constexpr float kPastM = 1e-3F;
  const Eigen::Vector3f glass(0.85F, 0.95F, 0.92F);
  Eigen::Vector3f tint = Eigen::Vector3f::Ones();
  float travelled_m = 0.0F;
  for (int pane = 0; pane < kMostPanes; ++pane) {
    const auto hit = rays.cast(origin, direction, kSightM);
    if (!hit) break;
    travelled_m += hit->range_m;
    if (hit->material == Material::plain || hit->material == Material::black) {
      const float towards = -hit->normal.dot(direction);
      const float fall = 1.0F / (1.0F + 0.015F * travelled_m * travelled_m);
      const float light = 0.35F + 0.15F * hit->normal.z() + 0.5F * towards * fall;
      return tint.cwiseProduct(colour_of(hit->normal, hit->material)) *
             std::clamp(light, 0.0F, 1.0F);
    }
    origin += hit->range_m * direction;
    if (hit->material == Material::mirror) {
      direction -= 2.0F * direction.dot(hit->normal) * hit->normal;
    } else {
      tint = tint.cwiseProduct(glass);
    }
    origin += kPastM * direction;
  }
  return tint.cwiseProduct(kNothing);
}

}  // namespace

Eigen::Vector3f colour_of(const Eigen::Vector3f& normal, Material material) {
  if (material == Material::black) return {28, 28, 30};
  // Floors are brown, ceilings white, walls ochre to blue by the way they face.
  if (normal.z() > 0.7F) return {150, 120, 92};
  if (normal.z() < -0.7F) return {235, 235, 230};
  const float facing = 0.5F + 0.5F * normal.x();
  return Eigen::Vector3f(150, 170, 205) * (1.0F - facing) + Eigen::Vector3f(225, 195, 140) * facing;
}

double CameraView::focal_length_px() const {
  return 0.5 * width_px / std::tan(0.5 * deg_to_rad(field_of_view_deg));
}

std::vector<uint8_t> picture_of(const RayCaster& rays,
                                const Pose3& world_from_camera,
                                const CameraView& view) {
  validate(view, "camera");
  const Eigen::Matrix3f turn = world_from_camera.linear().cast<float>();
  const Eigen::Vector3f origin = world_from_camera.translation().cast<float>();
  const auto focal = static_cast<float>(view.focal_length_px());
  std::vector<uint8_t> picture;
  picture.reserve(static_cast<std::size_t>(3) * view.width_px * view.height_px);
  for (int row = 0; row < view.height_px; ++row) {
    for (int column = 0; column < view.width_px; ++column) {
      const float left = 0.5F * static_cast<float>(view.width_px - 1) - static_cast<float>(column);
      const float up = 0.5F * static_cast<float>(view.height_px - 1) - static_cast<float>(row);
      const Eigen::Vector3f ray = Eigen::Vector3f(focal, left, up).normalized();
      const Eigen::Vector3f colour = look(rays, origin, turn * ray);
      for (int c = 0; c < 3; ++c) picture.push_back(static_cast<uint8_t>(colour[c]));
    }
  }
  return picture;
}

}  // namespace marco::sim
