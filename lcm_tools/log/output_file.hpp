#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "lcm_tools/files/output_file.hpp"
#include "lcm_tools/files/output_folder.hpp"

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

/// A folder of results that a user asked for.
/// @throws std::invalid_argument when it holds anything and shall be kept.
class OutputFolder : public files::OutputFolder {
 public:
  OutputFolder(const std::filesystem::path& path,
               Existing existing,
               const std::string& owner,
               const std::filesystem::path& input);
};

}  // namespace marco::logs
