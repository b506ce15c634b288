#include "plan/sheet/plan_export.hpp"

#include <array>
#include <cmath>
#include <string_view>

#include "lcm_tools/base/format.hpp"
#include "lcm_tools/base/printable.hpp"
#include "plan/sheet/plan_sheet.hpp"

namespace marco::plan {
namespace {

using Vector = Eigen::Vector2d;

std::string line(const char* layer, const Vector& from, const Vector& to) {
  return format("0\nLINE\n8\n%s\n10\n%.6f\n20\n%.6f\n30\n0.0\n11\n%.6f\n21\n%.6f\n31\n0.0\n", layer,
                from.x(), from.y(), to.x(), to.y());
}

// DXF's arcs run counter-clockwise.
std::string arc(const char* layer, const RoomEdge& edge) {
  const BulgeArc found = bulge_arc(edge.from, edge.to, edge.bulge);
  const double a = found.from_rad, b = found.from_rad + found.turn_rad;
  const auto degrees = [](double rad) {
    const double turned = std::fmod(rad_to_deg(rad), 360.0);
    return turned < 0 ? turned + 360.0 : turned;
  };
  return format("0\nARC\n8\n%s\n10\n%.6f\n20\n%.6f\n30\n0.0\n40\n%.6f\n50\n%.6f\n51\n%.6f\n", layer,
                found.centre.x(), found.centre.y(), found.radius, degrees(std::min(a, b)),
                degrees(std::max(a, b)));
}

// R12 is ASCII: any other letter as its UTF-16 code.
std::string in_ascii(std::string_view text) {
  std::string plain;
  while (!text.empty()) {
    const char32_t code = take_character(text);
    if (code < 0x80 && is_drawn(code)) {
      plain += static_cast<char>(code);
    } else if (code > 0xFFFF) {
      plain += format("\\U+%04X\\U+%04X", 0xD7C0U + (code >> 10U), 0xDC00U + (code & 0x3FFU));
    } else if (is_drawn(code)) {
      plain += format("\\U+%04X", static_cast<unsigned>(code));
    }
  }
  return plain;
}

// Centred at `at`.
std::string text(const char* layer,
                 const Vector& at,
                 double height_m,
                 const std::string& what,
                 double angle_rad = 0.0) {
  return format("0\nTEXT\n8\n%s\n10\n%.6f\n20\n%.6f\n30\n0.0\n40\n%.3f\n1\n", layer, at.x(), at.y(),
                height_m) +
         in_ascii(what) +
         format("\n50\n%.6f\n72\n1\n11\n%.6f\n21\n%.6f\n31\n0.0\n", rad_to_deg(angle_rad), at.x(),
                at.y());
}

/// A measured length: between two points, its line shifted to the left of from -> to.
struct Dimension {
  Vector from, to;
  double shift_m;
  double text_m;  // height
};

std::vector<Dimension> dimensions_of(const FloorPlan& plan) {
  std::vector<Dimension> all;
  for (const PlanRoom& room : plan.rooms) {
    const Vector &at = room.label_at, &from = room.size_from, &size = room.size_m;
    if (size.x() > 0) {
      all.push_back({{from.x(), at.y()}, {from.x() + size.x(), at.y()}, -0.9, 0.15});
    }
    if (size.y() > 0) {
      all.push_back({{at.x(), from.y()}, {at.x(), from.y() + size.y()}, 0.9, 0.15});
    }
  }
  for (const PlanOpening& opening : plan.openings) {
    all.push_back({opening.from, opening.to, 0.15, 0.12});
  }
  if (!plan.rooms.empty()) {
    const Vector low = extent_of(plan).min(), high = extent_of(plan).max();
    all.push_back({{low.x(), high.y()}, high, 1.0, 0.25});
    all.push_back({low, {low.x(), high.y()}, 1.0, 0.25});
  }
  return all;
}

std::string dimension_name(std::size_t number) { return "*D" + std::to_string(number + 1); }

// What a program draws that does not draw dimensions by itself.
std::string dimension_lines(const Dimension& dimension) {
  const Vector way = (dimension.to - dimension.from).normalized(), left(-way.y(), way.x());
  const Vector shift = left * dimension.shift_m;
  const Vector beyond = left * std::copysign(0.05, dimension.shift_m);
  const Vector tick = (way + left) * 0.05;
  const Vector a = dimension.from + shift, b = dimension.to + shift;
  return line("DIMENSIONS", dimension.from, a + beyond) +
         line("DIMENSIONS", dimension.to, b + beyond) + line("DIMENSIONS", a, b) +
         line("DIMENSIONS", a - tick, a + tick) + line("DIMENSIONS", b - tick, b + tick) +
         text("DIMENSIONS", (a + b) / 2 + left * 0.05, dimension.text_m,
              format("%.2f", (b - a).norm()), std::atan2(way.y(), way.x()));
}

// A dimension along from -> to; its text is what the program measures.
std::string dimension_entity(const Dimension& dimension, const std::string& name) {
  const Vector way = (dimension.to - dimension.from).normalized(), left(-way.y(), way.x());
  const Vector on_line = dimension.to + left * dimension.shift_m;
  const Vector middle = (dimension.from + dimension.to) / 2 +
                        left * (dimension.shift_m + 0.05 + dimension.text_m / 2);
  const auto point = [](int number, const Vector& at) {
    return format("%d\n%.6f\n%d\n%.6f\n%d\n0.0\n", number, at.x(), number + 10, at.y(),
                  number + 20);
  };
  return "0\nDIMENSION\n8\nDIMENSIONS\n2\n" + name + "\n" + point(10, on_line) + point(11, middle) +
         "70\n0\n1\n\n3\nSTANDARD\n" + point(13, dimension.from) + point(14, dimension.to) +
         format("50\n%.6f\n", rad_to_deg(std::atan2(way.y(), way.x())));
}

std::string layer(const char* name, int colour, const char* pattern) {
  return format("0\nLAYER\n2\n%s\n70\n0\n62\n%d\n6\n%s\n", name, colour, pattern);
}

std::string head(const FloorPlan& plan, const std::vector<Dimension>& dimensions) {
  const Vector low = extent_of(plan).min().cwiseMin(0), high = extent_of(plan).max().cwiseMax(1);
  // Dimensions in metres with two decimals, with ticks.
  std::string out =
      "0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1009\n9\n$INSUNITS\n70\n6\n"
      "9\n$LUNITS\n70\n2\n9\n$LUPREC\n70\n2\n9\n$DIMSCALE\n40\n1.0\n9\n$DIMASZ\n40\n0.1\n"
      "9\n$DIMTXT\n40\n0.15\n9\n$DIMEXO\n40\n0.05\n9\n$DIMEXE\n40\n0.05\n9\n$DIMTSZ\n40\n0.05\n"
      "9\n$DIMGAP\n40\n0.05\n9\n$DIMTIH\n70\n0\n9\n$DIMTOH\n70\n0\n9\n$DIMTAD\n70\n1\n";
  out += format(
      "9\n$EXTMIN\n10\n%.3f\n20\n%.3f\n30\n0.0\n9\n$EXTMAX\n10\n%.3f\n20\n%.3f\n30\n0."
      "0\n0\nENDSEC\n",
      low.x(), low.y(), high.x(), high.y());
  out +=
      "0\nSECTION\n2\nTABLES\n0\nTABLE\n2\nLTYPE\n70\n2\n"
      "0\nLTYPE\n2\nCONTINUOUS\n70\n0\n3\nSolid line\n72\n65\n73\n0\n40\n0.0\n"
      "0\nLTYPE\n2\nDASHED\n70\n0\n3\n__ __ "
      "__\n72\n65\n73\n2\n40\n0.3\n49\n0.2\n49\n-0.1\n0\nENDTAB\n"
      "0\nTABLE\n2\nLAYER\n70\n9\n";
  out += layer("0", 7, "CONTINUOUS") + layer("WALLS", 7, "CONTINUOUS") +
         layer("WALLS_UNSEEN", 8, "DASHED") + layer("DOORS", 1, "CONTINUOUS") +
         layer("WINDOWS", 5, "CONTINUOUS") + layer("ROOMS", 3, "CONTINUOUS") +
         layer("DIMENSIONS", 4, "CONTINUOUS") + layer("COLUMNS", 7, "CONTINUOUS") +
         layer("FURNITURE", 9, "CONTINUOUS");
  out +=
      "0\nENDTAB\n0\nTABLE\n2\nSTYLE\n70\n1\n0\nSTYLE\n2\nSTANDARD\n70\n0\n40\n0.0\n41\n1.0\n50\n0."
      "0\n71\n0\n42\n0.2\n3\ntxt\n4\n\n0\nENDTAB\n"
      "0\nTABLE\n2\nDIMSTYLE\n70\n1\n0\nDIMSTYLE\n2\nSTANDARD\n70\n0\n40\n1.0\n41\n0.1\n42\n0."
      "05\n44\n"
      "0.05\n140\n0.15\n142\n0.05\n147\n0.05\n73\n0\n74\n0\n77\n1\n0\nENDTAB\n0\nENDSEC\n";
  const auto block = [](const char* name, const std::string& inside, bool anonymous = false) {
    return format("0\nBLOCK\n8\n0\n2\n%s\n70\n%d\n10\n0.0\n20\n0.0\n30\n0.0\n3\n%s\n1\n\n", name,
                  anonymous ? 1 : 0, name) +
           inside + "0\nENDBLK\n8\n0\n";
  };
  out += "0\nSECTION\n2\nBLOCKS\n";
  out += block("DOOR", line("0", {0, 0}, {0, 1}) +
                           "0\nARC\n8\n0\n10\n0.0\n20\n0.0\n30\n0.0\n40\n1.0\n50\n0.0\n51\n90.0\n");
  out += block("OPENING", line("0", {0, 0}, {1, 0}));
  for (std::size_t i = 0; i < dimensions.size(); ++i) {
    out += block(dimension_name(i).c_str(), dimension_lines(dimensions[i]), true);
  }
  return out + "0\nENDSEC\n";
}

// A door's block is hinged at its origin; x to the other jamb, y to where the leaf opens.
std::string insert(const PlanOpening& opening) {
  Vector origin = opening.from, other = opening.to;
  double flip = 1;
  if (opening.has_leaf) {
    if ((opening.hinge - opening.to).norm() < 1e-9) std::swap(origin, other);
    const Vector way = other - origin, leaf = opening.leaf_end - opening.hinge;
    if (way.x() * leaf.y() - way.y() * leaf.x() < 0) flip = -1;
  }
  const Vector way = other - origin;
  return format(
      "0\nINSERT\n8\nDOORS\n2\n%s\n10\n%.6f\n20\n%.6f\n30\n0.0\n41\n%.6f\n42\n%.6f\n43\n1.0\n50\n%."
      "6f\n",
      opening.has_leaf ? "DOOR" : "OPENING", origin.x(), origin.y(), opening.width_m(),
      flip * opening.width_m(), rad_to_deg(std::atan2(way.y(), way.x())));
}

std::string object_entities(const PlanObject& object) {
  if (object.round) {
    return format("0\nCIRCLE\n8\nCOLUMNS\n10\n%.6f\n20\n%.6f\n30\n0.0\n40\n%.6f\n",
                  object.centre.x(), object.centre.y(), object.radius_m);
  }
  std::string out;
  for (std::size_t i = 0; i < object.outline.size(); ++i) {
    out += line("FURNITURE", object.outline[i], object.outline[(i + 1) % object.outline.size()]);
  }
  return out;
}

}  // namespace

std::string plan_dxf(const FloorPlan& plan) {
  const std::vector<Dimension> dimensions = dimensions_of(plan);
  std::string out = head(plan, dimensions) + "0\nSECTION\n2\nENTITIES\n";
  for (const PlanRoom& room : plan.rooms) {
    for (const RoomEdge& edge : room.edges()) {
      const Vector& to = edge.to;
      if (edge.kind == EdgeKind::opening) continue;
      const bool glass = edge.index >= 0 && plan.faces[static_cast<std::size_t>(edge.index)].glass;
      const char* on = edge.kind == EdgeKind::unseen ? "WALLS_UNSEEN" : glass ? "WINDOWS" : "WALLS";
      out += edge.bulge == 0.0 ? line(on, edge.from, to) : arc(on, edge);
    }
    out += text("ROOMS", room.label_at, 0.25, room.name);
    out += text("ROOMS", room.label_at - Vector(0, 0.35), 0.2, format("%.2f m2", room.area_m2));
  }
  for (const PlanOpening& opening : plan.openings) {
    out += insert(opening);
    if (opening.depth_m > 0.03) {
      const Vector back = opening.right() * opening.depth_m;
      out += line("DOORS", opening.from + back, opening.to + back);
    }
  }
  for (std::size_t i = 0; i < dimensions.size(); ++i) {
    out += dimension_entity(dimensions[i], dimension_name(i));
  }
  for (const PlanObject& object : plan.objects) out += object_entities(object);
  return out + "0\nENDSEC\n0\nEOF\n";
}

}  // namespace marco::plan
