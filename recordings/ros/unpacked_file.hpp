#pragma once

#include <filesystem>

#include "recordings/ros/temporary_file.hpp"

namespace marco::ros {

/// What a zstd file holds, as a file of its own while this lives.
class UnpackedFile {
 public:
  /// A frame that ends too early gives what there is of it.
  /// @throws std::invalid_argument where it cannot be read, std::runtime_error where the temporary
  /// folder is full.
  explicit UnpackedFile(const std::filesystem::path& packed);

  const std::filesystem::path& path() const { return file_.path(); }

 private:
  TemporaryFile file_;
};

}  // namespace marco::ros
