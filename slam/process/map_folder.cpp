#include "slam/process/map_folder.hpp"

#include "common/files/map_yaml.hpp"
#include "common/files/tum.hpp"
#include "lcm_tools/files/inside_folder.hpp"
#include "lcm_tools/files/output_folder.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "slam/map/keyframe_grid.hpp"

namespace marco::slam {

SavedMap load_map_folder(const std::filesystem::path& folder) {
  const std::filesystem::path path = files::inside_folder(folder, kSavedMapName);
  const std::string bytes = files::read_whole_file(path);
  try {
    return decode_saved_map(bytes);
  } catch (const std::invalid_argument& wrong) {
    throw std::invalid_argument(path.string() + ": " + wrong.what());
  }
}

void save_map_file(const std::filesystem::path& folder, const SavedMap& map) {
  files::write_whole_file(folder / kSavedMapName, encode_saved_map(map));
}

void write_map_files(const std::filesystem::path& folder,
                     const SavedMap& map,
                     const OccupancyGridOptions& drawing,
                     const std::string& picture) {
  save_map_file(folder, map);
  const GridMap grid = draw_grid(map.slam.keyframes.keys, drawing).to_map();
  if (grid.width_cells > 0) files::write_map(folder, grid, picture);
  files::write_tum(folder / "trajectory.tum",
                   trajectory_of(map.slam.path.scans, map.slam.keyframes.keys));
}

void save_map_folder(const std::filesystem::path& folder,
                     const SavedMap& map,
                     const OccupancyGridOptions& drawing) {
  files::OutputFolder results(folder, "slam");
  const std::string before = files::picture_of_map(folder);
  if (!before.empty()) results.keep(folder / before);
  write_map_files(results.path(), map, drawing, files::next_picture_name(before));
  results.commit();
}

}  // namespace marco::slam
