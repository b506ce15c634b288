#include "mapping3d/surface/floor_plan.hpp"

#include <algorithm>
#include <map>

namespace marco::mapping3d {
namespace {

// A corner of the cut, named by the edge of the mesh that it lies on, so that chains meet exactly.
using EdgeKey = std::pair<uint32_t, uint32_t>;

}  // namespace

std::vector<std::vector<Eigen::Vector2d>> cut_at(const TriangleMesh& mesh, double height_m) {
  const auto above = [&](uint32_t v) {
    return static_cast<double>(mesh.vertices_m[v].z()) >= height_m;
  };
  std::map<EdgeKey, std::vector<EdgeKey>> neighbours;
  for (const auto& t : mesh.triangles) {
    std::vector<EdgeKey> ends;
    for (std::size_t i = 0; i < 3; ++i) {
      const uint32_t a = t[i], b = t[(i + 1) % 3];
      if (above(a) != above(b)) ends.emplace_back(std::min(a, b), std::max(a, b));
    }
    if (ends.size() != 2) continue;
    neighbours[ends[0]].push_back(ends[1]);
    neighbours[ends[1]].push_back(ends[0]);
  }
  const auto place = [&](const EdgeKey& edge) -> Eigen::Vector2d {
    const Eigen::Vector3d a = mesh.vertices_m[edge.first].cast<double>();
    const Eigen::Vector3d b = mesh.vertices_m[edge.second].cast<double>();
    return (a + (height_m - a.z()) / (b.z() - a.z()) * (b - a)).head<2>();
  };
  std::vector<std::vector<Eigen::Vector2d>> chains;
  const auto follow = [&](EdgeKey at) {
    std::vector<Eigen::Vector2d> chain{place(at)};
    while (!neighbours[at].empty()) {
      const EdgeKey next = neighbours[at].back();
      neighbours[at].pop_back();
      auto& back = neighbours[next];
      back.erase(std::find(back.begin(), back.end(), at));
      chain.push_back(place(next));
      at = next;
    }
    if (chain.size() > 1) chains.push_back(std::move(chain));
  };
  // Open chains, from their ends, before closed ones.
  for (const auto& [edge, others] : neighbours) {
    if (others.size() == 1) follow(edge);
  }
  for (const auto& [edge, others] : neighbours) {
    if (!others.empty()) follow(edge);
  }
  return chains;
}

}  // namespace marco::mapping3d
