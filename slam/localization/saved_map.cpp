#include "slam/localization/saved_map.hpp"

#include "common/byte_archive.hpp"

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
  ByteReader reader(unseal(kName, kVersion, bytes));
  SavedMap map;
  archive(reader, map);
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
