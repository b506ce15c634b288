#include "recordings/ros/unpacked_file.hpp"

#include <stdlib.h>  // mkstemp
#include <unistd.h>
#include <zstd.h>

#include <array>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "lcm_tools/files/readable.hpp"

namespace marco::ros {
namespace {

struct FileCloser {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, FileCloser>;

void unpack(std::FILE* packed, std::FILE* plain, const std::string& into) {
  const std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context(ZSTD_createDCtx(),
                                                                     &ZSTD_freeDCtx);
  std::vector<char> in(ZSTD_DStreamInSize()), out(ZSTD_DStreamOutSize());
  while (const std::size_t got = std::fread(in.data(), 1, in.size(), packed)) {
    ZSTD_inBuffer input{in.data(), got, 0};
    while (input.pos < input.size) {
      ZSTD_outBuffer output{out.data(), out.size(), 0};
      if (ZSTD_isError(ZSTD_decompressStream(context.get(), &output, &input)) != 0) return;
      if (std::fwrite(out.data(), 1, output.pos, plain) != output.pos) {
        throw std::runtime_error(into + ": no space to unpack a zstd file; TMPDIR says where to");
      }
    }
  }
}

}  // namespace

UnpackedFile::UnpackedFile(const std::filesystem::path& packed) {
  files::require_readable(packed);
  std::string name = (std::filesystem::temp_directory_path() / "marco_unpacked_XXXXXX").string();
  const int fd = ::mkstemp(name.data());
  if (fd < 0) throw std::runtime_error(name + ": cannot be made; TMPDIR says where to");
  path_ = name;
  try {
    const File plain(::fdopen(fd, "wb"));
    const File from(std::fopen(packed.c_str(), "rb"));
    unpack(from.get(), plain.get(), name);
    if (std::fflush(plain.get()) != 0) throw std::runtime_error(name + ": no space");
  } catch (...) {
    std::filesystem::remove(path_);
    throw;
  }
}

UnpackedFile::~UnpackedFile() {
  std::error_code ignored;
  std::filesystem::remove(path_, ignored);
}

}  // namespace marco::ros
