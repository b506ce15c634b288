#include "lcm_tools/process/suggest.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace marco::process {
namespace {

using ::testing::Optional;

const std::vector<std::string> kNames = {"--out", "--config", "--hold-out", "--world", "--extend"};

TEST(ClosestName, AnErrorOfEachKindIsForgiven) {
  EXPECT_THAT(closest_name("--ot", kNames), Optional(std::string("--out")));
  EXPECT_THAT(closest_name("--outt", kNames), Optional(std::string("--out")));
  EXPECT_THAT(closest_name("--oot", kNames), Optional(std::string("--out")));
  EXPECT_THAT(closest_name("--confgi", kNames), Optional(std::string("--config")));
  EXPECT_THAT(closest_name("--World", kNames), Optional(std::string("--world")));
}

TEST(ClosestName, TheNearestOfSeveralIsTaken) {
  EXPECT_THAT(closest_name("mab", {"tab", "map", "maps"}), Optional(std::string("tab")));
  EXPECT_THAT(closest_name("maps2", {"tab", "map", "maps"}), Optional(std::string("maps")));
}

TEST(ClosestName, ABeginningIsEnoughWhereItSaysWhich) {
  EXPECT_THAT(closest_name("evalu", {"evaluate", "render"}), Optional(std::string("evaluate")));
  EXPECT_EQ(closest_name("evalu", {"evaluate", "evaluate-model"}), std::nullopt);
  EXPECT_EQ(closest_name("ev", {"evaluate", "render"}), std::nullopt);
}

TEST(ClosestName, WhatIsFarOrRightGetsNoWord) {
  EXPECT_EQ(closest_name("--speed", kNames), std::nullopt);
  EXPECT_EQ(closest_name("--out", kNames), std::nullopt);
  EXPECT_EQ(closest_name("", kNames), std::nullopt);
  EXPECT_EQ(closest_name("x", {"y"}), std::nullopt);
  EXPECT_EQ(closest_name(std::string(100000, 'a'), kNames), std::nullopt);
  EXPECT_EQ(closest_name("map", {}), std::nullopt);
}

TEST(DidYouMean, EndsAMessage) {
  EXPECT_EQ(did_you_mean("--ot", kNames), "; did you mean '--out'?");
  EXPECT_EQ(did_you_mean("--speed", kNames), "");
}

}  // namespace
}  // namespace marco::process
