#pragma once

#include <array>
#include <span>
#include <vector>

#include "mapping3d/surface/texture_view.hpp"

namespace marco::mapping3d {

/// A triangle's corners and its unit normal, which is 0 without an area.
struct Facet {
  Facet(const TriangleMesh& mesh, const std::array<uint32_t, 3>& triangle);
  int facing() const;  ///< 2 axis + (looks along it ? 1 : 0), of the axis most like the normal

  std::array<Eigen::Vector3f, 3> corners_m;
  Eigen::Vector3f normal;
};

/// Points spread over a surface, and what the pictures show of them.
struct SurfaceLooks {
  struct Point {
    Eigen::Vector3f at_m;
    int facing = 0;         ///< of its triangle
    std::size_t first = 0;  ///< of its looks
    std::size_t count = 0;  ///< 0 where no picture sees
  };
  std::span<const Look> of(const Point& point) const {
    return std::span<const Look>(looks).subspan(point.first, point.count);
  }
  std::span<Look> of(const Point& point) {
    return std::span<Look>(looks).subspan(point.first, point.count);
  }

  std::vector<Point> points;
  std::vector<Look> looks;
  float apart_m = 0.0F;  ///< of neighbouring points
};

/// The best looks at a point, by merit, at most `kMostLooks`.
void look_from_all(const std::vector<const TextureView*>& views,
                   const Eigen::Vector3f& point_m,
                   const Eigen::Vector3f& normal,
                   std::vector<Look>& looks);

/// The views that may see a facet.
void choose_views(const std::vector<TextureView>& views,
                  const Facet& facet,
                  std::vector<const TextureView*>& chosen);

/// Points about 5 cm apart, farther apart on surfaces of more than 1000 m2: at most 400 000 and
/// one a triangle. Takes up to 352 bytes a point, with 16 looks; twice that while it grows.
SurfaceLooks look_at_surface(const TriangleMesh& mesh, const std::vector<TextureView>& views);

/// Moving things voted out: a share of 0 to 1 for each look. The look that is nearest to all others
/// speaks for the majority (side_with). As in Waechter, Moehrle and Goesele, Let There Be Color!,
/// ECCV 2014, section 3.2 (photo-consistency check), the majority of the colours decides; they fit
/// a Gaussian to mean colours of whole triangles. @returns whether more than half of the looks
/// agree; otherwise the shares mean nothing
bool vote(std::span<const Look> looks, std::vector<float>& shares);

/// The share of a look is the less the more it differs from a colour, and 0 beyond 10 grey levels
/// and a third of its brightness (Tukey's biweight). Where none is nearer all have 1.
/// @returns how many are nearer
std::size_t side_with(const Eigen::Vector3f& rgb,
                      std::span<const Look> looks,
                      std::vector<float>& shares);

}  // namespace marco::mapping3d
