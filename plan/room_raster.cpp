#include "plan/room_raster.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>

namespace marco::plan {
namespace {

constexpr double kLeastAreaM2 = 1.5;  // a lavatory; less is a niche
using Vector = Eigen::Vector2d;

void mark_openings(const FreeSpace& space,
                   const std::vector<PlanOpening>& openings,
                   RoomRaster& raster) {
  const double step = 0.4 * FreeSpace::kCellM;
  for (std::size_t i = 0; i < openings.size(); ++i) {
    const PlanOpening& opening = openings[i];
    const Vector way = (opening.to - opening.from).normalized();
    for (double s = -0.12; s <= opening.width_m() + 0.12; s += step) {
      for (double t = -0.05; t <= opening.depth_m + 0.05; t += step) {
        const int cell = space.cell_of(opening.from + way * s + opening.right() * t);
        if (space.is_free(cell))
          raster.opening[static_cast<std::size_t>(cell)] = static_cast<int>(i);
      }
    }
  }
}

void flood(const FreeSpace& space, RoomRaster& raster) {
  const int width = space.width(), cells = width * space.height();
  const std::array<int, 4> around{1, -1, width, -width};
  for (int start = 0; start < cells; ++start) {
    const auto open = [&](int cell) {
      const auto at = static_cast<std::size_t>(cell);
      return space.is_free(cell) && raster.room[at] == -1 && raster.opening[at] < 0;
    };
    if (!open(start)) continue;
    std::vector<int> members{start};
    raster.room[static_cast<std::size_t>(start)] = raster.rooms;
    for (std::size_t next = 0; next < members.size(); ++next) {
      for (const int step : around) {
        const int cell = members[next] + step;
        if (!open(cell)) continue;
        raster.room[static_cast<std::size_t>(cell)] = raster.rooms;
        members.push_back(cell);
      }
    }
    if (static_cast<double>(members.size()) * FreeSpace::kCellM * FreeSpace::kCellM <
        kLeastAreaM2) {
      for (const int cell : members) raster.room[static_cast<std::size_t>(cell)] = -2;
    } else {
      ++raster.rooms;
    }
  }
  for (int& room : raster.room) room = std::max(room, -1);
}

// The rooms left and right of an opening.
std::set<int> joined_by(const FreeSpace& space, const RoomRaster& raster, const PlanOpening& o) {
  std::set<int> rooms;
  for (const double side : {-0.15, o.depth_m + 0.15}) {
    for (const double part : {0.3, 0.5, 0.7}) {
      const int cell = space.cell_of(o.from + (o.to - o.from) * part + o.right() * side);
      if (cell >= 0 && raster.room[static_cast<std::size_t>(cell)] >= 0) {
        rooms.insert(raster.room[static_cast<std::size_t>(cell)]);
      }
    }
  }
  return rooms;
}

}  // namespace

RoomRaster cut_rooms(const FreeSpace& space, std::vector<PlanOpening>& openings) {
  const auto cells =
      static_cast<std::size_t>(space.width()) * static_cast<std::size_t>(space.height());
  while (true) {
    RoomRaster raster{std::vector<int>(cells, -1), std::vector<int>(cells, -1), 0};
    mark_openings(space, openings, raster);
    flood(space, raster);
    const auto removed = std::erase_if(openings, [&](const PlanOpening& opening) {
      return joined_by(space, raster, opening).size() < 2;
    });
    if (removed == 0) return raster;
  }
}

namespace {

class Tracer {
 public:
  Tracer(const FreeSpace& space, const RoomRaster& raster, int room)
      : space_(space), raster_(raster), room_(room), traced_(raster.room.size(), false) {}

  bool inside(int x, int y) const {
    return x >= 0 && y >= 0 && x < space_.width() && y < space_.height() &&
           raster_.room[static_cast<std::size_t>(y * space_.width() + x)] == room_;
  }
  bool is_new_start(int x, int y) const {
    return inside(x, y) && !inside(x, y - 1) &&
           !traced_[static_cast<std::size_t>(y * space_.width() + x)];
  }

  // From the lower side of a cell, the room on the left.
  std::vector<OutlineStep> trace(const int x0, const int y0) {
    int x = x0, y = y0, dx = 1, dy = 0;
    const Vector origin = space_.centre_of(0) - Vector::Constant(FreeSpace::kCellM / 2);
    std::vector<OutlineStep> steps;
    do {
      if (dx == 1) traced_[static_cast<std::size_t>(y * space_.width() + x)] = true;
      const int right_x = x + (dx + dy - 1) / 2, right_y = y + (dy - dx - 1) / 2;
      const bool in_raster =
          right_x >= 0 && right_y >= 0 && right_x < space_.width() && right_y < space_.height();
      steps.push_back({origin + FreeSpace::kCellM * Vector(x + 0.5 * dx, y + 0.5 * dy),
                       Vector(-dy, dx), in_raster ? right_y * space_.width() + right_x : -1});
      x += dx;
      y += dy;
      const bool left = inside(x + (dx - dy - 1) / 2, y + (dy + dx - 1) / 2);
      const bool right = inside(x + (dx + dy - 1) / 2, y + (dy - dx - 1) / 2);
      if (!left) {
        dy = std::exchange(dx, -dy);
      } else if (right) {
        dy = -std::exchange(dx, dy);
      }
    } while (!(x == x0 && y == y0 && dx == 1 && dy == 0));
    return steps;
  }

 private:
  const FreeSpace& space_;
  const RoomRaster& raster_;
  int room_;
  std::vector<bool> traced_;
};

std::vector<OutlineStep> smoothed(const std::vector<OutlineStep>& steps) {
  std::vector<OutlineStep> smooth = steps;
  const int count = static_cast<int>(steps.size());
  for (int i = 0; i < count; ++i) {
    Vector sum = Vector::Zero();
    for (int k = -4; k <= 4; ++k) {
      sum += steps[static_cast<std::size_t>(((i + k) % count + count) % count)].inward;
    }
    if (sum.norm() > 0) smooth[static_cast<std::size_t>(i)].inward = sum.normalized();
  }
  return smooth;
}

}  // namespace

std::vector<std::vector<OutlineStep>> outlines_of(const FreeSpace& space,
                                                  const RoomRaster& raster,
                                                  int room,
                                                  double least_m) {
  Tracer tracer(space, raster, room);
  std::vector<std::vector<OutlineStep>> outlines;
  for (int y = 0; y < space.height(); ++y) {
    for (int x = 0; x < space.width(); ++x) {
      if (!tracer.is_new_start(x, y)) continue;
      const std::vector<OutlineStep> steps = tracer.trace(x, y);
      if (outlines.empty() || static_cast<double>(steps.size()) * FreeSpace::kCellM > 2 * least_m) {
        outlines.push_back(smoothed(steps));
      }
    }
  }
  return outlines;
}

Vector inmost_point(const FreeSpace& space, const RoomRaster& raster, int room) {
  const int width = space.width(), cells = width * space.height();
  std::vector<int> depth(static_cast<std::size_t>(cells), 0);
  const auto at = [&](int cell) -> int& { return depth[static_cast<std::size_t>(cell)]; };
  for (int cell = width + 1; cell < cells; ++cell) {
    if (raster.room[static_cast<std::size_t>(cell)] != room) continue;
    at(cell) =
        1 + std::min({at(cell - 1), at(cell - width), at(cell - width - 1), at(cell - width + 1)});
  }
  int best = 0;
  for (int cell = cells - width - 2; cell > width; --cell) {
    if (at(cell) == 0) continue;
    at(cell) = std::min(at(cell), 1 + std::min({at(cell + 1), at(cell + width),
                                                at(cell + width + 1), at(cell + width - 1)}));
    if (at(cell) > at(best)) best = cell;
  }
  return space.centre_of(best);
}

}  // namespace marco::plan
