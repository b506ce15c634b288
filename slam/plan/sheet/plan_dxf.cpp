#include "slam/plan/sheet/plan_dxf.hpp"

#include <array>
#include <cmath>
#include <numbers>

#include "lcm_tools/base/format.hpp"

namespace marco::slam {
namespace {

using Vector = Eigen::Vector2d;

double to_deg(double rad) { return rad * 180 / std::numbers::pi; }

std::string line(const char* layer, const Vector& from, const Vector& to) {
  return format("0\nLINE\n8\n%s\n10\n%.6f\n20\n%.6f\n30\n0.0\n11\n%.6f\n21\n%.6f\n31\n0.0\n", layer,
                from.x(), from.y(), to.x(), to.y());
}

// Centred at `at`.
std::string text(const char* layer, const Vector& at, double height_m, const std::string& what) {
  std::string plain;
  for (std::size_t i = 0; i < what.size(); ++i) {
    const auto byte = static_cast<unsigned char>(what[i]);
    if (byte >= 0x80 || byte < 0x20) {
      if (byte >= 0xC0) plain += '?';
    } else {
      plain += what[i];
    }
  }
  return format("0\nTEXT\n8\n%s\n10\n%.6f\n20\n%.6f\n30\n0.0\n40\n%.3f\n1\n", layer, at.x(), at.y(),
                height_m) +
         plain + format("\n72\n1\n11\n%.6f\n21\n%.6f\n31\n0.0\n", at.x(), at.y());
}

std::string layer(const char* name, int colour, const char* pattern) {
  return format("0\nLAYER\n2\n%s\n70\n0\n62\n%d\n6\n%s\n", name, colour, pattern);
}

std::string head(const FloorPlan& plan) {
  Vector low(0, 0), high(1, 1);
  for (const PlanRoom& room : plan.rooms) {
    for (const RoomEdge& edge : room.edges()) {
      low = low.cwiseMin(edge.from);
      high = high.cwiseMax(edge.from);
    }
  }
  std::string out = "0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1009\n9\n$INSUNITS\n70\n6\n";
  out += format(
      "9\n$EXTMIN\n10\n%.3f\n20\n%.3f\n30\n0.0\n9\n$EXTMAX\n10\n%.3f\n20\n%.3f\n30\n0."
      "0\n0\nENDSEC\n",
      low.x(), low.y(), high.x(), high.y());
  out +=
      "0\nSECTION\n2\nTABLES\n0\nTABLE\n2\nLTYPE\n70\n2\n"
      "0\nLTYPE\n2\nCONTINUOUS\n70\n0\n3\nSolid line\n72\n65\n73\n0\n40\n0.0\n"
      "0\nLTYPE\n2\nDASHED\n70\n0\n3\n__ __ "
      "__\n72\n65\n73\n2\n40\n0.3\n49\n0.2\n49\n-0.1\n0\nENDTAB\n"
      "0\nTABLE\n2\nLAYER\n70\n8\n";
  out += layer("0", 7, "CONTINUOUS") + layer("WALLS", 7, "CONTINUOUS") +
         layer("WALLS_UNSEEN", 8, "DASHED") + layer("DOORS", 1, "CONTINUOUS") +
         layer("ROOMS", 3, "CONTINUOUS") + layer("DIMENSIONS", 4, "CONTINUOUS") +
         layer("COLUMNS", 7, "CONTINUOUS") + layer("FURNITURE", 9, "CONTINUOUS");
  out +=
      "0\nENDTAB\n0\nTABLE\n2\nSTYLE\n70\n1\n0\nSTYLE\n2\nSTANDARD\n70\n0\n40\n0.0\n41\n1.0\n50\n0."
      "0\n71\n0\n42\n0.2\n3\ntxt\n4\n\n0\nENDTAB\n0\nENDSEC\n";
  const auto block = [](const char* name, const std::string& inside) {
    return format("0\nBLOCK\n8\n0\n2\n%s\n70\n0\n10\n0.0\n20\n0.0\n30\n0.0\n3\n%s\n1\n\n", name,
                  name) +
           inside + "0\nENDBLK\n8\n0\n";
  };
  out += "0\nSECTION\n2\nBLOCKS\n";
  out += block("DOOR", line("0", {0, 0}, {0, 1}) +
                           "0\nARC\n8\n0\n10\n0.0\n20\n0.0\n30\n0.0\n40\n1.0\n50\n0.0\n51\n90.0\n");
  out += block("OPENING", line("0", {0, 0}, {1, 0}));
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
      flip * opening.width_m(), to_deg(std::atan2(way.y(), way.x())));
}

}  // namespace

std::string plan_dxf(const FloorPlan& plan) {
  std::string out = head(plan) + "0\nSECTION\n2\nENTITIES\n";
  for (const PlanRoom& room : plan.rooms) {
    for (const RoomEdge& edge : room.edges()) {
      const Vector& to = edge.to;
      if (edge.kind == EdgeKind::wall) out += line("WALLS", edge.from, to);
      if (edge.kind == EdgeKind::unseen) out += line("WALLS_UNSEEN", edge.from, to);
    }
    out += text("ROOMS", room.label_at, 0.25, room.name);
    out += text("ROOMS", room.label_at - Vector(0, 0.35), 0.2, format("%.2f m2", room.area_m2));
    out += text("DIMENSIONS", room.label_at - Vector(0, 0.65), 0.15,
                format("%.2f x %.2f m", room.size_m.x(), room.size_m.y()));
  }
  for (const PlanOpening& opening : plan.openings) {
    out += insert(opening);
    if (opening.depth_m > 0.03) {
      const Vector back = opening.right() * opening.depth_m;
      out += line("DOORS", opening.from + back, opening.to + back);
    }
    out += text("DIMENSIONS", (opening.from + opening.to) / 2, 0.12,
                format("%.2f", opening.width_m()));
  }
  for (const PlanObject& object : plan.objects) {
    if (object.round) {
      out += format("0\nCIRCLE\n8\nCOLUMNS\n10\n%.6f\n20\n%.6f\n30\n0.0\n40\n%.6f\n",
                    object.centre.x(), object.centre.y(), object.radius_m);
      continue;
    }
    for (std::size_t i = 0; i < object.outline.size(); ++i) {
      out += line("FURNITURE", object.outline[i], object.outline[(i + 1) % object.outline.size()]);
    }
  }
  return out + "0\nENDSEC\n0\nEOF\n";
}

}  // namespace marco::slam
