#include "mapping3d/surface/texture_charts.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <unordered_map>

#include "common/mesh_samples.hpp"
#include "lcm_tools/base/check.hpp"

namespace marco::mapping3d {
namespace {

constexpr int kGapPx =
    3;  // between charts: a renderer mixes neighbouring texels, twice over in a smaller copy
constexpr uint32_t kNone = std::numeric_limits<uint32_t>::max();

struct Chart {
  int axis = 0;
  std::vector<uint32_t> triangles;
  Eigen::Vector2f low_m = Eigen::Vector2f::Zero();
  Eigen::Vector2i size_px = Eigen::Vector2i::Zero();
  Eigen::Vector2i at_px = Eigen::Vector2i::Zero();
};

Eigen::Vector2f flat(const Eigen::Vector3f& point, int axis) {
  return {point[(axis + 1) % 3], point[(axis + 2) % 3]};
}

uint64_t pair_key(uint32_t a, uint32_t b) {
  return (static_cast<uint64_t>(std::min(a, b)) << 32U) | std::max(a, b);
}

class Charts {
 public:
  Charts(const TriangleMesh& mesh, double cell_m)
      : mesh_(mesh), cell_m_(static_cast<float>(cell_m)) {
    for (const auto& t : mesh.triangles) {
      const auto& v = mesh.vertices_m;
      const Eigen::Vector3f normal = (v[t[1]] - v[t[0]]).cross(v[t[2]] - v[t[0]]);
      int axis = 0;
      normal.cwiseAbs().maxCoeff(&axis);
      facing_.push_back(2 * axis + (normal[axis] > 0.0F ? 1 : 0));
    }
    join_neighbours();
  }

  std::vector<Chart> run() {
    std::vector<Chart> charts;
    done_.assign(mesh_.triangles.size(), 0);
    for (uint32_t seed = 0; seed < mesh_.triangles.size(); ++seed) {
      if (done_[seed] == 0) charts.push_back(grow(seed));
    }
    return charts;
  }

 private:
  void join_neighbours() {
    neighbours_.assign(mesh_.triangles.size(), {kNone, kNone, kNone});
    std::unordered_map<uint64_t, std::pair<uint32_t, uint32_t>> open;  // triangle, side
    for (uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
      for (uint32_t side = 0; side < 3; ++side) {
        const auto& corners = mesh_.triangles[t];
        const uint64_t key = pair_key(corners[side], corners[(side + 1) % 3]);
        const auto [entry, is_new] = open.try_emplace(key, t, side);
        if (is_new) continue;
        neighbours_[t][side] = entry->second.first;
        neighbours_[entry->second.first][entry->second.second] = t;
      }
    }
  }

  // The centres of the cells that a triangle covers in its chart's plane.
  template <class Visit>
  void for_each_cell(uint32_t t, int axis, const Visit& visit) const {
    const auto& corners = mesh_.triangles[t];
    const Eigen::Vector2f a = flat(mesh_.vertices_m[corners[0]], axis) / cell_m_;
    const Eigen::Vector2f b = flat(mesh_.vertices_m[corners[1]], axis) / cell_m_;
    const Eigen::Vector2f c = flat(mesh_.vertices_m[corners[2]], axis) / cell_m_;
    const Eigen::Vector2f low = a.cwiseMin(b).cwiseMin(c), high = a.cwiseMax(b).cwiseMax(c);
    const auto cross = [](const Eigen::Vector2f& p, const Eigen::Vector2f& q) {
      return p.x() * q.y() - p.y() * q.x();
    };
    const float area = cross(b - a, c - a);
    for (int y = static_cast<int>(std::floor(low.y())); static_cast<float>(y) <= high.y(); ++y) {
      for (int x = static_cast<int>(std::floor(low.x())); static_cast<float>(x) <= high.x(); ++x) {
        const Eigen::Vector2f p(static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F);
        const float u = cross(p - a, c - a) / area, v = cross(b - a, p - a) / area;
        if (u >= 0.0F && v >= 0.0F && u + v <= 1.0F) visit(x, y);
      }
    }
  }

  Chart grow(uint32_t seed) {
    Chart chart;
    const int facing = facing_[seed];
    chart.axis = facing / 2;
    std::unordered_map<uint64_t, uint64_t> taken;  // a bit for each of 8 x 8 cells
    const auto bit_of = [](int x, int y) { return uint64_t{1} << ((x & 7) | (y & 7) << 3); };
    const auto tile_of = [](int x, int y) {
      return (static_cast<uint64_t>(static_cast<uint32_t>(x >> 3)) << 32U) |
             static_cast<uint32_t>(y >> 3);
    };
    std::vector<uint32_t> front{seed};
    for (std::size_t next = 0; next < front.size(); ++next) {
      const uint32_t t = front[next];
      if (done_[t] != 0) continue;
      bool covers = false;
      for_each_cell(t, chart.axis, [&](int x, int y) {
        if (covers) return;
        const auto tile = taken.find(tile_of(x, y));
        covers = tile != taken.end() && (tile->second & bit_of(x, y)) != 0;
      });
      if (covers) continue;
      for_each_cell(t, chart.axis, [&](int x, int y) { taken[tile_of(x, y)] |= bit_of(x, y); });
      done_[t] = 1;
      chart.triangles.push_back(t);
      for (const uint32_t other : neighbours_[t]) {
        if (other != kNone && done_[other] == 0 && facing_[other] == facing) front.push_back(other);
      }
    }
    return chart;
  }

  const TriangleMesh& mesh_;
  float cell_m_;
  std::vector<int> facing_;
  std::vector<std::array<uint32_t, 3>> neighbours_;
  std::vector<uint8_t> done_;
};

void measure(std::vector<Chart>& charts, const TriangleMesh& mesh, double texel_m) {
  for (Chart& chart : charts) {
    Eigen::Vector2f low = Eigen::Vector2f::Constant(1e9F), high = -low;
    for (const uint32_t t : chart.triangles) {
      for (const uint32_t corner : mesh.triangles[t]) {
        low = low.cwiseMin(flat(mesh.vertices_m[corner], chart.axis));
        high = high.cwiseMax(flat(mesh.vertices_m[corner], chart.axis));
      }
    }
    chart.low_m = low;
    chart.size_px =
        ((high - low) / static_cast<float>(texel_m)).array().ceil().matrix().cast<int>() +
        Eigen::Vector2i::Constant(1 + kGapPx);
  }
}

// Shelf packing, tallest first. @returns the height, or more than `max_px` if they do not fit.
int pack(std::vector<Chart*>& charts, int width_px, int max_px) {
  int x = 0, y = 0, shelf = 0;
  for (Chart* chart : charts) {
    if (chart->size_px.x() > width_px) return max_px + 1;
    if (x + chart->size_px.x() > width_px) {
      x = 0;
      y += shelf;
      shelf = 0;
    }
    chart->at_px = {x, y};
    x += chart->size_px.x();
    shelf = std::max(shelf, chart->size_px.y());
  }
  return y + shelf;
}

}  // namespace

TextureCharts lay_out(const TriangleMesh& mesh, double texel_m, int max_px) {
  TextureCharts result;
  // No smaller than what fits for sure not: a chart of a plane at 55 degrees to all axes has
  // 1 / sqrt(3) of its area.
  texel_m = std::max(texel_m, std::sqrt(surface_area_m2(mesh) / std::sqrt(3.0)) / max_px);
  std::vector<Chart> charts = Charts(mesh, texel_m).run();
  std::vector<Chart*> order;
  order.reserve(charts.size());
  for (Chart& chart : charts) order.push_back(&chart);
  result.texel_m = texel_m;
  for (;;) {
    measure(charts, mesh, result.texel_m);
    std::stable_sort(order.begin(), order.end(), [](const Chart* a, const Chart* b) {
      return a->size_px.y() > b->size_px.y();
    });
    double area_px2 = 0.0;
    int widest = 64;
    for (const Chart& chart : charts) {
      area_px2 += static_cast<double>(chart.size_px.x()) * chart.size_px.y();
      widest = std::max(widest, chart.size_px.x());
    }
    result.width_px =
        std::min(max_px, std::max(widest, static_cast<int>(std::ceil(std::sqrt(1.1 * area_px2)))));
    result.height_px = std::max(1, pack(order, result.width_px, max_px));
    if (result.height_px <= max_px) break;
    constexpr double kLargestM = 1e3;  // every chart is then as small as it gets
    require(result.texel_m < kLargestM,
            "texture: " + std::to_string(charts.size()) +
                " charts do not fit into an atlas of max_atlas_px = " + std::to_string(max_px));
    result.texel_m *= 1.2;
  }
  std::unordered_map<uint32_t, uint32_t> vertex_of;
  for (const Chart& chart : charts) {
    vertex_of.clear();
    for (const uint32_t t : chart.triangles) {
      std::array<uint32_t, 3> triangle{};
      for (std::size_t i = 0; i < 3; ++i) {
        const uint32_t from = mesh.triangles[t][i];
        const auto [entry, is_new] =
            vertex_of.try_emplace(from, static_cast<uint32_t>(result.mesh.vertices_m.size()));
        triangle[i] = entry->second;
        if (!is_new) continue;
        result.mesh.vertices_m.push_back(mesh.vertices_m[from]);
        if (!mesh.normals.empty()) result.mesh.normals.push_back(mesh.normals[from]);
        const Eigen::Vector2f inside = (flat(mesh.vertices_m[from], chart.axis) - chart.low_m) /
                                       static_cast<float>(result.texel_m);
        result.places_px.push_back(chart.at_px.cast<float>() + inside +
                                   Eigen::Vector2f::Constant(0.5F * kGapPx));
      }
      result.mesh.triangles.push_back(triangle);
    }
  }
  return result;
}

}  // namespace marco::mapping3d
