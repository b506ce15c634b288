#pragma once

#include <filesystem>
#include <vector>

#include "lcm_tools/files/output_file.hpp"

namespace marco::logs {

enum class Existing { refuse, replace };

/// What a user allows to be written. Devices and pipes hold nothing that could be lost.
/// @param inputs files that must not be written over.
/// @throws std::invalid_argument when `path` exists and shall be kept, or is an input.
void check_output_path(const std::filesystem::path& path,
                       Existing existing,
                       const std::vector<std::filesystem::path>& inputs);

/// A file that a user asked for: checked as above before anything is written.
class OutputFile : public files::OutputFile {
 public:
  /// @throws as check_output_path and files::OutputFile.
  OutputFile(const std::filesystem::path& path,
             Existing existing,
             const std::vector<std::filesystem::path>& inputs)
      : files::OutputFile((check_output_path(path, existing, inputs), path)) {}
};

}  // namespace marco::logs
