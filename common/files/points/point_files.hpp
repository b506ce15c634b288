#pragma once

#include <filesystem>
#include <optional>

#include "common/point_cloud.hpp"

namespace marco::files {

/// Formats of point files.
enum class PointFormat {
  pcd,  ///< of PCL: text, binary, or compressed
  ply,  ///< text or binary of either byte order; a mesh is read as its vertices
  xyz,  ///< a line a point: x y z, then an intensity, or a colour, or both [m]
  pts,  ///< of Leica: the number of points, then as xyz; several blocks are one scan
  ptx,  ///< of Leica: organized, with the scanner's pose before the points
  uos   ///< of 3DTK (.3d): x (right) y (up) z (ahead) [cm], left-handed, then a reflectance
};

/// By the content; text also by the ending (.xyz .txt .asc .csv .pts .ptx: by the content which of
/// them; .3d). @returns nothing for other files.
std::optional<PointFormat> point_format_of(const std::filesystem::path& path);

/// Reads any of them. Columns of text mean what a line of names says, or else: 4 an intensity, 6 a
/// colour, 7 both; more are ignored. Points beyond 10 km lie from the first one's whole metres.
/// x forward, y left, z up as the file has them; those of uos are turned there. The pose is the
/// file's own (PCD's VIEWPOINT, PTX; the identity says nothing), or that of a file next to it,
/// NAME.pose: see read_scan_pose.
/// @throws std::invalid_argument naming file, line or byte, and what is wrong: it never takes more
/// memory than the file's size explains. A PTX file of several scans is refused.
PointCloud read_points(const std::filesystem::path& path);

/// Writes a scan, binary where the format knows it. The pose goes into the file where the format
/// knows it, and into NAME.pose next to it where not; a cloud without a pose leaves such a file
/// alone. Beams without a return are left out but of pcd and ptx. Text has hundredths of a
/// millimetre.
/// @throws std::runtime_error naming the path when it cannot be written.
/// @throws std::invalid_argument for ptx of points in no order, and for other numbers of
/// intensities, colours or rows than there are points.
void write_points(const std::filesystem::path& path, PointFormat format, const PointCloud& cloud);

/// A scanner's pose from a file of numbers, by how many there are: 6 as 3DTK has it (x y z [cm],
/// three angles about x, y, z [deg], Rx Ry Rz, left-handed, y up), 7 (x y z [m], quaternion x y z
/// w), 8 (the same after a stamp, as TUM), 12 or 16 (rows of a matrix [m]).
/// @returns nothing when there is no such file.
/// @throws std::invalid_argument naming the file for other numbers, or no rotation.
std::optional<Pose3> read_scan_pose(const std::filesystem::path& path);

}  // namespace marco::files
