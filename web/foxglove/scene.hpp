#pragma once

#include <map>
#include <string>

#include "marco/mesh_t.hpp"

namespace marco::foxglove {

/// Tiles of a 3D model as foxglove.SceneUpdate: an entity a tile, which replaces its earlier state.
class SceneUpdates {
 public:
  /// @param stamp `"timestamp":{..}` of the message, @param frame  of its vertices
  /// @returns the message; "" where it contradicts itself. Where the model has fewer tiles than
  /// before, the others are deleted.
  std::string json(const std::string& channel,
                   const std::string& stamp,
                   const std::string& frame,
                   const mesh_t& tile);

 private:
  std::map<std::string, int32_t> tiles_;  // by channel
};

}  // namespace marco::foxglove
