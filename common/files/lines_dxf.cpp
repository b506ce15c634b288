#include "common/files/lines_dxf.hpp"

#include <cstdio>

namespace marco::files {

std::string lines_dxf(const Walls& walls) {
  std::string dxf =
      "0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1009\n0\nENDSEC\n"
      "0\nSECTION\n2\nTABLES\n0\nTABLE\n2\nLAYER\n70\n1\n"
      "0\nLAYER\n2\nWALLS\n70\n0\n62\n3\n6\nCONTINUOUS\n0\nENDTAB\n0\nENDSEC\n"
      "0\nSECTION\n2\nENTITIES\n";
  for (const Wall& wall : walls) {
    char text[200];
    std::snprintf(text, sizeof(text),
                  "0\nLINE\n8\nWALLS\n10\n%.6f\n20\n%.6f\n30\n0.0\n11\n%.6f\n21\n%.6f\n31\n0.0\n",
                  wall.start_m.x(), wall.start_m.y(), wall.end_m.x(), wall.end_m.y());
    dxf += text;
  }
  return dxf + "0\nENDSEC\n0\nEOF\n";
}

}  // namespace marco::files
