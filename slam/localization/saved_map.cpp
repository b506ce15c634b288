#include "slam/localization/saved_map.hpp"

#include "common/byte_archive.hpp"
#include "slam/localization/saved_map_v5.hpp"

namespace marco::slam {
namespace {

constexpr std::string_view kName = "MARCOMAP";
constexpr uint32_t kVersion = 12;

}  // namespace

std::string encode_saved_map(const SavedMap& map) {
  SavedMap copy = map;
  ByteWriter writer;
  archive(writer, copy);
  return seal(kName, kVersion, writer.take());
}

SavedMap decode_saved_map(std::string_view bytes) {
  const bool is_old = sealed_version(kName, bytes) == 5;
  ByteReader reader(unseal(kName, is_old ? 5 : kVersion, bytes));
  SavedMap map;
  if (is_old) {
    map = version_5::read(reader);
  } else {
    archive(reader, map);
  }
  require(reader.left() == 0, "has bytes left over");
  check(map);
  return map;
}

void check(const SavedMap& map) {
  check(map.slam);
  require(!map.session_starts.empty(), "has no session");
  for (const int64_t start : map.session_starts) {
    require(start >= 0 && start <= static_cast<int64_t>(map.slam.path.scans.size()),
            "a session starts at no scan");
  }
}

}  // namespace marco::slam
