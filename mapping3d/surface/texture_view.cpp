#include "mapping3d/surface/texture_view.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/pose2.hpp"
#include "mapping3d/surface/texture_raster.hpp"

namespace marco::mapping3d {
namespace {

constexpr float kFarM = std::numeric_limits<float>::max();
constexpr float kNearM = 0.05F;  // nearer is the camera's own mount
constexpr int kRoomPx = 32;      // beyond the picture's border: what lies there still hides
// Parts of the picture's width over which a view fades out, towards its border and towards edges
// of depth. Wide, so that the mean of all views has no steps; what is sharp is not mixed there.
constexpr float kBorderPart = 0.15F;
constexpr float kEdgePart = 0.05F;
constexpr float kEdgeM = 0.10F;  // a larger step of depth is an edge

}  // namespace

TextureView::TextureView(const CameraPicture& picture,
                         const TriangleMesh& mesh,
                         const TextureOptions& options,
                         uint32_t number)
    : picture_(picture),
      number_(number),
      hidden_m_(static_cast<float>(options.hidden_m)),
      min_cosine_(static_cast<float>(std::cos(deg_to_rad(options.max_incidence_deg)))),
      camera_from_world_(picture.world_from_camera.inverse().cast<float>()),
      centre_m_(picture.world_from_camera.translation().cast<float>()) {
  find_ideal_radius();
  depths_m_.assign(
      static_cast<std::size_t>(buffer_width()) * static_cast<std::size_t>(buffer_height()), kFarM);
  for (const auto& triangle : mesh.triangles) {
    draw({camera_from_world_ * mesh.vertices_m[triangle[0]],
          camera_from_world_ * mesh.vertices_m[triangle[1]],
          camera_from_world_ * mesh.vertices_m[triangle[2]]},
         0);
  }
  find_edges();
}

int TextureView::buffer_width() const { return picture_.camera.width_px + 2 * kRoomPx; }
int TextureView::buffer_height() const { return picture_.camera.height_px + 2 * kRoomPx; }

Eigen::Vector2f TextureView::buffer_place(const Eigen::Vector2f& ideal) const {
  const CameraModel& camera = picture_.camera;
  return {static_cast<float>(camera.focal_x_px) * ideal.x() +
              static_cast<float>(camera.centre_x_px + kRoomPx),
          static_cast<float>(camera.focal_y_px) * ideal.y() +
              static_cast<float>(camera.centre_y_px + kRoomPx)};
}

Eigen::Vector2f TextureView::distorted(const Eigen::Vector2f& ideal) const {
  const CameraModel& camera = picture_.camera;
  const auto r2 = static_cast<double>(ideal.squaredNorm());
  const double factor = 1.0 + r2 * (camera.k1 + r2 * camera.k2);
  return {static_cast<float>(camera.focal_x_px * factor * static_cast<double>(ideal.x()) +
                             camera.centre_x_px),
          static_cast<float>(camera.focal_y_px * factor * static_cast<double>(ideal.y()) +
                             camera.centre_y_px)};
}

// Up to where the distortion grows: beyond, it would fold what lies far outside into the picture.
void TextureView::find_ideal_radius() {
  const CameraModel& camera = picture_.camera;
  const double wide_px = std::max(camera.centre_x_px, camera.width_px - 1 - camera.centre_x_px);
  const double high_px = std::max(camera.centre_y_px, camera.height_px - 1 - camera.centre_y_px);
  const double corner = std::hypot(wide_px / camera.focal_x_px, high_px / camera.focal_y_px);
  constexpr double kStep = 0.005;   // about a pixel of a wide camera: how exact the bound is
  constexpr int kMostSteps = 4000;  // 87 degrees off the axis
  double before = 0.0;
  for (int step = 1; step <= kMostSteps; ++step) {
    const double radius = step * kStep;
    const double r2 = radius * radius;
    const double seen = radius * (1.0 + r2 * (camera.k1 + r2 * camera.k2));
    if (seen <= before) break;
    ideal_radius_ = static_cast<float>(radius);
    if (seen > corner) break;
    before = seen;
  }
}

bool TextureView::may_see(const std::array<Eigen::Vector3f, 3>& corners_m) const {
  const auto& [a, b, c] = corners_m;
  if ((b - a).cross(c - a).dot(centre_m_ - a) <= 0.0F) return false;
  const Eigen::Vector3f middle_m = (a + b + c) / 3.0F;
  const float radius_m = std::sqrt(std::max(
      {(a - middle_m).squaredNorm(), (b - middle_m).squaredNorm(), (c - middle_m).squaredNorm()}));
  // A ball about the triangle against the cone about the picture.
  const Eigen::Vector3f in_camera = camera_from_world_ * middle_m;
  if (in_camera.z() + radius_m < kNearM) return false;
  const float outside = in_camera.head<2>().norm() - ideal_radius_ * in_camera.z();
  return outside <= 1.01F * radius_m * std::sqrt(1.0F + ideal_radius_ * ideal_radius_);
}

std::optional<Look> TextureView::look_at(const Eigen::Vector3f& point_m,
                                         const Eigen::Vector3f& normal) const {
  const Eigen::Vector3f to_camera = centre_m_ - point_m;
  const float distance_m = to_camera.norm();
  const float cosine = normal.dot(to_camera) / std::max(1e-6F, distance_m);
  if (cosine < min_cosine_) return std::nullopt;
  const Eigen::Vector3f in_camera = camera_from_world_ * point_m;
  if (in_camera.z() < kNearM) return std::nullopt;
  const Eigen::Vector2f ideal = in_camera.head<2>() / in_camera.z();
  if (ideal.squaredNorm() > ideal_radius_ * ideal_radius_) return std::nullopt;
  const Eigen::Vector2f pixel = distorted(ideal);
  const CameraModel& camera = picture_.camera;
  const Eigen::Vector2f size(static_cast<float>(camera.width_px - 1),
                             static_cast<float>(camera.height_px - 1));
  const float inside_px = std::min(pixel.minCoeff(), (size - pixel).minCoeff());
  if (!(inside_px >= 0.0F)) return std::nullopt;
  const Eigen::Vector2f place = buffer_place(ideal);
  const int x = static_cast<int>(std::lround(place.x()));
  const int y = static_cast<int>(std::lround(place.y()));
  if (x < 1 || y < 1 || x > buffer_width() - 2 || y > buffer_height() - 2) return std::nullopt;
  if (hidden(x, y, in_camera, camera_from_world_.linear() * normal)) return std::nullopt;
  const auto fade = [&](float px, float part) {
    return std::min(1.0F, (px + 0.5F) / (part * size.x()));
  };
  const float from_edge_px = from_edge_px_[pixel_at(x, y, buffer_width())];
  const float merit = fade(inside_px, kBorderPart) * fade(from_edge_px, kEdgePart) * cosine *
                      cosine / (distance_m * distance_m);
  return Look{colour(pixel), merit, number_};
}

// Divides triangles that reach behind the camera until their parts do not, or are small.
void TextureView::draw(const std::array<Eigen::Vector3f, 3>& corners, int deep) {
  const int behind =
      (corners[0].z() < kNearM) + (corners[1].z() < kNearM) + (corners[2].z() < kNearM);
  if (behind == 3) return;
  if (behind > 0) {
    constexpr int kDeepest = 8;  // a part is then 1/256 of the triangle
    if (deep >= kDeepest) return;
    const Eigen::Vector3f ab = 0.5F * (corners[0] + corners[1]);
    const Eigen::Vector3f bc = 0.5F * (corners[1] + corners[2]);
    const Eigen::Vector3f ca = 0.5F * (corners[2] + corners[0]);
    draw({corners[0], ab, ca}, deep + 1);
    draw({ab, corners[1], bc}, deep + 1);
    draw({ca, bc, corners[2]}, deep + 1);
    draw({ab, bc, ca}, deep + 1);
    return;
  }
  std::array<Eigen::Vector2f, 3> places;
  for (std::size_t i = 0; i < 3; ++i) {
    places[i] = buffer_place(corners[i].head<2>() / corners[i].z());
  }
  const Eigen::Vector3f inverse(1.0F / corners[0].z(), 1.0F / corners[1].z(),
                                1.0F / corners[2].z());
  for_each_pixel(places, buffer_width(), buffer_height(), 0.0F,
                 [&](int x, int y, const Eigen::Vector3f& weights) {
                   float& depth_m = depths_m_[pixel_at(x, y, buffer_width())];
                   depth_m = std::min(depth_m, 1.0F / weights.dot(inverse));
                 });
}

// The inverse depth of a plane is linear over the picture. A bend is no edge: a right angle seen
// diagonally bends by 2 / (f z).
bool TextureView::is_edge(std::size_t pixel, std::size_t step) const {
  const float before_m = depths_m_[pixel - step], here_m = depths_m_[pixel],
              after_m = depths_m_[pixel + step];
  if (before_m == kFarM || here_m == kFarM || after_m == kFarM) return false;  // a hole
  const float nearest_m = std::min({before_m, here_m, after_m});
  const float bend = std::abs(1.0F / before_m - 2.0F / here_m + 1.0F / after_m);
  const auto focal_px = static_cast<float>(picture_.camera.focal_x_px);
  return bend > kEdgeM / (nearest_m * nearest_m) + 2.0F / (focal_px * nearest_m);
}

// Distances by two passes over the buffer (chamfer distance, all weights 1; Borgefors 1986).
void TextureView::find_edges() {
  const int width = buffer_width(), height = buffer_height();
  const auto most = static_cast<uint8_t>(std::clamp(
      std::ceil(kEdgePart * static_cast<float>(picture_.camera.width_px)), 1.0F, 254.0F));
  from_edge_px_.assign(depths_m_.size(), most);
  for (int y = 1; y + 1 < height; ++y) {
    for (int x = 1; x + 1 < width; ++x) {
      const std::size_t pixel = pixel_at(x, y, width);
      if (is_edge(pixel, 1) || is_edge(pixel, static_cast<std::size_t>(width))) {
        from_edge_px_[pixel] = 0;
      }
    }
  }
  const auto lower = [&](std::size_t pixel, std::size_t other) {
    from_edge_px_[pixel] =
        static_cast<uint8_t>(std::min<int>(from_edge_px_[pixel], from_edge_px_[other] + 1));
  };
  const auto row = static_cast<std::size_t>(width);
  const std::array<std::size_t, 4> back = {1, row - 1, row, row + 1};
  for (std::size_t pixel = row + 1; pixel < from_edge_px_.size(); ++pixel) {
    for (const std::size_t step : back) lower(pixel, pixel - step);
  }
  for (std::size_t pixel = from_edge_px_.size() - row - 1; pixel-- > 0;) {
    for (const std::size_t step : back) lower(pixel, pixel + step);
  }
}

// A corner of the room, with another wall in the next pixel, hides nothing: that wall's depth there
// is the point's.
bool TextureView::hidden(int x,
                         int y,
                         const Eigen::Vector3f& in_camera,
                         const Eigen::Vector3f& normal) const {
  const CameraModel& camera = picture_.camera;
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      const float nearest_m = depths_m_[pixel_at(x + dx, y + dy, buffer_width())];
      if (nearest_m + hidden_m_ >= in_camera.z()) continue;
      const Eigen::Vector3f ray(
          static_cast<float>((x + dx - kRoomPx - camera.centre_x_px) / camera.focal_x_px),
          static_cast<float>((y + dy - kRoomPx - camera.centre_y_px) / camera.focal_y_px), 1.0F);
      if (normal.dot(nearest_m * ray - in_camera) > hidden_m_) return true;
    }
  }
  return false;
}

Eigen::Vector3f TextureView::colour(const Eigen::Vector2f& pixel) const {
  const CameraModel& camera = picture_.camera;
  const int x = std::min(static_cast<int>(pixel.x()), camera.width_px - 2);
  const int y = std::min(static_cast<int>(pixel.y()), camera.height_px - 2);
  const float u = pixel.x() - static_cast<float>(x), v = pixel.y() - static_cast<float>(y);
  const auto at = [&](int px, int py) {
    const uint8_t* rgb = &picture_.rgb[3 * pixel_at(px, py, camera.width_px)];
    return Eigen::Vector3f(rgb[0], rgb[1], rgb[2]);
  };
  return (1 - v) * ((1 - u) * at(x, y) + u * at(x + 1, y)) +
         v * ((1 - u) * at(x, y + 1) + u * at(x + 1, y + 1));
}

}  // namespace marco::mapping3d
