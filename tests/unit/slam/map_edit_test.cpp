#include "slam/map/map_edit.hpp"

#include <gmock/gmock.h>

#include <numbers>
#include <utility>

namespace marco::slam {
namespace {

using ::testing::HasSubstr;

std::string fault_of(const std::string& text) {
  try {
    parse_map_edits(text);
  } catch (const std::invalid_argument& fault) {
    return fault.what();
  }
  return "";
}

TEST(MapEdit, AllLinesThatArePrintedAreRead) {
  const Utime from = Utime::from_us(976052905'167303), to = Utime::from_us(976052911'000042);
  for (const auto kind : {MapEdit::Kind::forbid_loop, MapEdit::Kind::add_loop,
                          MapEdit::Kind::drop_scans, MapEdit::Kind::distrust_odometry}) {
    const MapEdits read = parse_map_edits(to_line({kind, from, to, {1.25, -0.5, 0.125}}));
    ASSERT_EQ(read.size(), 1U);
    EXPECT_EQ(read[0].kind, kind);
    EXPECT_EQ(read[0].from, from);
    EXPECT_EQ(read[0].to, to);
    const bool has_pose = kind == MapEdit::Kind::add_loop;
    EXPECT_EQ(read[0].from_from_to.vector(),
              has_pose ? Eigen::Vector3d(1.25, -0.5, 0.125) : Eigen::Vector3d::Zero());
  }
}

TEST(MapEdit, CommentsAndEmptyLinesAreLeftOut) {
  const MapEdits read = parse_map_edits("# from the report\n\n  drop_scans 1.5 2 # a lift\r\n");
  ASSERT_EQ(read.size(), 1U);
  EXPECT_EQ(read[0].from.us, 1'500'000);
  EXPECT_EQ(read[0].to.us, 2'000'000);
}

TEST(MapEdit, FaultsNameLineAndCause) {
  EXPECT_THAT(fault_of("\nforget_loop 1 2"), HasSubstr("line 2: 'forget_loop' is not one of"));
  EXPECT_THAT(fault_of("forbid_loop 1"), HasSubstr("line 1: expected two times in seconds"));
  EXPECT_THAT(fault_of("forbid_loop 1 soon"), HasSubstr("two times in seconds"));
  EXPECT_THAT(fault_of("forbid_loop -1 2"), HasSubstr("two times in seconds"));
  EXPECT_THAT(fault_of("drop_scans 3 2"), HasSubstr("the later time comes first"));
  EXPECT_THAT(fault_of("add_loop 1 2 0.5 1"), HasSubstr("x [m], y [m] and theta [rad]"));
  EXPECT_THAT(fault_of("add_loop 1 2 0.5 1 nan"), HasSubstr("x [m], y [m] and theta [rad]"));
  EXPECT_THAT(fault_of("drop_scans 1 2 3"), HasSubstr("'3' is too much"));
}

TEST(MapEdit, ForbidsTheLoopThatItMeansInEitherOrder) {
  const MapEdits edits = parse_map_edits("forbid_loop 100 200\nadd_loop 300 400 0 0 0");
  const auto at = [](double s) { return Utime::from_us(static_cast<int64_t>(s * 1e6)); };
  EXPECT_TRUE(forbids(edits, at(104), at(197)));
  EXPECT_TRUE(forbids(edits, at(200), at(100)));
  EXPECT_FALSE(forbids(edits, at(106), at(200)));
  EXPECT_FALSE(forbids(edits, at(100), at(100)));
  EXPECT_FALSE(forbids(edits, at(300), at(400)));
}

TEST(MapEdit, CoversItsStretchOfTime) {
  const MapEdits edits = parse_map_edits("drop_scans 10 20");
  const auto dropped = [&edits](int64_t s) {
    return is_covered(edits, MapEdit::Kind::drop_scans, Utime::from_us(s * 1'000'000));
  };
  EXPECT_TRUE(dropped(10));
  EXPECT_TRUE(dropped(20));
  EXPECT_FALSE(dropped(9));
  EXPECT_FALSE(dropped(21));
  EXPECT_FALSE(is_covered(edits, MapEdit::Kind::distrust_odometry, Utime::from_us(15'000'000)));
}

TEST(MapEdit, TimesAreReadToTheMicrosecondWithAsManyDigitsAsAreWritten) {
  const auto from_us = [](const std::string& time) {
    return parse_map_edits("drop_scans " + time + " 999999999999").at(0).from.us;
  };
  EXPECT_EQ(from_us("7"), 7'000'000);
  EXPECT_EQ(from_us("7."), 7'000'000);
  EXPECT_EQ(from_us("7.04"), 7'040'000);
  EXPECT_EQ(from_us("7.0000019"), 7'000'001);
  EXPECT_EQ(from_us("976052905.167303"), 976052905'167303);
  for (const std::string wrong : {".5", "1.5s", "1,5", "1.2.3", "1e3", "1000000000000", "0x10"}) {
    EXPECT_THAT(fault_of("drop_scans " + wrong + " 999999999999"),
                HasSubstr("two times in seconds"))
        << wrong;
  }
}

TEST(MapEdit, AMomentIsAStretchOfTimeAndATurnIsTheNearestOne) {
  const MapEdits read = parse_map_edits("drop_scans 5 5\nadd_loop 1 2 -0.5 1 7.0\n");
  ASSERT_EQ(read.size(), 2U);
  EXPECT_TRUE(is_covered(read, MapEdit::Kind::drop_scans, Utime::from_us(5'000'000)));
  EXPECT_EQ(read[1].from_from_to.vector().head<2>(), Eigen::Vector2d(-0.5, 1.0));
  EXPECT_NEAR(read[1].from_from_to.theta_rad, 7.0 - 2.0 * std::numbers::pi, 1e-12);
  EXPECT_THAT(fault_of("add_loop 1 2 inf 1 0"), HasSubstr("x [m], y [m] and theta [rad]"));
  EXPECT_THAT(fault_of("add_loop 1 2 0 1 0 9"), HasSubstr("'9' is too much"));
}

TEST(MapEdit, ALoopIsTheOneThatIsMeantOnlyWhenBothItsEndsAre) {
  const MapEdits edits = parse_map_edits("drop_scans 0 1000\nforbid_loop 100 200");
  const auto forbidden = [&edits](int64_t from_s, int64_t to_s) {
    return forbids(edits, Utime::from_us(from_s * 1'000'000), Utime::from_us(to_s * 1'000'000));
  };
  EXPECT_TRUE(forbidden(95, 205));
  EXPECT_TRUE(forbidden(205, 95));
  for (const auto& [from_s, to_s] :
       {std::pair{100, 300}, {300, 200}, {200, 300}, {300, 100}, {200, 200}, {94, 200}}) {
    EXPECT_FALSE(forbidden(from_s, to_s)) << from_s << " " << to_s;
  }
}

}  // namespace
}  // namespace marco::slam
