#include "recordings/ros/compression.hpp"

#include <bzlib.h>
#include <lz4frame.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <string>

#include "lcm_tools/base/check.hpp"

namespace marco::ros {
namespace {

// What a library is given at a time. A zstd frame that is given whole is unpacked faster.
constexpr int64_t kPackedPiece = 1 << 20;

// Of a zstd frame that is damaged: a call that fails gives nothing, so each is given little, and
// the checksum at its end, where it has one, comes by itself.
constexpr int64_t kSmallPiece = 1 << 10, kZstdChecksumBytes = 4;

constexpr std::size_t kLeastLz4Header = 7;

}  // namespace

struct Unpacker::States {
  States() {
    LZ4F_dctx* raw = nullptr;
    LZ4F_createDecompressionContext(&raw, LZ4F_VERSION);
    lz4.reset(raw);
  }
  ~States() { BZ2_bzDecompressEnd(&bz2); }

  std::unique_ptr<LZ4F_dctx, decltype(&LZ4F_freeDecompressionContext)> lz4{
      nullptr, &LZ4F_freeDecompressionContext};
  std::size_t lz4_wants = 0;
  std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> zstd{ZSTD_createDCtx(), &ZSTD_freeDCtx};
  bool zstd_by_small_pieces = false;
  uint64_t zstd_again = 0;  // bytes that come a second time
  bz_stream bz2{};
  std::span<const uint8_t> rest;  // of a piece that a library was given
};

Unpacker::Unpacker() : states_(std::make_unique<States>()) {}
Unpacker::~Unpacker() = default;
Unpacker::Unpacker(Unpacker&&) noexcept = default;
Unpacker& Unpacker::operator=(Unpacker&&) noexcept = default;

void Unpacker::begin(std::string_view name, ByteStream& packed, uint64_t plain_size) {
  packed_ = &packed;
  plain_size_ = plain_size;
  done_ = 0;
  ended_ = failed_ = false;
  states_->rest = {};
  if (name.empty() || name == "none") {
    read_some_ = &Unpacker::read_copied;
  } else if (name == "bz2") {
    BZ2_bzDecompressEnd(&states_->bz2);
    ended_ = BZ2_bzDecompressInit(&states_->bz2, 0, 0) != BZ_OK;
    read_some_ = &Unpacker::read_bz2;
  } else if (name == "lz4") {
    LZ4F_resetDecompressionContext(states_->lz4.get());
    states_->lz4_wants = kLeastLz4Header;
    read_some_ = &Unpacker::read_lz4;
  } else {
    ended_ = name != "zstd";
    require(!ended_, "compression '" + std::string(name) + "' is not known");
    ZSTD_DCtx_reset(states_->zstd.get(), ZSTD_reset_session_only);
    states_->zstd_by_small_pieces = false;
    states_->zstd_again = 0;
    read_some_ = &Unpacker::read_zstd;
  }
}

std::size_t Unpacker::read(std::span<uint8_t> into) {
  while (!ended_) {
    // A checksum stands behind the last byte.
    std::array<uint8_t, 1> one_too_many{};
    const bool is_full = done_ == plain_size_;
    const auto room = is_full ? std::span<uint8_t>(one_too_many)
                              : into.first(std::min<uint64_t>(into.size(), plain_size_ - done_));
    const std::size_t got = (this->*read_some_)(room);
    if (got == 0) continue;
    if (!is_full) {
      done_ += got;
      return got;
    }
    ended_ = true;
  }
  return 0;
}

Unpacker::Checksum Unpacker::checksum() const {
  return failed_ && done_ == plain_size_ ? Checksum::wrong : Checksum::none_wrong;
}

std::size_t Unpacker::read_copied(std::span<uint8_t> into) {
  const auto bytes = packed_->next(static_cast<int64_t>(into.size()));
  std::copy(bytes.begin(), bytes.end(), into.begin());
  ended_ = bytes.empty();
  return bytes.size();
}

std::size_t Unpacker::read_bz2(std::span<uint8_t> into) {
  std::span<const uint8_t>& rest = states_->rest;
  if (rest.empty()) rest = packed_->next(kPackedPiece);
  bz_stream& stream = states_->bz2;
  // The library takes its input as char*, and does not write to it.
  stream.next_in = const_cast<char*>(reinterpret_cast<const char*>(rest.data()));
  stream.avail_in = static_cast<unsigned>(rest.size());
  stream.next_out = reinterpret_cast<char*>(into.data());
  stream.avail_out = static_cast<unsigned>(std::min<std::size_t>(into.size(), 1U << 30U));
  const unsigned room = stream.avail_out;
  const int status = BZ2_bzDecompress(&stream);
  const std::size_t took = rest.size() - stream.avail_in, got = room - stream.avail_out;
  rest = rest.subspan(took);
  failed_ = status < 0;
  ended_ = status != BZ_OK || (took == 0 && got == 0);
  return got;
}

// Block by block, as the library asks for them: those before a damaged one are whole, and behind
// the last one stands the checksum.
std::size_t Unpacker::read_lz4(std::span<uint8_t> into) {
  std::span<const uint8_t>& rest = states_->rest;
  if (rest.empty()) rest = packed_->next(static_cast<int64_t>(states_->lz4_wants));
  std::size_t took = rest.size(), got = into.size();
  const std::size_t wants =
      LZ4F_decompress(states_->lz4.get(), into.data(), &got, rest.data(), &took, nullptr);
  failed_ = LZ4F_isError(wants) != 0;
  ended_ = failed_ || wants == 0 || (took == 0 && got == 0);
  if (failed_) return 0;
  rest = rest.subspan(took);
  states_->lz4_wants = wants;
  return got;
}

std::size_t Unpacker::read_zstd(std::span<uint8_t> into) {
  States& states = *states_;
  if (states.rest.empty()) {
    const int64_t before_checksum = packed_->left() - kZstdChecksumBytes;
    const int64_t small =
        before_checksum > 0 ? std::min(kSmallPiece, before_checksum) : kSmallPiece;
    states.rest = packed_->next(states.zstd_by_small_pieces ? small : kPackedPiece);
  }
  ZSTD_inBuffer in{states.rest.data(), states.rest.size(), 0};
  ZSTD_outBuffer out{into.data(), into.size(), 0};
  const std::size_t status = ZSTD_decompressStream(states.zstd.get(), &out, &in);
  if (ZSTD_isError(status) != 0) {
    restart_zstd();
    return 0;
  }
  states.rest = states.rest.subspan(in.pos);
  const auto again = static_cast<std::size_t>(std::min<uint64_t>(out.pos, states.zstd_again));
  const std::size_t got = out.pos - again;
  states.zstd_again -= again;
  if (again > 0) std::memmove(into.data(), into.data() + again, got);
  ended_ = (in.pos == 0 && out.pos == 0) || (status == 0 && done_ + got == plain_size_);
  return got;
}

// From the first byte on, by small pieces.
void Unpacker::restart_zstd() {
  failed_ = true;
  ended_ = states_->zstd_by_small_pieces || done_ == plain_size_;
  states_->zstd_by_small_pieces = true;
  states_->zstd_again = done_;
  states_->rest = {};
  packed_->rewind();
  ZSTD_DCtx_reset(states_->zstd.get(), ZSTD_reset_session_only);
}

std::span<const uint8_t> Unpacker::message(std::span<const uint8_t> bytes) {
  if (!is_zstd(bytes)) return bytes;
  constexpr std::size_t kPiece = std::size_t{1} << 20;
  packed_message_.begin(bytes);
  begin("zstd", packed_message_, kMostMessageBytes);
  std::size_t size = 0;
  while (const std::size_t got = read(message_.resize(size + kPiece).subspan(size))) size += got;
  return message_.resize(failed_ || size == kMostMessageBytes ? 0 : size);
}

bool is_zstd(std::span<const uint8_t> bytes) {
  constexpr std::array<uint8_t, 4> kZstdMagic{0x28, 0xB5, 0x2F, 0xFD};
  return bytes.size() >= 4 && std::equal(kZstdMagic.begin(), kZstdMagic.end(), bytes.begin());
}

}  // namespace marco::ros
