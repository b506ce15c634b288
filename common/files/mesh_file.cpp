#include "common/files/mesh_file.hpp"

#include "common/files/obj.hpp"
#include "common/files/ply.hpp"

namespace marco::files {

TriangleMesh read_mesh(const std::filesystem::path& path) {
  return path.extension() == ".obj" ? read_obj(path) : read_ply(path);
}

}  // namespace marco::files
