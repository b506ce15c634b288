#pragma once

#include <string>

#include "common/point_cloud.hpp"
#include "lcm_tools/files/output_file.hpp"

/// The formats behind read_points() and write_points(). Readers take a file's content, and its name
/// for messages; they throw std::invalid_argument that begins with it.
namespace marco::files {

PointCloud read_pcd(const std::string& content, const std::string& name);
PointCloud read_ply_points(const std::string& content, const std::string& name);
PointCloud read_xyz(const std::string& content, const std::string& name);
PointCloud read_pts(const std::string& content, const std::string& name);
PointCloud read_ptx(const std::string& content, const std::string& name);
PointCloud read_uos(const std::string& content, const std::string& name);

void write_pcd(OutputFile& file, const PointCloud& cloud);
void write_ply_points(OutputFile& file, const PointCloud& cloud);
void write_xyz(OutputFile& file, const PointCloud& cloud);
void write_pts(OutputFile& file, const PointCloud& cloud);
void write_ptx(OutputFile& file, const PointCloud& cloud);
void write_uos(OutputFile& file, const PointCloud& cloud);

}  // namespace marco::files
