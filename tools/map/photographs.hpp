#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "common/samples.hpp"
#include "common/trajectory.hpp"
#include "mapping3d/surface/texture.hpp"

namespace marco {

struct PhotographOptions {
  int most = 80;                     ///< of a model; painting takes its time from each
  double apart_m = 0.6;              ///< a picture is worth having if no other was taken so near
  double apart_deg = 25.0;           ///< in nearly this direction
  double max_turn_deg_per_s = 20.0;  ///< while the robot turns faster, stamps are not good enough
  double max_gap_s = 0.5;            ///< poses so far apart are interpolated
  mapping3d::TextureOptions texture;

  template <class Visitor>
  void visit(Visitor& v) {
    v("most", most, Limits{0, 10000});
    v("apart_m", apart_m, kPositive);
    v("apart_deg", apart_deg, Limits{0.1, 180.0});
    v("max_turn_deg_per_s", max_turn_deg_per_s, kPositive);
    v("max_gap_s", max_gap_s, kPositive);
    v("texture", texture);
  }
};

/// What became of a recording's pictures (bot_core.image_t on any channel).
struct PhotographCounts {
  int64_t recorded = 0;
  int64_t chosen = 0;
  std::map<std::string, int64_t> dropped;  ///< by cause; what others show as well is no cause
  std::map<std::string, double> painted;   ///< what the painter said, by name with unit
};

/// Chooses pictures of LCM logs (other recordings are passed by) that together show all there is
/// to see, each placed by the path and by what SENSOR_INFO and PANTILT_STATE say of its camera, and
/// writes them to `folder`/photographs with their list photographs.toml, as `marco texture` reads
/// it. Nothing is written when there are none.
/// @param path     of the robot, by the laser's stamps; in any order
/// @param sensors  newest SENSOR_INFO of each channel
PhotographCounts write_photographs(const std::filesystem::path& folder,
                                   const std::vector<std::string>& recordings,
                                   const Trajectory& path,
                                   const std::map<std::string, SensorInfo>& sensors,
                                   const PhotographOptions& options);

/// Has marco-texture paint `mesh` with folder/photographs.toml: model_textured.glb with its atlas
/// model_textured.png. @returns what it counted, by name with unit. A painter that cannot be
/// started or fails is said on standard error and leaves a map that is whole without it.
std::map<std::string, double> paint_elsewhere(const std::filesystem::path& folder,
                                              const TriangleMesh& mesh);

}  // namespace marco
