#include "mapping3d/surface/texture.hpp"

#include <algorithm>
#include <cmath>

#include "mapping3d/surface/local_gains.hpp"
#include "mapping3d/surface/picture_gains.hpp"
#include "mapping3d/surface/surface_looks.hpp"
#include "mapping3d/surface/texture_charts.hpp"
#include "mapping3d/surface/texture_raster.hpp"
#include "mapping3d/surface/texture_view.hpp"

namespace marco::mapping3d {
namespace {

constexpr uint8_t kBetweenCharts = 128;
// Exponent of the merit. Between two views the better one counts alone but for a seam of some
// centimetres, so narrow that a pattern which both show a pixel or two apart is not seen twice.
constexpr float kSharpness = 24.0F;

bool usable(const CameraPicture& picture) {
  const CameraModel& camera = picture.camera;
  return camera.width_px > 1 && camera.height_px > 1 && camera.focal_x_px > 0.0 &&
         camera.focal_y_px > 0.0 && picture.world_from_camera.matrix().allFinite() &&
         picture.rgb.size() == 3 * static_cast<std::size_t>(camera.width_px) *
                                   static_cast<std::size_t>(camera.height_px);
}

void multiply(std::span<Look> looks, const std::vector<Eigen::Vector3f>& gains) {
  for (Look& look : looks) look.rgb = look.rgb.cwiseProduct(gains[look.view]);
}

class Painter {
 public:
  Painter(const std::vector<TextureView>& views,
          const std::vector<Eigen::Vector3f>& gains,
          const LocalGains& local_gains,
          const TextureCharts& charts)
      : views_(views), gains_(gains), local_gains_(local_gains), charts_(charts) {
    const std::size_t texels =
        static_cast<std::size_t>(charts.width_px) * static_cast<std::size_t>(charts.height_px);
    state_.assign(texels, State::empty);
    rgb_.assign(3 * texels, kBetweenCharts);
  }

  void paint(const std::array<uint32_t, 3>& triangle) {
    const Facet facet(charts_.mesh, triangle);
    const auto& [a, b, c] = facet.corners_m;
    choose_views(views_, facet, chosen_);
    const std::array<Eigen::Vector2f, 3> places{charts_.places_px[triangle[0]],
                                                charts_.places_px[triangle[1]],
                                                charts_.places_px[triangle[2]]};
    // First the inside, then a rim for texture filtering.
    for (const bool inside : {true, false}) {
      for_each_pixel(
          places, charts_.width_px, charts_.height_px, inside ? 0.0F : 1.5F,
          [&, &a = a, &b = b, &c = c](int x, int y, const Eigen::Vector3f& w) {
            const auto texel = pixel_at(x, y, charts_.width_px);
            if (state_[texel] != State::empty && !(inside && state_[texel] == State::rim)) return;
            state_[texel] = inside ? State::inside : State::rim;
            set(texel, w[0] * a + w[1] * b + w[2] * c, facet);
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

  void set(std::size_t texel, const Eigen::Vector3f& point_m, const Facet& facet) {
    look_from_all(chosen_, point_m, facet.normal, looks_);
    const bool inside = state_[texel] == State::inside;
    texels_ += inside ? 1 : 0;
    painted_ += inside && !looks_.empty() ? 1 : 0;
    const LocalGains::Place place = local_gains_.at(point_m, facet.facing());
    const Eigen::Vector3f colour = looks_.empty() ? place.colour() : blend(place);
    for (int i = 0; i < 3; ++i) {
      rgb_[3 * texel + static_cast<std::size_t>(i)] =
          static_cast<uint8_t>(std::lround(std::clamp(colour[i], 0.0F, 255.0F)));
    }
  }

  Eigen::Vector3f blend(const LocalGains::Place& place) {
    multiply(looks_, gains_);
    for (Look& look : looks_) look.rgb = look.rgb.cwiseProduct(place.gain(look.view));
    // Where two pictures contradict each other, the surface around decides.
    if (!vote(looks_, shares_)) {
      if (place.reached()) {
        side_with(place.colour(), looks_, shares_);
      } else {
        shares_.assign(looks_.size(), 1.0F);
      }
    }
    float best = 0.0F;
    for (std::size_t i = 0; i < looks_.size(); ++i) {
      best = std::max(best, shares_[i] * looks_[i].merit);
    }
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    float weights = 0.0F;
    for (std::size_t i = 0; i < looks_.size(); ++i) {
      const float weight = std::pow(shares_[i] * looks_[i].merit / best, kSharpness);
      sum += weight * looks_[i].rgb;
      weights += weight;
    }
    return sum / weights;
  }

  const std::vector<TextureView>& views_;
  const std::vector<Eigen::Vector3f>& gains_;
  const LocalGains& local_gains_;
  const TextureCharts& charts_;
  std::vector<State> state_;
  std::vector<uint8_t> rgb_;
  int64_t texels_ = 0;
  int64_t painted_ = 0;
  std::vector<const TextureView*> chosen_;
  std::vector<Look> looks_;
  std::vector<float> shares_;
};

}  // namespace

TexturedSurface paint(const TriangleMesh& mesh,
                      const std::vector<CameraPicture>& pictures,
                      const TextureOptions& options) {
  validate(options, "texture");
  TexturedSurface surface;
  std::vector<TextureView> views;
  for (const CameraPicture& picture : pictures) {
    if (usable(picture)) {
      views.emplace_back(picture, mesh, options, static_cast<uint32_t>(views.size()));
    } else {
      ++surface.pictures_refused;
    }
  }
  surface.pictures_used = static_cast<int>(views.size());
  SurfaceLooks seen = look_at_surface(mesh, views);
  surface.gains = picture_gains(seen, views.size());
  multiply(seen.looks, surface.gains);
  const LocalGains local_gains(seen);
  const TextureCharts charts = lay_out(mesh, options.texel_m, options.max_atlas_px);
  Painter painter(views, surface.gains, local_gains, charts);
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
