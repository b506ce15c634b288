#include "lcm_tools/files/whole_file.hpp"

#include <array>
#include <fstream>
#include <stdexcept>

#include "lcm_tools/files/readable.hpp"

namespace marco::files {

void write_whole_file(const std::filesystem::path& path,
                      std::string_view content,
                      Appears appears) {
  OutputFile file(path, appears);
  file.write(content);
  file.finish();
}

std::string read_whole_file(const std::filesystem::path& path, int64_t most_bytes) {
  const std::string why = why_not_readable(path);
  if (!why.empty()) throw std::invalid_argument(path.string() + ": cannot be read: " + why);
  std::ifstream file(path, std::ios::binary);
  // All at once where the size is known: files of /proc have none.
  std::error_code no_size;
  const auto size = std::filesystem::file_size(path, no_size);
  const bool is_too_long = !no_size && size > static_cast<uint64_t>(most_bytes);
  if (is_too_long) {
    throw std::invalid_argument(path.string() + ": is larger than " +
                                std::to_string(most_bytes >> 20) + " MB");
  }
  std::string content(no_size ? 0 : static_cast<std::size_t>(size), '\0');
  file.read(content.data(), static_cast<std::streamsize>(content.size()));
  content.resize(static_cast<std::size_t>(file.gcount()));
  std::array<char, 1 << 16> more;
  while (file.read(more.data(), more.size()) || file.gcount() > 0) {
    content.append(more.data(), static_cast<std::size_t>(file.gcount()));
  }
  if (file.bad() || !file.eof()) throw std::invalid_argument(path.string() + ": cannot be read");
  return content;
}

}  // namespace marco::files
