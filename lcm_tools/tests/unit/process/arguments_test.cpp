#include "lcm_tools/process/arguments.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

#include "lcm_tools/process/exit_code.hpp"

namespace marco::process {
namespace {

TEST(RunMain, ExitCodesFollowTheTable) {
  ::testing::internal::CaptureStderr();
  EXPECT_EQ(run_main("p", [] { return kExitDone; }), 0);
  EXPECT_EQ(run_main("p", []() -> int { throw std::runtime_error("no device"); }), 1);
  EXPECT_EQ(run_main("p", []() -> int { throw UsageError("give a log"); }), 2);
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "p: no device\np: give a log\n");
}

}  // namespace
}  // namespace marco::process
