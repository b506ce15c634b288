#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "slam/slam_state.hpp"

namespace marco::slam {

/// The name under which a map is kept in its folder.
inline constexpr const char* kSavedMapName = "map.marco";

/// A map to localize in and to extend.
struct SavedMap {
  std::string options;  ///< those it was made with, as TOML: for people, and to see a difference
  std::vector<int64_t> session_starts;  ///< index of each session's first scan in `slam.path.scans`
  SlamState slam;

  template <class Visitor>
  void visit(Visitor& v) {
    v("options", options);
    v("session_starts", session_starts);
    v("slam", slam);
  }
};

/// @throws std::invalid_argument as check(SlamState), or for sessions that start at no scan.
void check(const SavedMap& map);

/// As bytes: the envelope of common/byte_archive.hpp, then the fields as visit() lists them.
std::string encode_saved_map(const SavedMap& map);

/// @throws std::invalid_argument saying what is wrong, to be put behind the file's name: "is no
/// MARCOMAP file", "is of version 3 ...", "is truncated", "is damaged", or how it contradicts
/// itself. Never reads beyond its bytes, nor allocates more than a few times their number.
SavedMap decode_saved_map(std::string_view bytes);

}  // namespace marco::slam
