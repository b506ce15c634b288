#include "recordings/ros/unpacked_file.hpp"

#include <vector>

#include "recordings/ros/byte_file.hpp"
#include "recordings/ros/compression.hpp"

namespace marco::ros {

UnpackedFile::UnpackedFile(const std::filesystem::path& packed) : file_("to unpack a zstd file") {
  constexpr std::size_t kPiece = std::size_t{1} << 20;
  const ByteFile from(packed);
  ByteStream bytes;
  bytes.begin(from, 0, from.size());
  Unpacker unpacker;
  unpacker.begin("zstd", bytes, UINT64_MAX);
  std::vector<uint8_t> piece(kPiece);
  while (const std::size_t got = unpacker.read(piece)) file_.append({piece.data(), got});
}

}  // namespace marco::ros
