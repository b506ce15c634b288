#include "lcm_tools/files/whole_file.hpp"

#include <fstream>
#include <sstream>
#include <stdexcept>

#include "lcm_tools/files/folder_journal.hpp"
#include "lcm_tools/files/readable.hpp"

namespace marco::files {

void write_whole_file(const std::filesystem::path& path,
                      std::string_view content,
                      Appears appears) {
  OutputFile file(path, appears);
  file.write(content);
  file.finish();
}

std::string read_whole_file(const std::filesystem::path& path) {
  finish_interrupted(path.parent_path());
  const std::string why = why_not_readable(path);
  if (!why.empty()) throw std::invalid_argument(path.string() + ": cannot be read: " + why);
  std::ifstream file(path, std::ios::binary);
  std::ostringstream content;
  content << file.rdbuf();
  if (!file) throw std::invalid_argument(path.string() + ": cannot be read");
  return content.str();
}

}  // namespace marco::files
