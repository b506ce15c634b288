#include "plan/sheet/plan_sheet.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/base/format.hpp"

namespace marco::plan {
namespace {

using Vector = Eigen::Vector2d;

constexpr double kMarginMm = 10.0;      // of the paper, which printers leave white
constexpr double kDimensionsMm = 16.0;  // left of the plan and above it
constexpr double kTitleMm = 34.0;       // height of the block below

struct Paper {
  const char* name;
  double width_mm, height_mm;
};

// A sheet's paper and scale, and the room that they leave for the plan [mm].
struct SheetLayout {
  Paper paper;
  bool upright = false;
  int scale = 0;
  double width() const { return upright ? paper.height_mm : paper.width_mm; }
  double height() const { return upright ? paper.width_mm : paper.height_mm; }
  double free_width() const { return width() - 2 * kMarginMm - 2 * kDimensionsMm; }
  double free_height() const { return height() - 2 * kMarginMm - 2 * kDimensionsMm - kTitleMm; }
};

constexpr std::array<Paper, 5> kPapers{
    {{"A4", 297, 210}, {"A3", 420, 297}, {"A2", 594, 420}, {"A1", 841, 594}, {"A0", 1189, 841}}};
constexpr std::array kScales{50, 100, 200, 500, 1000, 2000};

bool fits(const SheetLayout& layout, const Vector& size_m) {
  const Vector size_mm = size_m * (1000.0 / layout.scale);
  return size_mm.x() <= layout.free_width() && size_mm.y() <= layout.free_height();
}

SheetLayout choose_layout(const SheetWish& wish, const Vector& size_m) {
  std::vector<Paper> papers(kPapers.begin(), kPapers.begin() + (wish.scale == 0 ? 3 : 5));
  if (!wish.paper.empty()) {
    papers.clear();
    for (const Paper& paper : kPapers) {
      if (wish.paper == paper.name) papers.push_back(paper);
    }
    require(!papers.empty(), "paper '" + wish.paper + "' is unknown: A4, A3, A2, A1 or A0");
  }
  std::vector<int> scales{wish.scale};
  if (wish.scale == 0) {
    const std::size_t first = wish.paper.empty() ? 1 : 0;
    scales.assign(kScales.begin() + static_cast<long>(first), kScales.end());
  }
  for (const int scale : scales) {
    for (const Paper& paper : papers) {
      for (const bool upright : {false, true}) {
        const SheetLayout layout{paper, upright, scale};
        if (fits(layout, size_m)) return layout;
      }
    }
  }
  std::string advice = "no standard scale fits";
  for (const int scale : kScales) {
    if (fits({papers.back(), false, scale}, size_m) || fits({papers.back(), true, scale}, size_m)) {
      advice = "1:" + std::to_string(scale) + " fits";
      break;
    }
  }
  throw std::invalid_argument(
      format("a plan of %.1f x %.1f m does not fit on ", size_m.x(), size_m.y()) +
      papers.back().name + " at 1:" + std::to_string(wish.scale) + "; " + advice);
}

class Drawing {
 public:
  Drawing(const FloorPlan& plan, const SheetWish& wish)
      : plan_(plan),
        wish_(wish),
        extent_(extent_of(plan)),
        layout_(choose_layout(wish, extent_.sizes())) {
    sheet_.width_mm = layout_.width();
    sheet_.height_mm = layout_.height();
    sheet_.title = wish.title;
    sheet_.scale = layout_.scale;
    per_m_ = 1000.0 / layout_.scale;
    const Vector middle(layout_.width() / 2,
                        kMarginMm + kTitleMm + (layout_.height() - 2 * kMarginMm - kTitleMm) / 2);
    origin_ = middle - extent_.center() * per_m_;
  }

  Sheet draw() {
    walls();
    objects();
    edges();
    openings();
    labels();
    overall();
    title_block();
    return std::move(sheet_);
  }

 private:
  Vector on_paper(const Vector& at) const { return origin_ + at * per_m_; }

  void walls() {
    for (const PlanWall& wall : plan_.walls) {
      if (wall.thickness_m < 0.01) continue;
      sheet_.paths.push_back({{on_paper(wall.from), on_paper(wall.to), on_paper(wall.back(wall.to)),
                               on_paper(wall.back(wall.from))},
                              true,
                              {0, 0, wall.assumed ? 0.88 : 0.45, {}},
                              {},
                              {wall.bulge, 0, -wall.bulge}});
    }
  }

  void objects() {
    for (const PlanObject& object : plan_.objects) {
      Sheet::Path path{{},
                       true,
                       {0.13, 0.45, object.round ? 0.45 : -1.0, {}},
                       object.round ? "COLUMNS" : "FURNITURE"};
      if (object.round) {
        const Vector beside(object.radius_m, 0);
        path.points = {on_paper(object.centre + beside), on_paper(object.centre - beside)};
        path.bulges = {1, 1};
      } else {
        for (const Vector& point : object.outline) path.points.push_back(on_paper(point));
      }
      sheet_.paths.push_back(path);
    }
  }

  void edges() {
    for (const PlanRoom& room : plan_.rooms) {
      for (const RoomEdge& edge : room.edges()) {
        Sheet::Path path{{on_paper(edge.from), on_paper(edge.to)}, false, {}, {}, {edge.bulge}};
        if (edge.kind == EdgeKind::opening) continue;
        const bool seen = edge.kind == EdgeKind::wall;
        path.style = seen ? Sheet::Style{0.5, 0, -1, {}} : Sheet::Style{0.25, 0.35, -1, {1.5, 1.2}};
        path.layer = seen ? "WALLS" : "WALLS_UNSEEN";
        sheet_.paths.push_back(path);
      }
    }
  }

  void openings() {
    for (const PlanOpening& opening : plan_.openings) {
      const Sheet::Style thin{0.13, 0.5, -1, {0.8, 0.8}};
      const Vector back = opening.right() * opening.depth_m;
      sheet_.line(on_paper(opening.from), on_paper(opening.to), thin);
      if (opening.depth_m > 0.03) {
        sheet_.line(on_paper(opening.from + back), on_paper(opening.to + back), thin);
      }
      if (opening.has_leaf) leaf(opening);
      const Vector middle = (opening.from + opening.to) / 2 + back / 2;
      const Vector way = (opening.to - opening.from).normalized();
      double angle = std::atan2(way.y(), way.x());
      if (angle > std::numbers::pi / 2 + 0.01 || angle <= -std::numbers::pi / 2 + 0.01)
        angle += std::numbers::pi;
      const Vector up(-std::sin(angle), std::cos(angle));
      centred(on_paper(middle) + up * (0.6 + std::abs(back.dot(up)) * per_m_ / 2),
              format("%.2f", opening.width_m()), 1.8, angle);
    }
  }

  // As it stood, and the quarter turn it makes.
  void leaf(const PlanOpening& opening) {
    sheet_.line(on_paper(opening.hinge), on_paper(opening.leaf_end), {0.35, 0, -1, {}});
    const Vector other = (opening.hinge - opening.from).norm() < 1e-9 ? opening.to : opening.from;
    const Vector a = opening.leaf_end - opening.hinge, b = other - opening.hinge;
    const double from = std::atan2(a.y(), a.x());
    const double turn = normalize_angle(std::atan2(b.y(), b.x()) - from);
    const Vector end = opening.hinge + b.norm() * Vector(std::cos(from), std::sin(from));
    sheet_.paths.push_back(
        {{on_paper(end), on_paper(other)}, false, {0.13, 0.3, -1, {}}, {}, {bulge_of(turn)}});
  }

  void labels() {
    for (const PlanRoom& room : plan_.rooms) {
      const Vector at = on_paper(room.label_at);
      const double height = std::clamp(room.size_m.x() * per_m_ / 14, 1.5, 3.0);
      centred(at + Vector(0, 0.9 * height), room.name, height);
      sheet_.texts.back().bold = true;
      centred(at - Vector(0, 0.4 * height),
              format("%.2f \u00b1 %.2f m\u00b2", room.area_m2, room.area_sigma_m2), 0.85 * height);
      centred(at - Vector(0, 1.6 * height),
              format("%.2f \u00d7 %.2f m", room.size_m.x(), room.size_m.y()), 0.75 * height);
    }
  }

  // A dimension line with its end marks; `out` is where the text stands.
  void dimension(const Vector& from, const Vector& to, const Vector& out, double length_m) {
    const Sheet::Style thin{0.13, 0, -1, {}};
    const Vector way = (to - from).normalized();
    sheet_.line(from, to, thin);
    for (const Vector& end : {from, to}) {
      sheet_.line(end - out * 3, end + out * 1.2, thin);
      sheet_.line(end - (way + out) * 0.9, end + (way + out) * 0.9, {0.25, 0, -1, {}});
    }
    const double sigma = std::hypot(0.005, plan_.scale_sigma * length_m);
    centred((from + to) / 2 + out * 0.9, format("%.2f \u00b1 %.2f m", length_m, sigma), 2.5,
            std::atan2(way.y(), way.x()));
  }

  void overall() {
    const Vector low = on_paper(extent_.min()), high = on_paper(extent_.max());
    const double off = 0.55 * kDimensionsMm;
    dimension({low.x(), high.y() + off}, {high.x(), high.y() + off}, {0, 1}, extent_.sizes().x());
    dimension({low.x() - off, low.y()}, {low.x() - off, high.y()}, {-1, 0}, extent_.sizes().y());
  }

  void centred(const Vector& at, const std::string& what, double height, double angle_rad = 0) {
    sheet_.texts.push_back({at, what, height, angle_rad, Sheet::Anchor::middle});
  }

  void text(double x, double y, const std::string& what, double height = 2.5, bool bold = false) {
    sheet_.texts.push_back({{x, y}, what, height, 0, Sheet::Anchor::start, bold});
  }

  void title_block() {
    const Sheet::Style frame{0.35, 0, -1, {}};
    const double left = kMarginMm, right = layout_.width() - kMarginMm, top = kMarginMm + kTitleMm;
    sheet_.paths.push_back({{{left, kMarginMm},
                             {right, kMarginMm},
                             {right, layout_.height() - kMarginMm},
                             {left, layout_.height() - kMarginMm}},
                            true,
                            frame});
    sheet_.line({left, top}, {right, top}, frame);
    double area = 0;
    for (const PlanRoom& room : plan_.rooms) area += room.area_m2;
    text(left + 4, top - 7, wish_.title, 4.5, true);
    text(left + 4, top - 13,
         format("Scale 1:%d on %s", layout_.scale, layout_.paper.name) + ", lengths in m", 3);
    text(left + 4, top - 18,
         format("Rooms: %zu, %.1f m\u00b2 net. Doors and openings: %zu", plan_.rooms.size(), area,
                plan_.openings.size()),
         3);
    text(left + 4, top - 23, wish_.source, 2.5);
    text(left + 4, top - 27.5,
         format("North is unknown: up on the sheet is %.1f\u00b0 of the map's frame.",
                90 + plan_.map_from_plan.theta_rad * 180 / std::numbers::pi),
         2.5);
    text(left + 4, top - 32,
         "Measured at the laser's height. \u00b1 is one standard deviation; the map's scale is "
         "assumed good to 0.1 %.",
         2.2);
    scale_bar(right - 4, top - 12);
    legend(right - 4, top - 17.5);
  }

  void scale_bar(double right, double y) {
    const double unit_m = layout_.scale <= 100   ? 1
                          : layout_.scale <= 200 ? 2
                          : layout_.scale <= 500 ? 5
                                                 : 10;
    const double step = unit_m * per_m_;
    const double left = right - 5 * step - 6;
    for (int i = 0; i < 5; ++i) {
      sheet_.paths.push_back({{{left + i * step, y},
                               {left + (i + 1) * step, y},
                               {left + (i + 1) * step, y + 1.5},
                               {left + i * step, y + 1.5}},
                              true,
                              {0.13, 0, i % 2 == 0 ? 0.0 : 1.0, {}}});
    }
    for (int i = 0; i <= 5; ++i) {
      centred({left + i * step, y + 2.5}, format("%.0f", i * unit_m) + (i == 5 ? " m" : ""), 2.2);
    }
  }

  void legend(double right, double y) {
    const double left = right - 68;
    sheet_.line({left, y}, {left + 8, y}, {0.5, 0, -1, {}});
    text(left + 10, y - 0.8, "wall, seen from here", 2.2);
    sheet_.line({left, y - 4}, {left + 8, y - 4}, {0.25, 0.35, -1, {1.5, 1.2}});
    text(left + 10, y - 4.8, "not seen", 2.2);
    sheet_.line({left, y - 8}, {left + 8, y - 8}, {0.13, 0.5, -1, {0.8, 0.8}});
    text(left + 10, y - 8.8, "door or opening, its clear width", 2.2);
    const auto box = [&](double x, double low, double fill) {
      sheet_.paths.push_back(
          {{{x, low}, {x + 8, low}, {x + 8, low + 2}, {x, low + 2}}, true, {0, 0, fill, {}}});
    };
    box(left, y - 13, 0.45);
    text(left + 10, y - 12.8, "thickness seen", 2.2);
    box(left + 34, y - 13, 0.88);
    text(left + 44, y - 12.8, "thickness assumed", 2.2);
  }

  const FloorPlan& plan_;
  const SheetWish& wish_;
  Eigen::AlignedBox2d extent_;
  SheetLayout layout_;
  Sheet sheet_;
  double per_m_ = 1;
  Vector origin_ = {0, 0};
};

}  // namespace

Eigen::AlignedBox2d extent_of(const FloorPlan& plan) {
  Eigen::AlignedBox2d extent;
  for (const PlanRoom& room : plan.rooms) {
    for (const RoomEdge& edge : room.edges()) {
      for (const Vector& at : bulge_points(edge.from, edge.to, edge.bulge)) extent.extend(at);
    }
  }
  return extent;
}

Sheet draw_sheet(const FloorPlan& plan, const SheetWish& wish) {
  require(!plan.rooms.empty(), "the map contains no room: nothing to draw");
  return Drawing(plan, wish).draw();
}

}  // namespace marco::plan
