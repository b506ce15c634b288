#include "lcm_tools/process/config.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace marco::process {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

struct Inner {
  double sigma_m = 0.5;
  template <class Visitor>
  void visit(Visitor& v) {
    v("sigma_m", sigma_m, kPositive);
  }
};

struct Sample {
  int count = 3;
  bool on = true;
  std::string name = "a";
  std::vector<double> schedule{1.0, 2.0};
  Inner inner;
  std::vector<Inner> list;
  template <class Visitor>
  void visit(Visitor& v) {
    v("count", count, Limits{1, 10}, "How many. More for large rooms.");
    v("on", on);
    v.advanced("name", name, "What it is called.");
    v("schedule", schedule, kPositive);
    v("inner", inner);
    v("list", list);
  }
};

Sample read(const std::string& text) {
  Sample options;
  parse_options(text, options, "test.toml");
  return options;
}

std::string refusal(const std::string& text) {
  try {
    read(text);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Config, ReadsEveryKindOfFieldAndKeepsTheOtherDefaults) {
  const Sample options = read(
      "count = 4\non = false\nname = \"b\"\nschedule = [3, 1.5]\n"
      "[inner]\nsigma_m = 2\n[[list]]\nsigma_m = 7\n[[list]]\n");
  EXPECT_EQ(options.count, 4);
  EXPECT_FALSE(options.on);
  EXPECT_EQ(options.name, "b");
  EXPECT_THAT(options.schedule, ::testing::ElementsAre(3.0, 1.5));
  EXPECT_EQ(options.inner.sigma_m, 2.0);
  ASSERT_EQ(options.list.size(), 2U);
  EXPECT_EQ(options.list[0].sigma_m, 7.0);
  EXPECT_EQ(options.list[1].sigma_m, 0.5);
  EXPECT_EQ(read("").count, 3);
}

TEST(Config, RefusesUnknownKeysWrongTypesAndValuesOutsideLimits) {
  EXPECT_THAT(refusal("cuont = 4"),
              HasSubstr("unknown key 'cuont' (line 1, column 9); did you mean 'count'?"));
  EXPECT_THAT(refusal("[inner]\nsigma = 4"), HasSubstr("inner.unknown key 'sigma'"));
  EXPECT_THAT(refusal("count = 4.5"),
              HasSubstr("count (line 1, column 9): expected a whole number"));
  EXPECT_THAT(refusal("count = 11"), HasSubstr("within [1, 10], got 11"));
  EXPECT_THAT(refusal("[inner]\nsigma_m = -1"), HasSubstr("inner.sigma_m"));
  EXPECT_THAT(refusal("name = 3"), HasSubstr("a string in quotes"));
  EXPECT_THAT(refusal("schedule = [0]"), HasSubstr("schedule"));
}

struct Writes {
  std::string journal_path;
  template <class Visitor>
  void visit(Visitor& v) {
    v("journal_path", journal_path);
  }
};

TEST(Config, SaysWhenAFileLiesOutsideTheWorkingFolder) {
  const auto said = [](const std::string& path) {
    Writes options;
    ::testing::internal::CaptureStdout();
    parse_options("journal_path = '" + path + "'", options, "stranger.toml");
    return ::testing::internal::GetCapturedStdout();
  };
  for (const char* path : {"/home/me/.profile", "../above", "a/../../above"}) {
    EXPECT_THAT(said(path), HasSubstr("stranger.toml: journal_path")) << path;
  }
  EXPECT_EQ(said("out/journal.json") + said("a/../b") + said(""), "");
}

TEST(Config, PrintedOptionsAreReadBackTheSame) {
  Sample options = read("count = 9\n[[list]]\nsigma_m = 7\n");
  const Sample again = read(print_options(options));
  EXPECT_EQ(again.count, 9);
  EXPECT_EQ(again.list.at(0).sigma_m, 7.0);
}

TEST(Config, WhatIsPrintedSaysWhatEachSettingIs) {
  Sample options;
  options.name = "a \"b\"";
  options.schedule = {0.1, 1e-7, 3.0};
  options.list.resize(1);
  EXPECT_EQ(print_options(options),
            "# How many. More for large rooms. [1 to 10]\n"
            "count = 3\n"
            "on = true\n"
            "# What it is called.\n"
            "name = 'a \"b\"'\n"
            "schedule = [0.1, 1e-07, 3.0]\n"
            "\n[inner]\nsigma_m = 0.5\n"
            "\n[[list]]\nsigma_m = 0.5\n");
  EXPECT_EQ(read(print_options(options)).name, options.name);
}

TEST(Config, AdvancedSettingsAreShownWhenAskedForOrChanged) {
  Sample options;
  EXPECT_THAT(print_options(options, Printed::all), HasSubstr("name = 'a'"));
  EXPECT_THAT(print_options(options, Printed::common), Not(HasSubstr("name")));
  options.name = "b";
  EXPECT_THAT(print_options(options, Printed::common), HasSubstr("name = 'b'"));
}

TEST(Config, ChangedSettingsAreThoseThatDifferFromTheirDefault) {
  Sample options;
  EXPECT_EQ(print_options(options, Printed::changed), "");
  options.count = 4;
  options.inner.sigma_m = 2.0;
  EXPECT_EQ(print_options(options, Printed::changed), "count = 4\n\n[inner]\nsigma_m = 2.0\n");
}

TEST(Config, ValidateNamesTheOptionByItsPath) {
  Sample options;
  EXPECT_NO_THROW(validate(options, "sample"));
  options.inner.sigma_m = 0.0;
  EXPECT_THROW(validate(options, "sample"), std::invalid_argument);
  options.inner.sigma_m = std::nan("");
  EXPECT_THROW(validate(options, "sample"), std::invalid_argument);
}

std::string repeated(const std::string& text, int times) {
  std::string all;
  for (int i = 0; i < times; ++i) all += text;
  return all;
}

std::string refusal_of(const std::string& toml) {
  Sample options;
  try {
    parse_options(toml, options, "a.toml");
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

// Its parser makes a table of each dot, and destroys them by recursion.
TEST(Config, RefusesWhatIsNestedDeeperThanAnySetting) {
  const std::string dots = repeated("a.", 50'000) + "b";
  const std::string quoted = repeated("\"a\" . ", 50'000) + "b";
  for (const std::string& toml : {
           dots + " = 1",
           quoted + " = 1",
           "[" + dots + "]",
           "[[" + dots + "]]",
           "a = { " + dots + " = 1 }",
           "a = " + repeated("[", 50'000),
           "a = " + repeated("{b=", 50'000),
           // What looks like the end of a string or its beginning, and is none.
           "a = \"\"\"b\"\"\"\"\n" + dots + " = \"\"",
           "a = '''b'''''\n" + dots + " = ''",
           "a = '\\'\n" + dots + " = ''",
           "a = \"\\\\\"\n" + dots + " = \"\"",
           "# \"\n" + dots + " = \"\"",
       }) {
    EXPECT_THAT(refusal_of(toml), HasSubstr("nested deeper than 32")) << toml.substr(0, 30);
  }
  EXPECT_THAT(refusal_of("count = 4\n\n" + dots + " = 1"), HasSubstr("a.toml:3: "));
}

TEST(Config, TakesWhatOnlyLooksDeep) {
  const std::string dots = repeated("a.", 100);
  EXPECT_EQ(refusal_of("name = \"" + dots + "\" # " + dots), "");
  EXPECT_EQ(refusal_of("name = \"\"\"\n" + dots + repeated("[", 100) + "\"\"\"\""), "");
  EXPECT_EQ(refusal_of("name = '" + repeated("{", 100) + "'\n# " + repeated("[", 100)), "");
  EXPECT_EQ(refusal_of("schedule = [" + repeated("1.5, ", 100) + "]"), "");
  EXPECT_EQ(refusal_of(repeated("[[list]]\nsigma_m = 0.5\n", 100)), "");
}

}  // namespace
}  // namespace marco::process
