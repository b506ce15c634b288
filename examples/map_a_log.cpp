// Makes a map from a recording and writes it for map_server.   map_a_log LOG FOLDER
#include <cstdio>

#include "common/files/map_yaml.hpp"
#include "tools/map/map_job.hpp"

int main(int argc, char** argv) {
  if (argc != 3) return std::fprintf(stderr, "usage: map_a_log LOG FOLDER (which exists)\n"), 2;
  marco::MapJob job(argv[2]);
  job.read({argv[1]});
  job.finish();
  marco::files::write_map(argv[2], job.grid());
  const marco::Trajectory path = job.trajectory();
  if (path.empty()) return std::puts("no scan was placed"), 1;
  const marco::Pose2& end = path.back().world_from_robot;
  std::printf("%zu scans, %zu loops; the drive ends at x %.2f m, y %.2f m\n", path.size(),
              job.mapper().loops().size(), end.x_m, end.y_m);
}
