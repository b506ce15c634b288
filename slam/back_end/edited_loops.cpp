#include "slam/back_end/edited_loops.hpp"

#include <algorithm>
#include <cmath>

#include "common/covariance.hpp"

namespace marco::slam {
namespace {

constexpr double kSigmaM = 0.02, kSigmaDeg = 0.3;  // as a loop that the search found
constexpr double kNoScanS = 2.0;

const ScanPose* nearest(const std::vector<ScanPose>& path, Utime utime) {
  const auto off_s = [utime](const ScanPose& scan) {
    return std::abs((scan.utime - utime).seconds());
  };
  const auto found =
      std::min_element(path.begin(), path.end(),
                       [&](const ScanPose& a, const ScanPose& b) { return off_s(a) < off_s(b); });
  return found == path.end() || off_s(*found) > kNoScanS || found->key < 0 ? nullptr : &*found;
}

}  // namespace

void EditedLoops::set(const MapEdits& edits) {
  waiting_.clear();
  std::copy_if(edits.begin(), edits.end(), std::back_inserter(waiting_),
               [](const MapEdit& edit) { return edit.kind == MapEdit::Kind::add_loop; });
}

std::vector<PoseGraphEdge> EditedLoops::take_due(const std::vector<ScanPose>& path) {
  std::vector<PoseGraphEdge> edges;
  if (path.empty()) return edges;
  const Utime now = path.back().utime;
  std::erase_if(waiting_, [&](const MapEdit& edit) {
    if (edit.to > now) return false;
    const ScanPose *from = nearest(path, edit.from), *to = nearest(path, edit.to);
    if (from == nullptr || to == nullptr || from->key == to->key) return true;
    const Pose2 measured = from->key_from_robot * edit.from_from_to * to->key_from_robot.inverse();
    edges.push_back({from->key, to->key, measured,
                     information_of(diagonal_covariance(kSigmaM, deg_to_rad(kSigmaDeg))), false});
    return true;
  });
  return edges;
}

}  // namespace marco::slam
