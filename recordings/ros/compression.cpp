#include "recordings/ros/compression.hpp"

#include <bzlib.h>
#include <lz4frame.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <memory>
#include <string>

#include "lcm_tools/base/check.hpp"

namespace marco::ros {
namespace {

using Bytes = std::vector<uint8_t>;

// A claimed size is believed by pieces: a damaged one may ask for more memory than there is.
constexpr std::size_t kPiece = std::size_t{4} << 20;

// `step` appends to the room at `at` and returns how much; 0 at the end.
template <class Step>
Bytes filled(uint64_t plain_size, Step step) {
  Bytes plain;
  std::size_t used = 0;
  while (used < plain_size) {
    const auto room = static_cast<std::size_t>(std::min<uint64_t>(plain_size - used, kPiece));
    plain.resize(used + room);
    const std::size_t got = step(std::span(plain).subspan(used));
    if (got == 0) break;
    used += got;
  }
  plain.resize(used);
  return plain;
}

Bytes from_bz2(std::span<const uint8_t> bytes, uint64_t plain_size) {
  bz_stream stream{};
  if (BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK) return {};
  // The library takes its input as char*, and does not write to it.
  stream.next_in = const_cast<char*>(reinterpret_cast<const char*>(bytes.data()));
  stream.avail_in = static_cast<unsigned>(bytes.size());
  bool ended = false;
  Bytes plain = filled(plain_size, [&](std::span<uint8_t> room) -> std::size_t {
    if (ended) return 0;
    stream.next_out = reinterpret_cast<char*>(room.data());
    stream.avail_out = static_cast<unsigned>(room.size());
    ended = BZ2_bzDecompress(&stream) != BZ_OK;
    return room.size() - stream.avail_out;
  });
  BZ2_bzDecompressEnd(&stream);
  return plain;
}

Bytes from_lz4(std::span<const uint8_t> bytes, uint64_t plain_size) {
  LZ4F_dctx* raw = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&raw, LZ4F_VERSION)) != 0) return {};
  const std::unique_ptr<LZ4F_dctx, decltype(&LZ4F_freeDecompressionContext)> context(
      raw, &LZ4F_freeDecompressionContext);
  bool failed = false;
  return filled(plain_size, [&](std::span<uint8_t> room) -> std::size_t {
    std::size_t wrote = 0;
    while (wrote == 0 && !failed) {
      std::size_t read = bytes.size();
      wrote = room.size();
      const auto left =
          LZ4F_decompress(context.get(), room.data(), &wrote, bytes.data(), &read, nullptr);
      bytes = bytes.subspan(read);
      failed = LZ4F_isError(left) != 0 || (wrote == 0 && (read == 0 || left == 0));
    }
    return wrote;
  });
}

Bytes from_zstd(std::span<const uint8_t> bytes, uint64_t plain_size) {
  const std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context(ZSTD_createDCtx(),
                                                                     &ZSTD_freeDCtx);
  ZSTD_inBuffer in{bytes.data(), bytes.size(), 0};
  return filled(plain_size, [&](std::span<uint8_t> room) -> std::size_t {
    ZSTD_outBuffer out{room.data(), room.size(), 0};
    while (out.pos == 0) {
      const std::size_t before = in.pos;
      const std::size_t left = ZSTD_decompressStream(context.get(), &out, &in);
      if (ZSTD_isError(left) != 0 || (out.pos == 0 && in.pos == before)) break;
    }
    return out.pos;
  });
}

}  // namespace

std::vector<uint8_t> decompressed(std::string_view name,
                                  std::span<const uint8_t> bytes,
                                  uint64_t plain_size) {
  require(plain_size <= kMostPlainBytes, "a chunk of more than 256 MB");
  if (name.empty() || name == "none") {
    const auto size = static_cast<std::size_t>(std::min<uint64_t>(bytes.size(), plain_size));
    return {bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)};
  }
  if (name == "bz2") return from_bz2(bytes, plain_size);
  if (name == "lz4") return from_lz4(bytes, plain_size);
  require(name == "zstd", "compression '" + std::string(name) + "' is not known");
  return from_zstd(bytes, plain_size);
}

std::vector<uint8_t> decompressed_zstd(std::span<const uint8_t> frame) {
  return from_zstd(frame, kMostPlainBytes);
}

bool is_zstd(std::span<const uint8_t> bytes) {
  constexpr std::array<uint8_t, 4> kZstdMagic{0x28, 0xB5, 0x2F, 0xFD};
  return bytes.size() >= 4 && std::equal(kZstdMagic.begin(), kZstdMagic.end(), bytes.begin());
}

}  // namespace marco::ros
