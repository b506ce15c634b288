#include "mapping3d/surface/texture.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "common/pose2.hpp"
#include "mapping3d/surface/texture_charts.hpp"

namespace marco::mapping3d {
namespace {

constexpr float kFarM = std::numeric_limits<float>::max();
constexpr uint8_t kUnseenGrey = 128;

bool usable(const CameraPicture& picture) {
  const CameraModel& camera = picture.camera;
  return camera.width_px > 1 && camera.height_px > 1 && camera.focal_x_px > 0.0 &&
         camera.focal_y_px > 0.0 && picture.world_from_camera.matrix().allFinite() &&
         picture.rgb.size() == 3 * static_cast<std::size_t>(camera.width_px) *
                                   static_cast<std::size_t>(camera.height_px);
}

std::size_t pixel_at(int x, int y, int width) {
  return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
         static_cast<std::size_t>(x);
}

// Calls visit(x, y, weights) for each pixel whose centre lies in a triangle grown by `margin_px`.
template <class Visit>
void for_each_pixel(const std::array<Eigen::Vector2f, 3>& p,
                    int width,
                    int height,
                    float margin_px,
                    const Visit& visit) {
  const auto cross = [](const Eigen::Vector2f& a, const Eigen::Vector2f& b) {
    return a.x() * b.y() - a.y() * b.x();
  };
  const float area = cross(p[1] - p[0], p[2] - p[0]);
  if (std::abs(area) < 1e-9F) return;
  const Eigen::Vector2f low = p[0].cwiseMin(p[1]).cwiseMin(p[2]);
  const Eigen::Vector2f high = p[0].cwiseMax(p[1]).cwiseMax(p[2]);
  const auto first = [&](float value) {
    return std::max(0, static_cast<int>(std::ceil(std::max(-1.0F, value - margin_px))));
  };
  const auto last = [&](float value, int size) {
    return static_cast<int>(std::floor(std::min(static_cast<float>(size - 1), value + margin_px)));
  };
  std::array<float, 3> slack{};  // a margin in pixels as a share of each corner's height
  for (std::size_t i = 0; i < 3; ++i) {
    slack[i] = -margin_px * (p[(i + 1) % 3] - p[(i + 2) % 3]).norm() / std::abs(area);
  }
  for (int y = first(low.y()); y <= last(high.y(), height); ++y) {
    for (int x = first(low.x()); x <= last(high.x(), width); ++x) {
      const Eigen::Vector2f at(static_cast<float>(x), static_cast<float>(y));
      const float b = cross(at - p[0], p[2] - p[0]) / area;
      const float c = cross(p[1] - p[0], at - p[0]) / area;
      const Eigen::Vector3f weights(1.0F - b - c, b, c);
      if (weights[0] < slack[0] || weights[1] < slack[1] || weights[2] < slack[2]) continue;
      visit(x, y, weights);
    }
  }
}

// A picture with the depth buffer of a mesh.
class View {
 public:
  View(const CameraPicture& picture, const TriangleMesh& mesh, const TextureOptions& options)
      : picture_(picture),
        options_(options),
        camera_from_world_(picture.world_from_camera.inverse().cast<float>()),
        centre_m_(picture.world_from_camera.translation().cast<float>()) {
    // The depth buffer is that of an undistorted pinhole, with a margin.
    depths_m_.assign(
        static_cast<std::size_t>(buffer_width()) * static_cast<std::size_t>(buffer_height()),
        kFarM);
    for (const auto& triangle : mesh.triangles) draw(mesh, triangle);
  }

  struct Look {
    Eigen::Vector3f rgb;
    float weight;
  };

  std::optional<Look> look_at(const Eigen::Vector3f& point_m, const Eigen::Vector3f& normal) const {
    const Eigen::Vector3f to_camera = centre_m_ - point_m;
    const float distance_m = to_camera.norm();
    const float cosine = normal.dot(to_camera) / std::max(1e-6F, distance_m);
    if (cosine < min_cosine_) return std::nullopt;
    const Eigen::Vector3f in_camera = camera_from_world_ * point_m;
    if (in_camera.z() < kNearM) return std::nullopt;
    const Eigen::Vector2f ideal = in_camera.head<2>() / in_camera.z();
    const Eigen::Vector2f pixel = distorted(ideal);
    const CameraModel& camera = picture_.camera;
    const Eigen::Vector2f size(static_cast<float>(camera.width_px - 1),
                               static_cast<float>(camera.height_px - 1));
    const float inside_px = std::min(pixel.minCoeff(), (size - pixel).minCoeff());
    if (!(inside_px >= 0.0F) || hidden(ideal, in_camera.z(), cosine)) return std::nullopt;
    const float border_px = static_cast<float>(options_.border_part) * size.x();
    const float fade = border_px > 0.0F ? std::min(1.0F, (inside_px + 0.5F) / border_px) : 1.0F;
    const float merit = fade * cosine * cosine / (distance_m * distance_m);
    return Look{colour(pixel), std::pow(merit, static_cast<float>(options_.best_view_power))};
  }

 private:
  static constexpr float kNearM = 0.05F;  // nearer is the camera's own mount
  static constexpr int kRoomPx = 32;  // beyond the picture's border: what lies there still hides

  int buffer_width() const { return picture_.camera.width_px + 2 * kRoomPx; }
  int buffer_height() const { return picture_.camera.height_px + 2 * kRoomPx; }

  Eigen::Vector2f buffer_place(const Eigen::Vector2f& ideal) const {
    const CameraModel& camera = picture_.camera;
    return {static_cast<float>(camera.focal_x_px) * ideal.x() +
                static_cast<float>(camera.centre_x_px + kRoomPx),
            static_cast<float>(camera.focal_y_px) * ideal.y() +
                static_cast<float>(camera.centre_y_px + kRoomPx)};
  }

  Eigen::Vector2f distorted(const Eigen::Vector2f& ideal) const {
    const CameraModel& camera = picture_.camera;
    const auto r2 = static_cast<double>(ideal.squaredNorm());
    const double factor = 1.0 + r2 * (camera.k1 + r2 * camera.k2);
    return {static_cast<float>(camera.focal_x_px * factor * static_cast<double>(ideal.x()) +
                               camera.centre_x_px),
            static_cast<float>(camera.focal_y_px * factor * static_cast<double>(ideal.y()) +
                               camera.centre_y_px)};
  }

  // Divides triangles that reach behind the camera until their parts do not, or are small.
  void draw(const TriangleMesh& mesh, const std::array<uint32_t, 3>& triangle) {
    std::array<Eigen::Vector3f, 3> corners;
    for (std::size_t i = 0; i < 3; ++i) {
      corners[i] = camera_from_world_ * mesh.vertices_m[triangle[i]];
    }
    draw(corners, 0);
  }
  void draw(const std::array<Eigen::Vector3f, 3>& corners, int deep) {
    const int behind =
        (corners[0].z() < kNearM) + (corners[1].z() < kNearM) + (corners[2].z() < kNearM);
    if (behind == 3) return;
    if (behind > 0) {
      if (deep >= 8) return;
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

  // Occluded at the pixel or at a neighbour, so that the colour of an edge does not bleed.
  bool hidden(const Eigen::Vector2f& ideal, float depth_m, float cosine) const {
    const Eigen::Vector2f place = buffer_place(ideal);
    const int x = static_cast<int>(std::lround(place.x()));
    const int y = static_cast<int>(std::lround(place.y()));
    // The depth of a slanted surface changes within a pixel.
    const float slack_m = static_cast<float>(options_.hidden_m) +
                          2.0F * depth_m / static_cast<float>(picture_.camera.focal_x_px) / cosine;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const int px = x + dx, py = y + dy;
        if (px < 0 || py < 0 || px >= buffer_width() || py >= buffer_height()) return true;
        const float nearest_m = depths_m_[pixel_at(px, py, buffer_width())];
        if (nearest_m + slack_m < depth_m) return true;
      }
    }
    return false;
  }

  Eigen::Vector3f colour(const Eigen::Vector2f& pixel) const {
    const CameraModel& camera = picture_.camera;
    const int x = std::min(static_cast<int>(pixel.x()), camera.width_px - 2);
    const int y = std::min(static_cast<int>(pixel.y()), camera.height_px - 2);
    const float u = pixel.x() - static_cast<float>(x), v = pixel.y() - static_cast<float>(y);
    const auto at = [&](int px, int py) {
      const uint8_t* rgb = &picture_.rgb[3 * static_cast<std::size_t>(py * camera.width_px + px)];
      return Eigen::Vector3f(rgb[0], rgb[1], rgb[2]);
    };
    return (1 - v) * ((1 - u) * at(x, y) + u * at(x + 1, y)) +
           v * ((1 - u) * at(x, y + 1) + u * at(x + 1, y + 1));
  }

  const CameraPicture& picture_;
  const TextureOptions& options_;
  Eigen::Isometry3f camera_from_world_;
  Eigen::Vector3f centre_m_;
  float min_cosine_ = static_cast<float>(std::cos(deg_to_rad(options_.max_incidence_deg)));
  std::vector<float> depths_m_;
};

class Painter {
 public:
  Painter(const std::vector<View>& views, const TextureCharts& charts)
      : views_(views), charts_(charts) {
    const std::size_t texels =
        static_cast<std::size_t>(charts.width_px) * static_cast<std::size_t>(charts.height_px);
    state_.assign(texels, State::empty);
    rgb_.assign(3 * texels, kUnseenGrey);
  }

  void paint(const std::array<uint32_t, 3>& triangle) {
    const auto& v = charts_.mesh.vertices_m;
    const Eigen::Vector3f &a = v[triangle[0]], &b = v[triangle[1]], &c = v[triangle[2]];
    const Eigen::Vector3f normal = (b - a).cross(c - a).normalized();
    const std::array<Eigen::Vector2f, 3> places{charts_.places_px[triangle[0]],
                                                charts_.places_px[triangle[1]],
                                                charts_.places_px[triangle[2]]};
    // First the inside, then a rim for texture filtering.
    for (const bool inside : {true, false}) {
      for_each_pixel(places, charts_.width_px, charts_.height_px, inside ? 0.0F : 1.5F,
                     [&](int x, int y, const Eigen::Vector3f& w) {
                       const auto texel = pixel_at(x, y, charts_.width_px);
                       if (state_[texel] != State::empty && !(inside && rim(texel))) return;
                       set(texel, w[0] * a + w[1] * b + w[2] * c, normal, inside);
                     });
    }
  }

  void finish(TexturedSurface& surface) {
    surface.rgb = std::move(rgb_);
    surface.painted =
        texels_ > 0 ? static_cast<double>(painted_) / static_cast<double>(texels_) : 0.0;
  }

 private:
  enum class State : uint8_t { empty, rim, inside };

  bool rim(std::size_t texel) const { return state_[texel] == State::rim; }
  void set(std::size_t texel,
           const Eigen::Vector3f& point_m,
           const Eigen::Vector3f& normal,
           bool inside) {
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    float weight = 0.0F;
    for (const View& view : views_) {
      const auto look = view.look_at(point_m, normal);
      if (!look) continue;
      sum += look->weight * look->rgb;
      weight += look->weight;
    }
    state_[texel] = inside ? State::inside : State::rim;
    texels_ += inside ? 1 : 0;
    if (!(weight > 0.0F)) return;
    painted_ += inside ? 1 : 0;
    for (int i = 0; i < 3; ++i) {
      rgb_[3 * texel + static_cast<std::size_t>(i)] =
          static_cast<uint8_t>(std::lround(std::clamp(sum[i] / weight, 0.0F, 255.0F)));
    }
  }

  const std::vector<View>& views_;
  const TextureCharts& charts_;
  std::vector<State> state_;
  std::vector<uint8_t> rgb_;
  int64_t texels_ = 0;
  int64_t painted_ = 0;
};

}  // namespace

TexturedSurface paint(const TriangleMesh& mesh,
                      const std::vector<CameraPicture>& pictures,
                      const TextureOptions& options) {
  validate(options, "texture");
  TexturedSurface surface;
  std::vector<View> views;
  for (const CameraPicture& picture : pictures) {
    if (usable(picture)) {
      views.emplace_back(picture, mesh, options);
    } else {
      ++surface.pictures_refused;
    }
  }
  surface.pictures_used = static_cast<int>(views.size());
  const TextureCharts charts = lay_out(mesh, options.texel_m, options.max_atlas_px);
  Painter painter(views, charts);
  for (const auto& triangle : charts.mesh.triangles) painter.paint(triangle);
  painter.finish(surface);
  surface.mesh = charts.mesh;
  surface.width_px = charts.width_px;
  surface.height_px = charts.height_px;
  for (const Eigen::Vector2f& place : charts.places_px) {
    surface.uvs.emplace_back((place.x() + 0.5F) / static_cast<float>(charts.width_px),
                             (place.y() + 0.5F) / static_cast<float>(charts.height_px));
  }
  return surface;
}

}  // namespace marco::mapping3d
