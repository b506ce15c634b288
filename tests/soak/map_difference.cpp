// How far apart the last GRID_MAP of two logs are: of each map's occupied cells the distance to the
// other's nearest, where the other has looked.
//   map_difference A.lcm B.lcm   prints "median 0.00 p95 0.05 p99 0.10 cells 1234 1230, of B alone
//   p95 0.05 p99 0.07" (B's cells to A's: what B has is right); exit 1 where a log has no map.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/event_log.hpp"
#include "lcm_tools/process/arguments.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "marco/sim_fault_t.hpp"

namespace marco {
namespace {

using Points = std::vector<Eigen::Vector2d>;

struct Tile {
  Points occupied_m;
  Points known_m;
};

struct Map {
  Points occupied_m;
  std::set<std::pair<int64_t, int64_t>> known;  ///< cells

  static std::pair<int64_t, int64_t> cell(const Eigen::Vector2d& at_m) {
    constexpr double kCellM = 0.05;
    return {std::llround(std::floor(at_m.x() / kCellM)),
            std::llround(std::floor(at_m.y() / kCellM))};
  }
};

/// Of the last revision that is complete, or of what came of the last one.
Map last_map(const std::string& path) {
  files::EventLogReader log(path);
  // Of each its tiles by where they lie: one that is sent again takes the place of the one before.
  std::map<int64_t, std::map<std::pair<double, double>, Tile>> revisions;
  while (const auto event = log.next()) {
    if (event->channel != channels::kGridMap) continue;
    grid_map_t message{};
    if (message.decode(event->bytes.data(), 0, static_cast<int>(event->bytes.size())) <= 0)
      continue;
    const GridMap tile = from_message(message);
    Tile& kept = revisions[message.revision][{tile.origin_m.x(), tile.origin_m.y()}];
    kept = {};
    for (int y = 0; y < tile.height_cells; ++y) {
      for (int x = 0; x < tile.width_cells; ++x) {
        if (tile.at(x, y) == GridMap::kUnknown) continue;
        kept.known_m.push_back(tile.origin_m +
                               tile.resolution_m * Eigen::Vector2d(x + 0.5, y + 0.5));
        if (tile.at(x, y) >= 65) kept.occupied_m.push_back(kept.known_m.back());
      }
    }
    if (revisions.size() > 3) revisions.erase(revisions.begin());
  }
  Map map;
  if (revisions.empty()) return map;
  for (const auto& [origin_m, tile] : revisions.rbegin()->second) {
    map.occupied_m.insert(map.occupied_m.end(), tile.occupied_m.begin(), tile.occupied_m.end());
    for (const Eigen::Vector2d& at_m : tile.known_m) map.known.insert(Map::cell(at_m));
  }
  return map;
}

void add_distances(const Map& from, const Map& to, std::vector<double>& out) {
  for (const Eigen::Vector2d& point : from.occupied_m) {
    if (!to.known.contains(Map::cell(point))) continue;
    double nearest = HUGE_VAL;
    for (const Eigen::Vector2d& other : to.occupied_m) {
      nearest = std::min(nearest, (point - other).squaredNorm());
    }
    out.push_back(std::sqrt(nearest));
  }
}

int run(const std::string& a, const std::string& b) {
  const Map one = last_map(a), other = last_map(b);
  if (one.occupied_m.empty() || other.occupied_m.empty()) {
    std::printf("no map in %s\n", one.occupied_m.empty() ? a.c_str() : b.c_str());
    return 1;
  }
  std::vector<double> both_m, of_other_m;
  add_distances(other, one, of_other_m);
  both_m = of_other_m;
  add_distances(one, other, both_m);
  const auto part = [](std::vector<double>& distances_m, double p) {
    const auto at = static_cast<std::ptrdiff_t>(p * static_cast<double>(distances_m.size() - 1));
    std::nth_element(distances_m.begin(), distances_m.begin() + at, distances_m.end());
    return distances_m[static_cast<std::size_t>(at)];
  };
  std::printf("median %.3f p95 %.3f p99 %.3f cells %zu %zu, of B alone p95 %.3f p99 %.3f\n",
              part(both_m, 0.5), part(both_m, 0.95), part(both_m, 0.99), one.occupied_m.size(),
              other.occupied_m.size(), part(of_other_m, 0.95), part(of_other_m, 0.99));
  return 0;
}

}  // namespace
}  // namespace marco

int main(int argc, char** argv) {
  return marco::process::run_main("map_difference", [&] {
    if (argc == 2 && std::string(argv[1]) == "--fault-fingerprint") {
      std::printf("%016llx\n", static_cast<unsigned long long>(marco::sim_fault_t::getHash()));
      return 0;
    }
    marco::require(argc == 3, "usage: map_difference A.lcm B.lcm");
    return marco::run(argv[1], argv[2]);
  });
}
