#include "slam/process/slam_answers.hpp"

#include <gtest/gtest.h>

namespace marco::slam {
namespace {

slam_command_t order(int8_t command) {
  slam_command_t order{};
  order.utime = 7;
  order.command = command;
  return order;
}

slam_reply_t reply(const std::string& process, bool ok, const std::string& text) {
  slam_reply_t reply{};
  reply.process = process;
  reply.command_utime = 7;
  reply.ok = ok ? 1 : 0;
  reply.text = text;
  return reply;
}

TEST(SlamAnswers, OfOneSlamIsItsReply) {
  SlamAnswers answers(order(slam_command_t::SAVE));
  EXPECT_TRUE(answers.is_empty());
  EXPECT_FALSE(answers.are_complete());
  slam_reply_t other = reply("marco-slam", true, "of another order");
  other.command_utime = 6;
  answers.take(other);
  EXPECT_TRUE(answers.is_empty());
  slam_reply_t saved = reply("marco-slam", true, "saved");
  saved.path = "/maps/hall";
  answers.take(saved);
  EXPECT_TRUE(answers.are_complete());
  EXPECT_TRUE(answers.are_good());
  EXPECT_EQ(answers.text(), "saved");
  EXPECT_EQ(answers.path(), "/maps/hall");
}

TEST(SlamAnswers, AreThoseOfAllSlamsThatRun) {
  SlamAnswers answers(order(slam_command_t::SAVE));
  answers.expect("marco-slam");
  answers.expect("marco-line-slam");
  answers.take(reply("marco-line-slam", true, "saved"));
  EXPECT_FALSE(answers.is_empty());
  EXPECT_FALSE(answers.are_complete()) << "the slower one may fail yet";
  EXPECT_FALSE(answers.are_good());
  EXPECT_EQ(answers.text(), "marco-line-slam: saved\nmarco-slam: no answer");
  answers.take(reply("marco-slam", false, "failed: the disk is full"));
  EXPECT_TRUE(answers.are_complete());
  EXPECT_FALSE(answers.are_good());
  EXPECT_EQ(answers.text(), "marco-line-slam: saved\nmarco-slam: failed: the disk is full");
}

TEST(SlamAnswers, LineSlamNeedNotRelocalize) {
  for (const int8_t command : {slam_command_t::LOCALIZE, slam_command_t::EXTEND}) {
    SlamAnswers answers(order(command));
    answers.take(reply("marco-line-slam", false, "refused"));
    EXPECT_FALSE(answers.are_good());
    answers.take(reply("marco-slam", true, "relocalizing"));
    EXPECT_TRUE(answers.are_good());
  }
}

TEST(SlamAnswers, OfAFloodAreFew) {
  SlamAnswers answers(order(slam_command_t::PAUSE));
  for (int i = 0; i < 1000; ++i) answers.take(reply("fake" + std::to_string(i), true, "x"));
  EXPECT_LT(answers.text().size(), 300U);
}

}  // namespace
}  // namespace marco::slam
