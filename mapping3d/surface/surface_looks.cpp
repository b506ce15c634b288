#include "mapping3d/surface/surface_looks.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/mesh_samples.hpp"

namespace marco::mapping3d {
namespace {

constexpr std::size_t kMostLooks = 16;  // a vote costs their square
constexpr float kPointsApartM = 0.05F;  // two texels and more; 36 points a cell of LocalGains
constexpr float kMostPoints = 400e3F;   // bounds memory

float difference(const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
  return (a - b).cwiseAbs().maxCoeff();
}

// The one whose colour differs least from all others' in sum.
std::size_t spokesman(std::span<const Look> looks) {
  std::size_t best = 0;
  float least = std::numeric_limits<float>::max();
  for (std::size_t i = 0; i < looks.size(); ++i) {
    float sum = 0.0F;
    for (const Look& other : looks) sum += difference(looks[i].rgb, other.rgb);
    if (sum < least) {
      least = sum;
      best = i;
    }
  }
  return best;
}

}  // namespace

Facet::Facet(const TriangleMesh& mesh, const std::array<uint32_t, 3>& triangle)
    : corners_m{mesh.vertices_m[triangle[0]], mesh.vertices_m[triangle[1]],
                mesh.vertices_m[triangle[2]]},
      normal((corners_m[1] - corners_m[0]).cross(corners_m[2] - corners_m[0]).normalized()) {}

int Facet::facing() const {
  int axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  return 2 * axis + (normal[axis] > 0.0F ? 1 : 0);
}

void look_from_all(const std::vector<const TextureView*>& views,
                   const Eigen::Vector3f& point_m,
                   const Eigen::Vector3f& normal,
                   std::vector<Look>& looks) {
  looks.clear();
  for (const TextureView* view : views) {
    if (const auto look = view->look_at(point_m, normal)) looks.push_back(*look);
  }
  if (looks.size() <= kMostLooks) return;
  std::stable_sort(looks.begin(), looks.end(),
                   [](const Look& a, const Look& b) { return a.merit > b.merit; });
  looks.resize(kMostLooks);
}

void choose_views(const std::vector<TextureView>& views,
                  const Facet& facet,
                  std::vector<const TextureView*>& chosen) {
  chosen.clear();
  for (const TextureView& view : views) {
    if (view.may_see(facet.corners_m)) chosen.push_back(&view);
  }
}

SurfaceLooks look_at_surface(const TriangleMesh& mesh, const std::vector<TextureView>& views) {
  SurfaceLooks seen;
  const auto area_m2 = static_cast<float>(surface_area_m2(mesh));
  const float area_each_m2 = std::max(kPointsApartM * kPointsApartM, area_m2 / kMostPoints);
  seen.apart_m = std::sqrt(area_each_m2);
  std::size_t last = mesh.triangles.size();
  Eigen::Vector3f normal;
  int facing = 0;
  std::vector<const TextureView*> chosen;
  std::vector<Look> looks;
  for_each_sample(mesh, area_each_m2, [&](const Eigen::Vector3f& point_m, std::size_t t) {
    if (t != last) {
      const Facet facet(mesh, mesh.triangles[t]);
      choose_views(views, facet, chosen);
      normal = facet.normal;
      facing = facet.facing();
      last = t;
    }
    look_from_all(chosen, point_m, normal, looks);
    seen.points.push_back({point_m, facing, seen.looks.size(), looks.size()});
    seen.looks.insert(seen.looks.end(), looks.begin(), looks.end());
  });
  return seen;
}

bool vote(std::span<const Look> looks, std::vector<float>& shares) {
  shares.assign(looks.size(), 1.0F);
  if (looks.size() < 2) return true;
  return 2 * side_with(looks[spokesman(looks)].rgb, looks, shares) > looks.size();
}

std::size_t side_with(const Eigen::Vector3f& rgb,
                      std::span<const Look> looks,
                      std::vector<float>& shares) {
  constexpr float kDiffersLevels = 10.0F;  // noise, JPEG
  constexpr float kDiffersPart = 0.33F;    // light that depends on the view
  const float limit = kDiffersLevels + kDiffersPart * rgb.maxCoeff();
  shares.assign(looks.size(), 1.0F);
  std::size_t agree = 0;
  for (std::size_t i = 0; i < looks.size(); ++i) {
    const float off = std::min(1.0F, difference(looks[i].rgb, rgb) / limit);
    shares[i] = (1.0F - off * off) * (1.0F - off * off);
    agree += off < 1.0F ? 1 : 0;
  }
  if (agree == 0) shares.assign(looks.size(), 1.0F);
  return agree;
}

}  // namespace marco::mapping3d
