#pragma once

#include <Eigen/Core>
#include <memory>

#include "viewer/gl_program.hpp"
#include "viewer/render_targets.hpp"

namespace marco::viewer {

/// Screen-space ambient occlusion: darkens pixels behind nearby surfaces, by the depths that were
/// drawn (shaders.hpp, kOcclusion). Must not outlive the context of its functions.
class OcclusionPass {
 public:
  explicit OcclusionPass(const GlFunctions& gl);

  struct View {
    Eigen::Matrix4d camera_from_clip;  ///< of the target
    double radius_m;                   ///< largest distance of surfaces that darken each other
    double px_per_m_at_1m;             ///< of the target; orthographic: at any distance
    bool perspective;
    int supersampling;  ///< shadows are soft: one sample per finished pixel suffices
  };

  /// @param surfaces colours and depths. @returns the same colours, darkened; good until the next
  /// call.
  const RenderTarget& apply(const RenderTarget& surfaces, const View& view);

 private:
  void run(const GlProgram& program, const RenderTarget& to, GLuint input, const View& view);

  const GlFunctions& gl_;
  GlProgram occlusion_;
  GlProgram blur_;
  GlProgram compose_;
  std::unique_ptr<RenderTarget> openness_target_;
  std::unique_ptr<RenderTarget> blurred_target_;
  std::unique_ptr<RenderTarget> composed_target_;
  GLuint no_vertices_ = 0;
};

}  // namespace marco::viewer
