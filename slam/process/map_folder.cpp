#include "slam/process/map_folder.hpp"

#include "common/check.hpp"
#include "common/files/map_yaml.hpp"
#include "common/files/output_folder.hpp"
#include "common/files/tum.hpp"
#include "common/files/whole_file.hpp"

namespace marco::slam {

SavedMap load_map_folder(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / kSavedMapName;
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
                     const MappingSession& session,
                     const std::string& options,
                     const std::string& picture) {
  save_map_file(folder, session.saved(options));
  const GridMap grid = session.grid().to_map();
  if (grid.width_cells > 0) files::write_map(folder, grid, picture);
  files::write_tum(folder / "trajectory.tum", session.slam().trajectory());
}

void save_map_folder(const std::filesystem::path& folder,
                     const MappingSession& session,
                     const std::string& options) {
  files::OutputFolder results(folder, "slam");
  const std::string before = files::picture_of_map(folder);
  if (!before.empty()) results.keep(folder / before);
  write_map_files(results.path(), session, options, files::next_picture_name(before));
  results.commit();
}

std::filesystem::path folder_below(const std::filesystem::path& allowed, const std::string& named) {
  const std::filesystem::path folder(named);
  bool leads_out = folder.is_absolute() || named.empty();
  for (const auto& part : folder) leads_out = leads_out || part == "..";
  require(!leads_out, "slam_command_t: folder is not below maps_folder");
  return allowed / folder;
}

}  // namespace marco::slam
