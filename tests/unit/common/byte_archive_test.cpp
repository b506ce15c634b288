#include "common/byte_archive.hpp"

#include <gmock/gmock.h>

#include "lcm_tools/tests/support/temporary_folder.hpp"

namespace marco {
namespace {

using testing::complaint;

struct Part {
  int32_t count = 0;
  std::vector<double> values_m;

  template <class Visitor>
  void visit(Visitor& v) {
    v("count", count);
    v("values_m", values_m);
  }
};

struct Whole {
  std::vector<Part> parts;
  std::deque<Pose2> poses;
  std::optional<Part> last;
  bool known = false;

  template <class Visitor>
  void visit(Visitor& v) {
    v("parts", parts);
    v("poses", poses);
    v("last", last);
    v("known", known);
  }
};

std::string bytes_of(Whole whole) {
  ByteWriter writer;
  archive(writer, whole);
  return writer.take();
}

TEST(ByteArchive, AStructIsWrittenInTheOrderOfItsVisit) {
  Whole whole;
  whole.parts = {{7, {0.5}}};
  whole.known = true;
  const std::string bytes = bytes_of(whole);
  // One part: length 8, count 4, its list 8 + 8; no pose 8; no last 1; known 1.
  ASSERT_EQ(bytes.size(), 8U + 4U + 16U + 8U + 1U + 1U);
  EXPECT_EQ(bytes[0], 1);
  EXPECT_EQ(bytes[8], 7);
  EXPECT_EQ(bytes[12], 1);
  EXPECT_EQ(bytes.back(), 1);
}

TEST(ByteArchive, WhatWasWrittenIsReadBack) {
  Whole whole;
  whole.parts = {{-1, {}}, {2, {1.5, -2.5}}};
  whole.poses = {{1, 2, 3}, {4, 5, 0.6}};
  whole.last = Part{3, {0.25}};
  const std::string bytes = bytes_of(whole);
  ByteReader reader(bytes);
  Whole read;
  archive(reader, read);
  EXPECT_EQ(reader.left(), 0U);
  EXPECT_EQ(bytes_of(read), bytes);
  EXPECT_EQ(read.parts.at(1).values_m, whole.parts[1].values_m);
  EXPECT_EQ(read.poses.at(1).theta_rad, 0.6);
  EXPECT_EQ(read.last->count, 3);
}

TEST(ByteArchive, ALengthIsNotBelievedBeyondTheBytesThatAreLeft) {
  EXPECT_EQ(fewest_bytes<Part>(), 4U + 8U);
  EXPECT_EQ(fewest_bytes<Whole>(), 8U + 8U + 1U + 1U);
  Whole whole;
  whole.parts.resize(3);
  std::string bytes = bytes_of(whole);
  bytes[0] = 4;  // of 3 parts, 36 bytes, 10 more behind them
  ByteReader reader(bytes);
  Whole read;
  EXPECT_EQ(complaint([&] { archive(reader, read); }), "is truncated");
  EXPECT_TRUE(read.parts.empty());
}

TEST(ByteArchive, SealedBytesAreCheckedByTheCrc32OfZip) {
  EXPECT_EQ(crc32("123456789"), 0xCBF43926U);  // the check value of CRC-32/ISO-HDLC
  std::string sealed = seal("MARCOABC", 3, "payload");
  EXPECT_EQ(unseal("MARCOABC", 3, sealed), "payload");
  EXPECT_EQ(
      complaint([&] { unseal("MARCOABC", 4, sealed); }),
      "is of version 3; this program reads version 4: open it with the release that wrote it, or "
      "start without it");
  sealed[sealed.size() - 6] ^= 1;
  EXPECT_EQ(complaint([&] { unseal("MARCOABC", 3, sealed); }), "is damaged");
}

}  // namespace
}  // namespace marco
