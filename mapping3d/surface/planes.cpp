#include "mapping3d/surface/planes.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "common/linear_algebra.hpp"
#include "common/pose2.hpp"

namespace marco::mapping3d {
namespace {

// The surface within one cell with one main direction.
struct Patch {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< sums while it is gathered
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  double area_m2 = 0.0;
  int region = -1;
};

using Key = std::tuple<int, int, int, int>;  ///< cell, and the axis faced with its sign

struct Region {
  std::vector<const Patch*> patches;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double area_m2 = 0.0;

  void fit() {
    centre.setZero();
    area_m2 = 0.0;
    Eigen::Vector3d facing = Eigen::Vector3d::Zero();
    for (const Patch* patch : patches) {
      centre += patch->area_m2 * patch->centre;
      facing += patch->area_m2 * patch->normal;
      area_m2 += patch->area_m2;
    }
    centre /= area_m2;
    normal = facing.normalized();
    if (patches.size() < 6) return;
    Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
    for (const Patch* patch : patches) {
      const Eigen::Vector3d d = patch->centre - centre;
      moments += patch->area_m2 * d * d.transpose();
    }
    const auto [values, axes] = eigenpairs_of(moments);
    // The tilt of a strip is not observable from its centres; the patches' normals are used.
    if (values(1) < 4.0 * values(0)) return;
    normal = axes.col(0);
    if (normal.dot(facing) < 0.0) normal = -normal;
  }
};

class PlaneFinder {
 public:
  PlaneFinder(const TriangleMesh& mesh, const PlaneOptions& options) : options_(options) {
    validate(options, "planes");
    min_cosine_ = std::cos(deg_to_rad(options.max_turn_deg));
    gather(mesh);
  }

  std::vector<SurfacePlane> run() {
    grow_all();
    merge();
    std::vector<SurfacePlane> planes;
    for (const Region& region : regions_) {
      if (region.area_m2 >= options_.min_area_m2) planes.push_back(describe(region));
    }
    std::sort(planes.begin(), planes.end(),
              [](const SurfacePlane& a, const SurfacePlane& b) { return a.area_m2 > b.area_m2; });
    name_floor(planes);
    return planes;
  }

 private:
  void gather(const TriangleMesh& mesh) {
    for (const auto& t : mesh.triangles) {
      const Eigen::Vector3d a = mesh.vertices_m[t[0]].cast<double>();
      const Eigen::Vector3d b = mesh.vertices_m[t[1]].cast<double>();
      const Eigen::Vector3d c = mesh.vertices_m[t[2]].cast<double>();
      split(a, b, c, 0);
    }
    for (auto& [key, patch] : patches_) {
      const double coherence = patch.normal.norm() / patch.area_m2;
      patch.centre /= patch.area_m2;
      patch.normal.normalize();
      if (coherence < 0.9) patch.region = -2;  // a corner, or no surface at all
    }
  }

  // Halves triangles until they fit into a cell.
  void split(const Eigen::Vector3d& a,
             const Eigen::Vector3d& b,
             const Eigen::Vector3d& c,
             int deep) {
    const double ab = (a - b).norm(), bc = (b - c).norm(), ca = (c - a).norm();
    const double longest = std::max({ab, bc, ca});
    if (longest > options_.cell_m && deep < 24) {
      if (ab == longest) {
        const Eigen::Vector3d m = 0.5 * (a + b);
        split(a, m, c, deep + 1);
        split(m, b, c, deep + 1);
      } else if (bc == longest) {
        split(b, c, a, deep);
      } else {
        split(c, a, b, deep);
      }
      return;
    }
    const Eigen::Vector3d twice = (b - a).cross(c - a);
    const double area_m2 = 0.5 * twice.norm();
    if (!(area_m2 > 0.0)) return;
    const Eigen::Vector3d centre = (a + b + c) / 3.0;
    int axis = 0;
    twice.cwiseAbs().maxCoeff(&axis);
    const auto cell = [&](int i) {
      return static_cast<int>(std::floor(centre[i] / options_.cell_m));
    };
    Patch& patch = patches_[{cell(0), cell(1), cell(2), 2 * axis + (twice[axis] > 0.0 ? 1 : 0)}];
    patch.centre += area_m2 * centre;
    patch.normal += 0.5 * twice;
    patch.area_m2 += area_m2;
  }

  void grow_all() {
    std::vector<std::pair<double, Key>> seeds;
    for (const auto& [key, patch] : patches_) seeds.emplace_back(-patch.area_m2, key);
    std::sort(seeds.begin(), seeds.end());
    for (const auto& [area, key] : seeds) {
      if (patches_.at(key).region == -1) grow(key);
    }
  }

  void grow(const Key& seed) {
    const int number = static_cast<int>(regions_.size());
    Region region;
    std::vector<Key> front{seed};
    patches_.at(seed).region = number;
    region.patches.push_back(&patches_.at(seed));
    region.fit();
    std::size_t fitted = 1;
    for (std::size_t next = 0; next < front.size(); ++next) {
      const auto [x, y, z, facing] = front[next];
      for (int i = 0; i < 27; ++i) {
        const Key key{x + i % 3 - 1, y + i / 3 % 3 - 1, z + i / 9 - 1, facing};
        const auto found = patches_.find(key);
        if (found == patches_.end() || found->second.region != -1) continue;
        if (!agrees(region, found->second)) continue;
        found->second.region = number;
        region.patches.push_back(&found->second);
        front.push_back(key);
      }
      if (2 * region.patches.size() > 3 * fitted) {
        region.fit();
        fitted = region.patches.size();
      }
    }
    region.fit();
    regions_.push_back(std::move(region));
  }

  bool agrees(const Region& region, const Patch& patch) const {
    return region.normal.dot(patch.normal) > min_cosine_ &&
           std::abs(region.normal.dot(patch.centre - region.centre)) < options_.max_gap_m;
  }

  // Coplanar: the patches of each lie on the plane of the other.
  void merge() {
    std::sort(regions_.begin(), regions_.end(),
              [](const Region& a, const Region& b) { return a.area_m2 > b.area_m2; });
    std::vector<Region> kept;
    for (Region& part : regions_) {
      if (part.area_m2 < 0.25 * options_.min_area_m2) continue;
      const auto whole = std::find_if(kept.begin(), kept.end(), [&](const Region& of) {
        const auto on = [&](const Patch* patch) { return agrees(of, *patch); };
        return of.normal.dot(part.normal) > min_cosine_ &&
               10 * std::count_if(part.patches.begin(), part.patches.end(), on) >=
                   static_cast<std::ptrdiff_t>(9 * part.patches.size());
      });
      if (whole == kept.end()) {
        kept.push_back(std::move(part));
      } else {
        whole->patches.insert(whole->patches.end(), part.patches.begin(), part.patches.end());
        whole->fit();
      }
    }
    regions_ = std::move(kept);
  }

  SurfacePlane describe(const Region& region) const {
    SurfacePlane plane;
    plane.normal = region.normal;
    plane.centre_m = region.centre;
    plane.offset_m = region.normal.dot(region.centre);
    plane.area_m2 = region.area_m2;
    const bool level = std::abs(region.normal.z()) > 0.9;
    const Eigen::Vector3d reference = level ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitZ();
    plane.along = level ? (reference - region.normal * region.normal.dot(reference)).normalized()
                        : reference.cross(region.normal).normalized();
    plane.across = plane.normal.cross(plane.along);
    plane.low_m = Eigen::Vector2d::Constant(1e9);
    plane.high_m = -plane.low_m;
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
    double squares = 0.0;
    for (const Patch* patch : region.patches) {
      const Eigen::Vector3d d = patch->centre - region.centre;
      const Eigen::Vector2d at(plane.along.dot(d), plane.across.dot(d));
      const Eigen::Vector2d margin = Eigen::Vector2d::Constant(0.5 * options_.cell_m);
      plane.low_m = plane.low_m.cwiseMin(at - margin);
      plane.high_m = plane.high_m.cwiseMax(at + margin);
      const Eigen::Vector3d row(1.0, at.x(), at.y());
      const double weight = patch->area_m2 / (options_.cell_m * options_.cell_m);
      information += weight * row * row.transpose();
      squares += patch->area_m2 * std::pow(region.normal.dot(d), 2);
    }
    plane.rms_m = std::sqrt(squares / region.area_m2);
    const double sigma_m = std::max(plane.rms_m, 1e-4);
    plane.covariance = sigma_m * sigma_m * information.inverse();
    const double level_sine = std::sin(deg_to_rad(options_.level_deg));
    if (std::abs(region.normal.z()) < level_sine) plane.kind = SurfacePlane::Kind::wall;
    if (std::abs(region.normal.z()) > std::cos(deg_to_rad(options_.level_deg))) {
      plane.kind = SurfacePlane::Kind::level;
    }
    return plane;
  }

  static void name_floor(std::vector<SurfacePlane>& planes) {
    double area_m2 = 0.0, mean_z_m = 0.0;
    for (const SurfacePlane& plane : planes) {
      area_m2 += plane.area_m2;
      mean_z_m += plane.area_m2 * plane.centre_m.z();
    }
    mean_z_m /= std::max(1e-9, area_m2);
    const auto name = [&](bool up, SurfacePlane::Kind kind) {
      for (SurfacePlane& plane : planes) {  // largest first
        if (plane.kind != SurfacePlane::Kind::level || (plane.normal.z() > 0.0) != up) continue;
        if ((plane.centre_m.z() < mean_z_m) != up) continue;
        plane.kind = kind;
        return;
      }
    };
    name(true, SurfacePlane::Kind::floor);
    name(false, SurfacePlane::Kind::ceiling);
  }

  PlaneOptions options_;
  double min_cosine_ = 1.0;
  std::map<Key, Patch> patches_;
  std::vector<Region> regions_;
};

}  // namespace

std::vector<SurfacePlane> find_planes(const TriangleMesh& mesh, const PlaneOptions& options) {
  return PlaneFinder(mesh, options).run();
}

}  // namespace marco::mapping3d
