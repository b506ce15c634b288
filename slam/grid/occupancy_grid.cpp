#include "slam/grid/occupancy_grid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lcm_tools/base/check.hpp"

namespace marco::slam {
namespace {

float log_odds(double probability) {
  return static_cast<float>(std::log(probability / (1.0 - probability)));
}

uint64_t tile_key(int x_tile, int y_tile) {
  return (static_cast<uint64_t>(static_cast<uint32_t>(x_tile)) << 32U) |
         static_cast<uint32_t>(y_tile);
}

}  // namespace

OccupancyGrid::OccupancyGrid(const OccupancyGridOptions& options)
    : options_(options),
      hit_log_odds_(log_odds(options.hit_probability)),
      miss_log_odds_(log_odds(options.miss_probability)),
      min_log_odds_(log_odds(options.min_probability)),
      max_log_odds_(log_odds(options.max_probability)) {
  validate(options, "grid");
}

OccupancyGrid::~OccupancyGrid() = default;
OccupancyGrid::OccupancyGrid(OccupancyGrid&&) noexcept = default;
OccupancyGrid& OccupancyGrid::operator=(OccupancyGrid&&) noexcept = default;

void OccupancyGrid::clear() {
  tiles_.clear();
  last_key_.reset();
  scan_ = 0;
  cells_.reset();
  too_large_m_.reset();
}

OccupancyGrid::Cell* OccupancyGrid::cell_at(int x_cell, int y_cell) {
  const uint64_t key = tile_key(x_cell >> kTileBits, y_cell >> kTileBits);
  if (key != last_key_) {
    last_key_ = key;
    last_tile_ = nullptr;
    if (only_ == nullptr || only_->contains(key)) {
      std::unique_ptr<Tile>& tile = tiles_[key];
      if (!tile) tile = std::make_unique<Tile>();
      last_tile_ = tile.get();
    }
  }
  if (last_tile_ == nullptr) return nullptr;
  return &last_tile_->cells[within_tile(x_cell, y_cell)];
}

int OccupancyGrid::tile_of(double coordinate_m) const {
  return static_cast<int>(std::floor(coordinate_m / options_.resolution_m)) >> kTileBits;
}

std::size_t OccupancyGrid::within_tile(int x_cell, int y_cell) {
  const auto x = static_cast<std::size_t>(x_cell & (kTileCells - 1));
  return static_cast<std::size_t>(y_cell & (kTileCells - 1)) * kTileCells + x;
}

OccupancyGrid::TileBox OccupancyGrid::box_of(const Points2& hits_in_world,
                                             const Eigen::Vector2d& sensor_in_world) const {
  Eigen::Vector2d min = sensor_in_world, max = sensor_in_world;
  if (hits_in_world.cols() > 0) {
    min = min.cwiseMin(hits_in_world.rowwise().minCoeff());
    max = max.cwiseMax(hits_in_world.rowwise().maxCoeff());
  }
  return {{tile_of(min.x()), tile_of(min.y())}, {tile_of(max.x()), tile_of(max.y())}};
}

void OccupancyGrid::add(const TileBox& box, Tiles& tiles) {
  for (int y = box.min.y(); y <= box.max.y(); ++y) {
    for (int x = box.min.x(); x <= box.max.x(); ++x) tiles.insert(tile_key(x, y));
  }
}

bool OccupancyGrid::touches(const TileBox& box, const Tiles& tiles) {
  for (int y = box.min.y(); y <= box.max.y(); ++y) {
    for (int x = box.min.x(); x <= box.max.x(); ++x) {
      if (tiles.contains(tile_key(x, y))) return true;
    }
  }
  return false;
}

void OccupancyGrid::insert_in(const Tiles& tiles,
                              const Points2& hits_in_world,
                              const Eigen::Vector2d& sensor_in_world) {
  require(hits_in_world.allFinite() && sensor_in_world.allFinite(),
          "OccupancyGrid: a point is not finite");
  only_ = &tiles;
  last_key_.reset();
  draw(hits_in_world, sensor_in_world);
  only_ = nullptr;
  last_key_.reset();
}

void OccupancyGrid::replace(const Tiles& tiles, OccupancyGrid other) {
  last_key_.reset();
  for (const uint64_t key : tiles) {
    const auto drawn = other.tiles_.find(key);
    if (drawn == other.tiles_.end()) {
      tiles_.erase(key);
      continue;
    }
    // Scan numbers of `other` mean nothing here.
    for (Cell& cell : drawn->second->cells) cell.last_scan = cell.last_scan == 0 ? 0 : 1;
    tiles_[key] = std::move(drawn->second);
  }
  scan_ = std::max(scan_, 1U);
  cells_ = other.cells_;
}

const OccupancyGrid::Cell* OccupancyGrid::find_cell(int x_cell, int y_cell) const {
  const auto tile = tiles_.find(tile_key(x_cell >> kTileBits, y_cell >> kTileBits));
  if (tile == tiles_.end()) return nullptr;
  return &tile->second->cells[within_tile(x_cell, y_cell)];
}

void OccupancyGrid::insert(const Points2& hits_in_world, const Eigen::Vector2d& sensor_in_world) {
  require(hits_in_world.allFinite() && sensor_in_world.allFinite(),
          "OccupancyGrid: a point is not finite");
  draw(hits_in_world, sensor_in_world);
}

bool OccupancyGrid::make_room(const Eigen::Vector2d& at_cells) {
  const Eigen::Array2d cell = at_cells.array().floor();
  if (cells_ && cell.x() >= cells_->min.x() && cell.x() <= cells_->max.x() &&
      cell.y() >= cells_->min.y() && cell.y() <= cells_->max.y()) {
    return true;
  }
  Eigen::Array2d min = cell, max = cell;
  if (cells_) {
    min = min.min(cells_->min.cast<double>());
    max = max.max(cells_->max.cast<double>());
  }
  const Eigen::Array2d size = max - min + 1.0;
  constexpr double kFarthestCell = 1e9;  // fits an int
  if (size.prod() > static_cast<double>(kMostCells) ||
      size.maxCoeff() > static_cast<double>(kLongestSide) || (cell.abs() > kFarthestCell).any()) {
    const Eigen::Vector2d size_m = options_.resolution_m * size.matrix();
    too_large_m_ = too_large_m_ ? too_large_m_->cwiseMax(size_m) : size_m;
    return false;
  }
  cells_ = TileBox{min.cast<int>(), max.cast<int>()};
  return true;
}

void OccupancyGrid::draw(const Points2& hits_in_world, const Eigen::Vector2d& sensor_in_world) {
  const double scale = 1.0 / options_.resolution_m;
  const Eigen::Vector2d from = sensor_in_world * scale;
  if (!make_room(from)) return;
  ++scan_;
  for (Eigen::Index i = 0; i < hits_in_world.cols(); ++i) {
    const Eigen::Vector2d hit = hits_in_world.col(i) * scale;
    if (!make_room(hit)) continue;
    Cell* cell =
        cell_at(static_cast<int>(std::floor(hit.x())), static_cast<int>(std::floor(hit.y())));
    if (cell == nullptr || cell->last_scan == scan_) continue;
    cell->last_scan = scan_;
    cell->log_odds = std::min(cell->log_odds + hit_log_odds_, max_log_odds_);
  }
  for (Eigen::Index i = 0; i < hits_in_world.cols(); ++i) {
    if (!make_room(hits_in_world.col(i) * scale)) continue;
    const Eigen::Vector2d beam_m = hits_in_world.col(i) - sensor_in_world;
    const double part = std::min(1.0, options_.max_free_range_m / std::max(beam_m.norm(), 1e-9));
    clear_along(from, (sensor_in_world + part * beam_m) * scale);
  }
}

void OccupancyGrid::clear_along(const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  // Every cell the beam crosses, the last one excepted (Amanatides & Woo 1987).
  int x = static_cast<int>(std::floor(from.x())), y = static_cast<int>(std::floor(from.y()));
  const int end_x = static_cast<int>(std::floor(to.x()));
  const int end_y = static_cast<int>(std::floor(to.y()));
  const Eigen::Vector2d beam = to - from;
  const int step_x = beam.x() > 0 ? 1 : -1, step_y = beam.y() > 0 ? 1 : -1;
  constexpr double kNever = std::numeric_limits<double>::infinity();
  const double per_x = beam.x() != 0.0 ? std::abs(1.0 / beam.x()) : kNever;
  const double per_y = beam.y() != 0.0 ? std::abs(1.0 / beam.y()) : kNever;
  double next_x = beam.x() != 0.0 ? (step_x > 0 ? x + 1 - from.x() : from.x() - x) * per_x : kNever;
  double next_y = beam.y() != 0.0 ? (step_y > 0 ? y + 1 - from.y() : from.y() - y) * per_y : kNever;
  const int count = std::abs(end_x - x) + std::abs(end_y - y);
  for (int i = 0; i < count; ++i) {
    Cell* cell = cell_at(x, y);
    if (cell != nullptr && cell->last_scan != scan_) {
      cell->last_scan = scan_;
      cell->log_odds = std::max(cell->log_odds + miss_log_odds_, min_log_odds_);
    }
    if (next_x < next_y) {
      x += step_x;
      next_x += per_x;
    } else {
      y += step_y;
      next_y += per_y;
    }
  }
}

double OccupancyGrid::probability(const Eigen::Vector2d& point_in_world) const {
  const Eigen::Vector2d scaled = point_in_world / options_.resolution_m;
  const Cell* cell =
      find_cell(static_cast<int>(std::floor(scaled.x())), static_cast<int>(std::floor(scaled.y())));
  return cell == nullptr ? 0.5 : 1.0 / (1.0 + std::exp(-static_cast<double>(cell->log_odds)));
}

GridMap OccupancyGrid::to_map() const {
  GridMap map;
  map.resolution_m = options_.resolution_m;
  int min_x = std::numeric_limits<int>::max(), min_y = min_x;
  int max_x = std::numeric_limits<int>::min(), max_y = max_x;
  const auto for_each_known = [this](const auto& visit) {
    for (const auto& [key, tile] : tiles_) {
      const int x0 = static_cast<int32_t>(key >> 32U) * kTileCells;
      const int y0 = static_cast<int32_t>(key & 0xFFFFFFFFU) * kTileCells;
      for (int i = 0; i < kTileCells * kTileCells; ++i) {
        const Cell& cell = tile->cells[static_cast<std::size_t>(i)];
        if (cell.last_scan != 0) visit(x0 + (i & (kTileCells - 1)), y0 + (i >> kTileBits), cell);
      }
    }
  };
  for_each_known([&](int x, int y, const Cell&) {
    min_x = std::min(min_x, x);
    min_y = std::min(min_y, y);
    max_x = std::max(max_x, x);
    max_y = std::max(max_y, y);
  });
  if (max_x < min_x) return map;
  map.origin_m = Eigen::Vector2d(min_x, min_y) * options_.resolution_m;
  map.width_cells = max_x - min_x + 1;
  map.height_cells = max_y - min_y + 1;
  map.occupancy.assign(
      static_cast<std::size_t>(map.width_cells) * static_cast<std::size_t>(map.height_cells),
      GridMap::kUnknown);
  for_each_known([&](int x, int y, const Cell& cell) {
    const double occupied = 1.0 / (1.0 + std::exp(-static_cast<double>(cell.log_odds)));
    map.occupancy[static_cast<std::size_t>(y - min_y) * static_cast<std::size_t>(map.width_cells) +
                  static_cast<std::size_t>(x - min_x)] =
        static_cast<uint8_t>(std::lround(100.0 * occupied));
  });
  return map;
}

}  // namespace marco::slam
