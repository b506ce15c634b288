#include "common/files/lines_dxf.hpp"

#include <numbers>

#include "lcm_tools/base/format.hpp"

namespace marco::files {

std::string lines_dxf(const LineMap& map) {
  std::string dxf =
      "0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1009\n0\nENDSEC\n"
      "0\nSECTION\n2\nTABLES\n0\nTABLE\n2\nLAYER\n70\n3\n"
      "0\nLAYER\n2\nWALLS\n70\n0\n62\n3\n6\nCONTINUOUS\n"
      "0\nLAYER\n2\nPOSTS\n70\n0\n62\n5\n6\nCONTINUOUS\n"
      "0\nLAYER\n2\nCORNERS\n70\n0\n62\n1\n6\nCONTINUOUS\n0\nENDTAB\n0\nENDSEC\n"
      "0\nSECTION\n2\nENTITIES\n";
  for (const Wall& wall : map.walls) {
    dxf += format("0\nLINE\n8\nWALLS\n10\n%.6f\n20\n%.6f\n30\n0.0\n11\n%.6f\n21\n%.6f\n31\n0.0\n",
                  wall.start_m.x(), wall.start_m.y(), wall.end_m.x(), wall.end_m.y());
  }
  constexpr double kDegrees = 180.0 / std::numbers::pi;
  for (const RoundWall& wall : map.round_walls) {
    dxf += format("0\n%s\n8\n%s\n10\n%.6f\n20\n%.6f\n30\n0.0\n40\n%.6f\n",
                  wall.is_whole() ? "CIRCLE" : "ARC",
                  wall.is_whole() && !wall.from_inside ? "POSTS" : "WALLS", wall.centre_m.x(),
                  wall.centre_m.y(), wall.radius_m);
    if (wall.is_whole()) continue;
    dxf += format("50\n%.6f\n51\n%.6f\n", wall.from_rad * kDegrees,
                  (wall.from_rad + wall.span_rad) * kDegrees);
  }
  for (const CornerPoint& corner : map.corners) {
    dxf += format("0\nPOINT\n8\nCORNERS\n10\n%.6f\n20\n%.6f\n30\n0.0\n", corner.at_m.x(),
                  corner.at_m.y());
  }
  return dxf + "0\nENDSEC\n0\nEOF\n";
}

}  // namespace marco::files
