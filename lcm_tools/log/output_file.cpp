#include "lcm_tools/log/output_file.hpp"

#include "lcm_tools/base/check.hpp"

namespace marco::logs {

void check_output_path(const std::filesystem::path& path,
                       Existing existing,
                       const std::vector<std::filesystem::path>& inputs) {
  std::error_code none;
  for (const auto& input : inputs) {
    require(!std::filesystem::equivalent(path, input, none),
            path.string() + ": is the input; give another name");
  }
  const bool keeps_nothing = std::filesystem::exists(path, none) &&
                             !std::filesystem::is_regular_file(path, none) &&
                             !std::filesystem::is_directory(path, none);
  require(existing == Existing::replace || keeps_nothing || !std::filesystem::exists(path, none),
          path.string() + ": already exists; --force replaces it");
}

namespace {

const std::filesystem::path& checked_folder(const std::filesystem::path& path, Existing existing) {
  require(existing == Existing::replace || !std::filesystem::exists(path) ||
              std::filesystem::is_empty(path),
          path.string() + ": is not empty; --force writes into it");
  return path;
}

}  // namespace

OutputFolder::OutputFolder(const std::filesystem::path& path,
                           Existing existing,
                           const std::string& owner,
                           const std::filesystem::path& input)
    : files::OutputFolder(checked_folder(path, existing), owner) {
  keep(input);
}

}  // namespace marco::logs
