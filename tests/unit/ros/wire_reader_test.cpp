#include "recordings/ros/wire_reader.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "recordings/ros/messages.hpp"

namespace marco::ros {
namespace {

std::vector<uint8_t> from_hex(const std::string& hex) {
  std::vector<uint8_t> bytes;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2) {
    bytes.push_back(static_cast<uint8_t>(std::stoi(hex.substr(i, 2), nullptr, 16)));
  }
  return bytes;
}

// {f32 1.5; f64 -2; string hi; u8 7; i32[] 1 -1; u16[2] 3 4; time 5.000000006}, written by other
// people's libraries.
void expect_mixed(WireReader in) {
  EXPECT_EQ(in.number<float>(), 1.5F);
  EXPECT_EQ(in.number<double>(), -2.0);
  EXPECT_EQ(in.string(), "hi");
  EXPECT_EQ(in.number<uint8_t>(), 7);
  EXPECT_EQ(in.sequence<int32_t>(), (std::vector<int32_t>{1, -1}));
  EXPECT_EQ(in.numbers<uint16_t>(2), (std::vector<uint16_t>{3, 4}));
  EXPECT_EQ(in.number<uint32_t>(), 5U);
  EXPECT_EQ(in.number<uint32_t>(), 6U);
  if (!in.is_cdr()) {
    EXPECT_EQ(in.number<int32_t>(), -1);
    EXPECT_EQ(in.number<int32_t>(), 500000000);
  }
  EXPECT_TRUE(in.boolean());
  in.finish();
}

TEST(WireReader, ReadsWhatRos1Wrote) {
  const auto bytes = from_hex(
      "0000c03f00000000000000c0020000006869070200000001000000ffffffff030004000500000006000000ffffff"
      "ff0065cd1d01");
  expect_mixed(WireReader::ros1(bytes));
}

TEST(WireReader, ReadsWhatRos2Wrote) {
  const auto bytes = from_hex(
      "000100000000c03f0000000000000000000000c003000000686900070200000001000000ffffffff030004000500"
      "00000600000001");
  expect_mixed(WireReader::cdr(bytes));
}

TEST(WireReader, ReadsBothByteOrdersAndPlainXcdr2) {
  for (const char* hex : {"000000000700000000000000c00000000000000000000003686900000003",
                          "00010000070000000000000000000000000000c003000000686900000300",
                          "000700000700000000000000000000c003000000686900000300"}) {
    const auto bytes = from_hex(hex);
    WireReader in = WireReader::cdr(bytes);
    EXPECT_EQ(in.number<uint8_t>(), 7) << hex;
    EXPECT_EQ(in.number<double>(), -2.0) << hex;
    EXPECT_EQ(in.string(), "hi") << hex;
    EXPECT_EQ(in.number<uint16_t>(), 3) << hex;
  }
}

TEST(WireReader, RefusesWhatDoesNotFit) {
  const auto delimited = from_hex("0009000001000000");
  EXPECT_THROW(WireReader::cdr(delimited), WireError);
  const auto huge = from_hex("ffffffff00");
  WireReader in = WireReader::ros1(huge);
  EXPECT_THROW(in.sequence<double>(), WireError);
  const auto surplus = from_hex("0001000001000000aaaaaaaa");
  WireReader left = WireReader::cdr(surplus);
  left.number<uint32_t>();
  EXPECT_THROW(left.finish(), WireError);
}

TEST(WireReader, GivesWideStringsAsUtf8) {
  const auto bytes = from_hex("000100000300000061000000e900000000f60100");
  WireReader in = WireReader::cdr(bytes);
  EXPECT_EQ(in.wide_string(), "a\xC3\xA9\xF0\x9F\x98\x80");
}

TEST(Messages, AScanAndATransformAreDecoded) {
  Topic scans;
  scans.type = "sensor_msgs/LaserScan";
  scans.encoding = "ros1";
  const auto scan_bytes = from_hex(
      "000000006400000005000000050000006c617365720000c0bf0000c03f0000c03f00000000cdcccc3dcdcc4c3d00"
      "00f041030000000000803f0000807f0000204000000000");
  const LaserScanMessage scan = decode_scan({&scans, 0, 0, scan_bytes});
  EXPECT_EQ(scan.header.stamp_ns, 100'000'000'005);
  EXPECT_EQ(scan.header.frame_id, "laser");
  EXPECT_FLOAT_EQ(scan.angle_increment, 1.5F);
  ASSERT_EQ(scan.ranges.size(), 3U);
  EXPECT_TRUE(std::isinf(scan.ranges[1]));

  Topic tf;
  tf.type = "tf2_msgs/TFMessage";
  tf.encoding = "ros1";
  const auto tf_bytes = from_hex(
      "01000000000000000100000040503607040000006f646f6d0e000000626173655f666f6f747072696e74f66481fb"
      "fb5d4e3e000000000000000000000000000000000000000000000000000000000000000014d90378e4b3f43e5e36"
      "e5ffffffef3f");
  const auto transforms = decode_transforms({&tf, 0, 0, tf_bytes});
  ASSERT_EQ(transforms.size(), 1U);
  EXPECT_EQ(transforms[0].child_frame_id, "base_footprint");
  EXPECT_NEAR(transforms[0].parent_from_child.translation().x(), 1.41407951e-8, 1e-15);
  EXPECT_NEAR(flatten(transforms[0].parent_from_child).theta_rad, 2 * 1.97436380e-5, 1e-10);

  // Cut anywhere it is refused, and nothing is read behind its end.
  for (std::size_t size = 0; size < scan_bytes.size(); ++size) {
    const std::vector<uint8_t> cut(scan_bytes.begin(),
                                   scan_bytes.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_THROW(decode_scan({&scans, 0, 0, cut}), WireError) << size;
  }
}

}  // namespace
}  // namespace marco::ros
