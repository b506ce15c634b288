#include "common/files/whole_file.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace marco::files {

void write_whole_file(const std::filesystem::path& path, std::string_view content) {
  const std::string temporary = path.string() + ".part";
  const auto fail = [&](int error) {
    std::remove(temporary.c_str());
    throw std::runtime_error(path.string() + ": cannot be written: " + std::strerror(error));
  };
  std::FILE* file = std::fopen(temporary.c_str(), "wb");
  if (file == nullptr) fail(errno);
  const bool written = std::fwrite(content.data(), 1, content.size(), file) == content.size() &&
                       std::fflush(file) == 0;
  const int error = errno;
  const bool closed = std::fclose(file) == 0;
  if (!written || !closed) fail(error);
  if (std::rename(temporary.c_str(), path.c_str()) != 0) fail(errno);
}

std::string read_whole_file(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream content;
  content << file.rdbuf();
  if (!file) throw std::invalid_argument(path.string() + ": cannot be read");
  return content.str();
}

}  // namespace marco::files
