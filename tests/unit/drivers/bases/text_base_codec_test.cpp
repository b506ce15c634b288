#include <gmock/gmock.h>

#include "drivers/textbase/codec.hpp"

namespace marco::drivers::textbase {
namespace {

// Of docs/text_base.md.
TEST(TextBaseCodec, ThePagesExamples) {
  const std::pair<BoardLine, const char*> said[] = {
      {Hello{1, "mybot", "0.3", 500}, "V 1 mybot 0.3 wd=500*3C"},
      {Report{123456, -1042, 988, 1}, "T 123456 -1042 988 1*71"}};
  for (const auto& [line, text] : said) {
    EXPECT_EQ(with_sum(encode(line)), text);
    const auto body = without_sum(text);
    ASSERT_TRUE(body && body->had_sum);
    EXPECT_EQ(parse_board_line(body->text), line);
  }
  EXPECT_EQ(with_sum(encode(Motion{250, -250})), "M 250 -250*60");
  EXPECT_EQ(with_sum(encode(Motion{0, 0})), "M 0 0*4D");
}

TEST(TextBaseCodec, ReadsWhatItWrites) {
  for (const BoardLine& line : std::initializer_list<BoardLine>{
           Hello{1, "a", "b", 0}, Done{'R', 20}, Report{4294967295U, -2147483647, 2147483647, 63},
           Battery{7400}, Complaint{4, "no M for 500 ms"}}) {
    EXPECT_EQ(parse_board_line(encode(line)), line) << encode(line);
  }
  for (const HostLine& line : std::initializer_list<HostLine>{WhoAreYou{}, Motion{-7, 8},
                                                              SetWatchdog{500}, SetReports{20}}) {
    EXPECT_EQ(parse_host_line(encode(line)), line) << encode(line);
  }
}

TEST(TextBaseCodec, WhatDoesNotFitIsNothing) {
  for (const char* text : {"",
                           " ",
                           "T",
                           "T 1 2 3",
                           "T 1 2 3 4 5",
                           "T 1 2 3 x",
                           "T 1  2 3 4",
                           "T -1 2 3 4",
                           "T 4294967296 0 0 0",
                           "T 1 2147483648 0 0",
                           "t 1 2 3 4",
                           "V 1 name firmware",
                           "V 1 name firmware dog=5",
                           "V x name firmware wd=5",
                           "K X 5",
                           "K W",
                           "B",
                           "B 1.5",
                           "E 4",
                           "E x y",
                           "M 1 2"}) {
    EXPECT_FALSE(parse_board_line(text).has_value()) << text;
  }
  for (const char* text :
       {"", "V", "V? ", "M 1", "M 1 2 3", "M 1.0 2", "W", "W x", "R 1 2", "Q 1"}) {
    EXPECT_FALSE(parse_host_line(text).has_value()) << text;
  }
}

TEST(TextBaseCodec, SumsAreCheckedWhereTheyAre) {
  EXPECT_FALSE(without_sum("M 0 0")->had_sum);
  EXPECT_EQ(without_sum("M 0 0*4D")->text, "M 0 0");
  EXPECT_EQ(without_sum("M 0 0*4d")->text, "M 0 0");
  for (const char* text : {"M 0 0*4E", "M 0 1*4D", "M 0 0*4", "M 0 0*4DD", "M 0 0*", "M 0 0*G0"}) {
    EXPECT_FALSE(without_sum(text).has_value()) << text;
  }
}

}  // namespace
}  // namespace marco::drivers::textbase
