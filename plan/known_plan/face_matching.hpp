#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "plan/known_plan/plan_sight.hpp"

namespace marco::plan {

inline constexpr double kSameWallM = 0.25;  ///< a face farther off is another wall

/// Which measured faces belong to which drawn ones: of one wall, facing one way. Both in the
/// drawing's frame; they outlive the object.
class FaceMatching {
 public:
  FaceMatching(const std::vector<DrawnFace>& drawn, const std::vector<WallFace>& measured)
      : drawn_(drawn), measured_(measured) {}

  /// The measured faces on a drawn one, which lie on one line: of a wall and what stands before it,
  /// the longer. What another drawn face explains better is none of this one's.
  std::vector<std::size_t> faces_on(const WallFace& drawn) const;

  /// Where the plan draws walls as single lines in their middle: most lines that were measured from
  /// both sides lie there. Moves drawn faces by half the wall's thickness, to where the wall's face
  /// should be. @param drawn  the same as the constructor's
  /// @returns the walls' thickness, the median; 0 where faces are drawn, and nothing was moved
  double draw_faces_of_axes(std::vector<DrawnFace>& drawn) const;

 private:
  double nearest_drawn_m(const WallFace& face) const;
  std::optional<double> measured_off(const WallFace& drawn) const;
  std::optional<std::size_t> back_of(const WallFace& front) const;

  const std::vector<DrawnFace>& drawn_;
  const std::vector<WallFace>& measured_;
};

/// Whether these are the two sides of one line.
bool is_one_line(const WallFace& front, const WallFace& back);

}  // namespace marco::plan
