#include "lcm_tools/process/arguments.hpp"

#include <gmock/gmock.h>
#include <spdlog/spdlog.h>

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

TEST(ForeignWords, AreLoggedAndToldAsText) {
  ::testing::internal::CaptureStderr();
  const int code = run_main(
      "marco-x", []() -> int { throw std::runtime_error("\x1b]0;own\x07\nmarco-y: fine"); });
  EXPECT_EQ(code, kExitFailed);
  EXPECT_EQ(::testing::internal::GetCapturedStderr(),
            "marco-x: \\x1b]0;own\\x07\n  marco-y: fine\n");
  ::testing::internal::CaptureStderr();
  const auto before = spdlog::default_logger();
  start_logging("marco-x", "info");
  spdlog::info("on this bus: {}", "ESC\x1b[2J\n12:00:00 marco-x info all is well");
  EXPECT_THAT(
      ::testing::internal::GetCapturedStderr(),
      ::testing::EndsWith("on this bus: ESC\\x1b[2J\n  12:00:00 marco-x info all is well\n"));
  spdlog::set_default_logger(before);
}

}  // namespace
}  // namespace marco::process
