#include "recordings/ros/compression.hpp"

#include <bzlib.h>
#include <gmock/gmock.h>
#include <lz4frame.h>
#include <zstd.h>

#include <random>
#include <string>
#include <vector>

namespace marco::ros {
namespace {

// Many blocks of each format; compressible, so that overwritten bytes cannot be any plain ones.
std::string plain_text(unsigned seed) {
  std::mt19937 random(seed);
  std::string text;
  while (text.size() < 1'000'000) text += std::to_string(random() % 1000) + ' ';
  return text;
}

std::string packed_by(const std::string& name, const std::string& plain) {
  std::string packed(2 * plain.size() + 1000, '\0');
  if (name == "bz2") {
    auto size = static_cast<unsigned>(packed.size());
    BZ2_bzBuffToBuffCompress(packed.data(), &size, const_cast<char*>(plain.data()),
                             static_cast<unsigned>(plain.size()), 1, 0, 0);
    packed.resize(size);
  } else if (name == "lz4") {
    LZ4F_preferences_t preferences{};
    preferences.frameInfo.blockSizeID = LZ4F_max64KB;
    preferences.frameInfo.contentChecksumFlag = LZ4F_contentChecksumEnabled;
    packed.resize(
        LZ4F_compressFrame(packed.data(), packed.size(), plain.data(), plain.size(), &preferences));
  } else {
    ZSTD_CCtx* context = ZSTD_createCCtx();
    ZSTD_CCtx_setParameter(context, ZSTD_c_checksumFlag, 1);
    packed.resize(
        ZSTD_compress2(context, packed.data(), packed.size(), plain.data(), plain.size()));
    ZSTD_freeCCtx(context);
  }
  return packed;
}

class Compression : public ::testing::TestWithParam<const char*> {
 protected:
  // @param piece  bytes that are asked for at a time
  std::string unpacked(const std::string& packed,
                       std::size_t plain_size,
                       std::size_t piece = 1 << 18) {
    ByteStream stream;
    stream.begin({reinterpret_cast<const uint8_t*>(packed.data()), packed.size()});
    unpacker_.begin(GetParam(), stream, plain_size);
    std::string plain;
    std::vector<uint8_t> some(piece);
    while (const std::size_t got = unpacker_.read(some))
      plain.append(some.begin(), some.begin() + static_cast<std::ptrdiff_t>(got));
    checksum_ = unpacker_.checksum();
    return plain;
  }

  Unpacker unpacker_;
  Unpacker::Checksum checksum_ = Unpacker::Checksum::wrong;
};
INSTANTIATE_TEST_SUITE_P(Ros, Compression, ::testing::Values("bz2", "lz4", "zstd"));

TEST_P(Compression, UnpacksChunkAfterChunk) {
  for (const unsigned seed : {1U, 2U}) {
    const std::string plain = plain_text(seed);
    EXPECT_TRUE(unpacked(packed_by(GetParam(), plain), plain.size()) == plain) << seed;
    EXPECT_EQ(checksum_, Unpacker::Checksum::none_wrong);
  }
}

TEST_P(Compression, UnpacksByPiecesOfAnySize) {
  const std::string plain = plain_text(1), packed = packed_by(GetParam(), plain);
  for (const std::size_t piece : {1000UL, 999'999UL, 4'000'000UL}) {
    EXPECT_TRUE(unpacked(packed, plain.size(), piece) == plain) << piece;
    EXPECT_EQ(checksum_, Unpacker::Checksum::none_wrong);
  }
  EXPECT_TRUE(unpacked(packed, 500'000, 65'536) == plain.substr(0, 500'000));
}

TEST_P(Compression, GivesTheBlocksBeforeDamageAndNothingOfTheChunkBefore) {
  const std::string plain = plain_text(1);
  std::string packed = packed_by(GetParam(), plain);
  unpacked(packed_by(GetParam(), plain_text(2)), plain.size());
  packed.replace(packed.size() / 2, 64, 64, '\xFF');
  const std::string found = unpacked(packed, plain.size());
  EXPECT_GT(found.size(), plain.size() / 5);  // blocks are of 64 to 128 kB
  EXPECT_LT(found.size(), plain.size());
  // What follows may be wrong: LZ4's blocks are unpacked whatever their bytes mean.
  const std::size_t sure = plain.size() / 5;
  EXPECT_TRUE(found.substr(0, sure) == plain.substr(0, sure));
}

TEST_P(Compression, TellsAWrongChecksumOfBytesThatAreAllThere) {
  const std::string plain = plain_text(1);
  std::string packed = packed_by(GetParam(), plain);
  packed[packed.size() - 2] ^= 0x10;
  EXPECT_TRUE(unpacked(packed, plain.size()) == plain);
  EXPECT_EQ(checksum_, Unpacker::Checksum::wrong);
}

TEST_P(Compression, GivesWhatACutOffChunkHolds) {
  const std::string plain = plain_text(1);
  const std::string packed = packed_by(GetParam(), plain);
  const std::string found = unpacked(packed.substr(0, packed.size() / 2), plain.size());
  EXPECT_GT(found.size(), plain.size() / 5);
  EXPECT_TRUE(plain.starts_with(found));
  EXPECT_EQ(checksum_, Unpacker::Checksum::none_wrong);
}

}  // namespace
}  // namespace marco::ros
