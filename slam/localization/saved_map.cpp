#include "slam/localization/saved_map.hpp"

#include "common/byte_archive.hpp"

namespace marco::slam {
namespace {

constexpr std::string_view kName = "MARCOMAP";
// A map of each version since the oldest is read; its number is the layout of SlamState.
constexpr uint32_t kOldest = 12, kVersion = kDriftLayout;

}  // namespace

std::string encode_saved_map(const SavedMap& map) {
  SavedMap copy = map;
  ByteWriter writer;
  archive(writer, copy);
  return seal(kName, kVersion, writer.take());
}

SavedMap decode_saved_map(std::string_view bytes) {
  const Unsealed file = unseal(kName, kOldest, kVersion, bytes);
  ByteReader reader(file.payload, file.version);
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
