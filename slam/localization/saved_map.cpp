#include "slam/localization/saved_map.hpp"

#include "slam/localization/slam_archive.hpp"

namespace marco::slam {
namespace {

constexpr std::string_view kName = "MARCOMAP";
constexpr uint32_t kVersion = 1;

template <class Archive>
void archive_map(Archive& bytes, SavedMap& map) {
  archive(bytes, map.options);
  archive_list(bytes, map.session_starts, sizeof(int64_t));
  archive(bytes, map.slam);
}

}  // namespace

std::string encode_saved_map(const SavedMap& map) {
  SavedMap copy = map;
  ByteWriter writer;
  archive_map(writer, copy);
  return seal(kName, kVersion, writer.take());
}

SavedMap decode_saved_map(std::string_view bytes) {
  ByteReader reader(unseal(kName, kVersion, bytes));
  SavedMap map;
  archive_map(reader, map);
  require(reader.left() == 0, "has bytes left over");
  check(map.slam);
  for (const int64_t start : map.session_starts) {
    require(start >= 0 && start <= static_cast<int64_t>(map.slam.scans.size()),
            "a session starts at no scan");
  }
  return map;
}

}  // namespace marco::slam
