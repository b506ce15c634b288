#pragma once

#include <filesystem>

namespace marco::ros {

/// What a zstd file holds, as a file of its own while this lives.
class UnpackedFile {
 public:
  /// A frame that ends too early gives what there is of it.
  /// @throws std::invalid_argument where it cannot be read, std::runtime_error where the temporary
  /// folder is full.
  explicit UnpackedFile(const std::filesystem::path& packed);
  ~UnpackedFile();
  UnpackedFile(const UnpackedFile&) = delete;
  UnpackedFile& operator=(const UnpackedFile&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace marco::ros
