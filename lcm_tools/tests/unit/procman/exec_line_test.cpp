#include "lcm_tools/procman/exec_line.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

namespace marco::procman {
namespace {

using testing::ElementsAre;
using testing::Pair;

ExecLine parse(const std::string& exec) {
  return parse_exec_line(exec, [](const std::string& name) -> std::optional<std::string> {
    if (name == "HOME") return "/home/robot";
    if (name == "EMPTY") return "";
    return std::nullopt;
  });
}

TEST(ExecLine, SplitsAtWhiteSpaceAndJoinsAdjacentPieces) {
  EXPECT_THAT(split_words("  a 'b c'\"d e\"f \t g\\ h "), ElementsAre("a", "b cd ef", "g h"));
}

TEST(ExecLine, AQuoteOfTheOtherKindIsACharacter) {
  EXPECT_THAT(split_words("\"it's\" '\"'"), ElementsAre("it's", "\""));
}

TEST(ExecLine, ABackslashTakesTheNextCharacterAlsoWithinQuotes) {
  EXPECT_THAT(split_words(R"('x\\377' "\"" \')"), ElementsAre("x\\377", "\"", "'"));
}

// The public procman loses both.
TEST(ExecLine, OneCharacterAndEmptyWordsSurvive) {
  EXPECT_THAT(split_words("echo a"), ElementsAre("echo", "a"));
  EXPECT_THAT(split_words("echo ''"), ElementsAre("echo", ""));
}

TEST(ExecLine, LeadingAssignmentsAreNotExpandedAndStopAtTheProgram) {
  const ExecLine line = parse("A=1 B=$HOME C= prog D=2");
  EXPECT_THAT(line.assignments, ElementsAre(Pair("A", "1"), Pair("B", "$HOME"), Pair("C", "")));
  EXPECT_THAT(line.arguments, ElementsAre("prog", "D=2"));
}

TEST(ExecLine, VariablesAreReplacedAndUnknownOnesStay) {
  EXPECT_THAT(parse("sh '$HOME' ${HOME}x $EMPTY. $$ $1 ${UNSET} ${HOME $UNSET $").arguments,
              ElementsAre("sh", "/home/robot", "/home/robotx", ".", "$$", "$1", "${UNSET}",
                          "${HOME", "$UNSET", "$"));
}

TEST(ExecLine, AssignmentsHaveNames) {
  EXPECT_TRUE(is_only_assignments("A=1 _b2='x y'"));
  EXPECT_TRUE(is_only_assignments(""));
  EXPECT_FALSE(is_only_assignments("A=1 prog"));
  EXPECT_FALSE(is_only_assignments("2A=1"));
  EXPECT_FALSE(is_only_assignments("=1"));
}

TEST(ExecLine, AnyWordComesBackFromItsQuotes) {
  std::mt19937 random(7);
  const std::string alphabet = "ab \\\"'$\t\n=";
  for (int round = 0; round < 500; ++round) {
    std::string word;
    for (unsigned length = random() % 8; length > 0; --length) {
      word += alphabet[random() % alphabet.size()];
    }
    EXPECT_THAT(split_words(quote_word(word)), ElementsAre(word));
  }
}

}  // namespace
}  // namespace marco::procman
