#include "recordings/ros/compression.hpp"

#include <bzlib.h>
#include <lz4frame.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <string>

#include "lcm_tools/base/check.hpp"

namespace marco::ros {
namespace {

// A claimed size is believed by pieces: a damaged one may ask for more memory than there is. Blocks
// of LZ4 have this size at most, and are unpacked in place where it is free.
constexpr std::size_t kPiece = std::size_t{4} << 20;

// Of a zstd frame, where it has one.
constexpr std::size_t kChecksumBytes = 4;

/// How far an unpacking came.
struct Progress {
  std::size_t bytes = 0;
  bool failed = false;

  Unpacker::Checksum checksum(uint64_t plain_size) const {
    return failed && bytes >= plain_size ? Unpacker::Checksum::wrong
                                         : Unpacker::Checksum::none_wrong;
  }
};

std::span<uint8_t> room_behind(std::size_t used, uint64_t wanted, ByteBuffer& plain) {
  plain.resize(used);
  const auto size = static_cast<std::size_t>(std::min<uint64_t>(wanted, kPiece));
  return plain.resize(used + size).subspan(used);
}

Progress from_bz2(std::span<const uint8_t> bytes, uint64_t plain_size, ByteBuffer& plain) {
  Progress done;
  bz_stream stream{};
  if (BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK) return done;
  // The library takes its input as char*, and does not write to it.
  stream.next_in = const_cast<char*>(reinterpret_cast<const char*>(bytes.data()));
  stream.avail_in = static_cast<unsigned>(bytes.size());
  int status = BZ_OK;
  while (status == BZ_OK && done.bytes < plain_size) {
    const auto room = room_behind(done.bytes, plain_size - done.bytes, plain);
    stream.next_out = reinterpret_cast<char*>(room.data());
    stream.avail_out = static_cast<unsigned>(room.size());
    status = BZ2_bzDecompress(&stream);
    const std::size_t got = room.size() - stream.avail_out;
    if (got == 0) break;
    done.bytes += got;
  }
  if (status == BZ_OK && done.bytes == plain_size) status = BZ2_bzDecompress(&stream);
  done.failed = status < 0;
  BZ2_bzDecompressEnd(&stream);
  return done;
}

// Block by block, as the library asks for them: those before a damaged one are whole, and behind
// the last one stands the checksum.
Progress from_lz4(LZ4F_dctx* context,
                  std::span<const uint8_t> bytes,
                  uint64_t plain_size,
                  ByteBuffer& plain) {
  constexpr std::size_t kLeastHeader = 7;
  LZ4F_resetDecompressionContext(context);
  Progress done;
  std::size_t wanted = kLeastHeader;
  while (wanted > 0 && !bytes.empty() && done.bytes <= plain_size) {
    const auto room = room_behind(done.bytes, kPiece, plain);
    std::size_t read = std::min(wanted, bytes.size()), wrote = room.size();
    wanted = LZ4F_decompress(context, room.data(), &wrote, bytes.data(), &read, nullptr);
    done.failed = LZ4F_isError(wanted) != 0;
    if (done.failed || (read == 0 && wrote == 0)) break;
    done.bytes += wrote;
    bytes = bytes.subspan(read);
  }
  return done;
}

// @param step  bytes that the library is given at a time. Of a call that fails it tells no
// progress, so the checksum at the end comes by itself.
Progress zstd_by(std::size_t step,
                 ZSTD_DCtx* context,
                 std::span<const uint8_t> bytes,
                 uint64_t plain_size,
                 ByteBuffer& plain) {
  ZSTD_DCtx_reset(context, ZSTD_reset_session_only);
  ZSTD_inBuffer in{bytes.data(), 0, 0};
  const std::size_t by_steps = step < bytes.size() ? bytes.size() - kChecksumBytes : 0;
  Progress done;
  while (!done.failed && done.bytes < plain_size) {
    if (in.pos == in.size) {
      in.size = in.size < by_steps ? std::min(by_steps, in.size + step) : bytes.size();
    }
    const auto room = room_behind(done.bytes, plain_size - done.bytes, plain);
    ZSTD_outBuffer out{room.data(), room.size(), 0};
    const std::size_t before = in.pos;
    done.failed = ZSTD_isError(ZSTD_decompressStream(context, &out, &in)) != 0;
    if (!done.failed && out.pos == 0 && in.pos == before && in.size == bytes.size()) break;
    done.bytes += out.pos;
  }
  return done;
}

// At once the library gives nothing of a damaged frame; by pieces, the blocks before the damage.
Progress from_zstd(ZSTD_DCtx* context,
                   std::span<const uint8_t> bytes,
                   uint64_t plain_size,
                   ByteBuffer& plain) {
  const Progress at_once = zstd_by(bytes.size(), context, bytes, plain_size, plain);
  if (!at_once.failed) return at_once;
  constexpr std::size_t kStep = 1024;
  Progress by_pieces = zstd_by(kStep, context, bytes, plain_size, plain);
  by_pieces.failed = true;
  return by_pieces;
}

Progress copied(std::span<const uint8_t> bytes, uint64_t plain_size, ByteBuffer& plain) {
  const auto size = static_cast<std::size_t>(std::min<uint64_t>(bytes.size(), plain_size));
  std::copy_n(bytes.begin(), size, plain.resize(size).begin());
  return {size};
}

}  // namespace

struct Unpacker::States {
  States() {
    LZ4F_dctx* raw = nullptr;
    LZ4F_createDecompressionContext(&raw, LZ4F_VERSION);
    lz4.reset(raw);
  }
  std::unique_ptr<LZ4F_dctx, decltype(&LZ4F_freeDecompressionContext)> lz4{
      nullptr, &LZ4F_freeDecompressionContext};
  std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> zstd{ZSTD_createDCtx(), &ZSTD_freeDCtx};
};

Unpacker::Unpacker() : states_(std::make_unique<States>()) {}
Unpacker::~Unpacker() = default;

Unpacker::Checksum Unpacker::unpack(std::string_view name,
                                    std::span<const uint8_t> bytes,
                                    uint64_t plain_size,
                                    ByteBuffer& plain) {
  require(plain_size <= kMostPlainBytes, "a chunk of more than 256 MB");
  Progress done;
  if (name.empty() || name == "none") {
    done = copied(bytes, plain_size, plain);
  } else if (name == "bz2") {
    done = from_bz2(bytes, plain_size, plain);
  } else if (name == "lz4") {
    done = from_lz4(states_->lz4.get(), bytes, plain_size, plain);
  } else {
    require(name == "zstd", "compression '" + std::string(name) + "' is not known");
    done = from_zstd(states_->zstd.get(), bytes, plain_size, plain);
  }
  plain.resize(static_cast<std::size_t>(std::min<uint64_t>(done.bytes, plain_size)));
  return done.checksum(plain_size);
}

std::span<const uint8_t> Unpacker::message(std::span<const uint8_t> bytes) {
  if (!is_zstd(bytes)) return bytes;
  const Progress done = from_zstd(states_->zstd.get(), bytes, kMostPlainBytes, message_);
  return message_.resize(done.failed || done.bytes == kMostPlainBytes ? 0 : done.bytes);
}

bool is_zstd(std::span<const uint8_t> bytes) {
  constexpr std::array<uint8_t, 4> kZstdMagic{0x28, 0xB5, 0x2F, 0xFD};
  return bytes.size() >= 4 && std::equal(kZstdMagic.begin(), kZstdMagic.end(), bytes.begin());
}

}  // namespace marco::ros
