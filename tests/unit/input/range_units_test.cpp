#include "common/input/range_units.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include "tests/support/flat_world.hpp"

namespace marco {
namespace {

using ::testing::HasSubstr;

// What is said of 25 scans of a room, each range changed by `change`.
std::string said_of(const std::function<float(float, std::mt19937&)>& change) {
  const testing::FlatWorld room = testing::small_room();
  std::mt19937 random(7);
  RangeUnits units;
  std::string said;
  for (int i = 0; i < 25; ++i) {
    LaserScan scan = room.scan({-2.0 + 0.1 * i, -2.0, 0.3}, 0.01, &random);
    for (float& range_m : scan.ranges_m) range_m = change(range_m, random);
    const auto wrong = units.look(scan);
    if (i < 19) {
      EXPECT_FALSE(wrong) << i;
    } else {
      EXPECT_TRUE(i == 19 || said == wrong.value_or("")) << "of the twentieth scan, and for good";
    }
    said = wrong.value_or("");
  }
  return said;
}

TEST(RangeUnits, MillimetresAndCentimetresAreRecognised) {
  EXPECT_THAT(said_of([](float range_m, auto&) { return std::round(1000.0F * range_m); }),
              HasSubstr("millimetres"));
  EXPECT_THAT(said_of([](float range_m, auto&) { return std::round(100.0F * range_m); }),
              HasSubstr("divide the ranges by 100"));
}

TEST(RangeUnits, MetresAreNot) {
  EXPECT_EQ(said_of([](float range_m, auto&) { return range_m; }), "");
  // Outdoors: far trees of a laser of 80 m.
  EXPECT_EQ(said_of([](float, std::mt19937& random) {
              return std::uniform_real_distribution<float>(20.0F, 79.9F)(random);
            }),
            "");
}

// In a hall most beams have no return, whatever stands for that.
TEST(RangeUnits, OfFewReturnsAmongBeamsWithoutOnesMillimetresAreRecognised) {
  for (const float none : {0.0F, -1.0F, std::nanf(""), std::numeric_limits<float>::infinity()}) {
    EXPECT_THAT(said_of([none](float range_m, std::mt19937& random) {
                  return random() % 10 < 6 ? none : std::round(1000.0F * range_m);
                }),
                HasSubstr("millimetres"))
        << none;
  }
}

TEST(RangeUnits, OneReturnInSevenIsEnough) {
  EXPECT_THAT(said_of([](float range_m, std::mt19937& random) {
                return random() % 100 < 85 ? 65535.0F : std::round(1e4F * range_m) / 10.0F;
              }),
              HasSubstr("millimetres"));
}

// Two lasers' codes for "no return", which most beams of a hall may have.
TEST(RangeUnits, CodesAreNoRanges) {
  for (const float code : {8191.0F, 65535.0F}) {
    EXPECT_EQ(said_of([code](float range_m, std::mt19937& random) {
                return random() % 10 < 7 ? code : range_m;
              }),
              "");
    EXPECT_EQ(said_of([code](float, auto&) { return code; }), "");
  }
}

}  // namespace
}  // namespace marco
