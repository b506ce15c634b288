#include "common/pose2.hpp"

namespace marco {

Points2 operator*(const Pose2& a_from_b, const Points2& points_in_b) {
  return (a_from_b.rotation() * points_in_b).colwise() + a_from_b.translation_m();
}

}  // namespace marco
