#include "lcm_tools/base/printable.hpp"

#include <gtest/gtest.h>

#include <random>

namespace marco {
namespace {

TEST(Printable, TextStaysAndWhatATerminalObeysIsShown) {
  EXPECT_EQ(printable("LIDAR_FRONT größer 北 ✓ 😀"), "LIDAR_FRONT größer 北 ✓ 😀");
  EXPECT_EQ(printable("ESC\x1b]0;own\x07"), "ESC\\x1b]0;own\\x07");
  EXPECT_EQ(printable(std::string_view("a\0b\x7f\r\n", 6)), "a\\x00b\\x7f\\x0d\\x0a");
  EXPECT_EQ(printable("\xc2\x9b"
                      "31m"),
            "\\u009b31m");  // CSI of C1
  EXPECT_EQ(printable("\x9b"
                      "31m"),
            "\\x9b31m");                                      // the same as a byte
  EXPECT_EQ(printable("a\u202egpj.exe"), "a\\u202egpj.exe");  // written from right to left
  EXPECT_EQ(printable("\u2066\u061c\u2028\u200f"), "\\u2066\\u061c\\u2028\\u200f");
  EXPECT_EQ(printable("\xc3(\xff\xfe\xe2\x82"), "\\xc3(\\xff\\xfe\\xe2\\x82");
  EXPECT_EQ(printable("\xc0\x9b\xed\xa0\x80\xf4\x90\x80\x80"),  // too long, half a pair, beyond
            "\\xc0\\x9b\\xed\\xa0\\x80\\xf4\\x90\\x80\\x80");
  EXPECT_EQ(printable("\u00efbf\xef\xbf\xbd"), "\u00efbf\xef\xbf\xbd");  // U+FFFD itself
}

TEST(Printable, LinesAreKeptOrSetIn) {
  EXPECT_EQ(printable("a\n  b\nc\n", Newline::kept), "a\n  b\nc\n");
  EXPECT_EQ(printable("bad\n12:00:00 marco-slam info all is well\n  x\n", Newline::set_in),
            "bad\n  12:00:00 marco-slam info all is well\n  x\n");
}

TEST(Printable, IsCutBetweenCharacters) {
  EXPECT_EQ(printable("äöü", Newline::escaped, 5), "äö");
  EXPECT_EQ(printable("abc\x1b", Newline::escaped, 6), "abc");
}

TEST(Printable, OfAnyBytesIsPlain) {
  std::mt19937 random(7);
  for (int round = 0; round < 2000; ++round) {
    std::string bytes(random() % 40, '\0');
    for (char& byte : bytes) byte = static_cast<char>(random());
    const std::string shown = printable(bytes);
    std::string_view rest = shown;
    while (!rest.empty()) {
      const std::size_t before = rest.size();
      const char32_t code = take_character(rest);
      ASSERT_TRUE(is_drawn(code) && (code != 0xFFFD || before - rest.size() == 3)) << shown;
    }
    ASSERT_EQ(printable(shown), shown);
  }
}

}  // namespace
}  // namespace marco
