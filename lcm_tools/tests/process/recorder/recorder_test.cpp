#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/mount.h>

#include <csignal>
#include <fstream>
#include <functional>
#include <random>
#include <thread>

#include "lcm_tools/files/event_log.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "lcm_tools/recorder/recordings.hpp"
#include "lcm_tools/tests/support/log_command.hpp"
#include "lcm_tools/tests/support/program.hpp"
#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "marco/process_status_t.hpp"

// marco-recorder and lcm-logger, as procman runs them.
namespace marco::recorder {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using testing::Program;
using Clock = std::chrono::steady_clock;

class RecorderProcess : public ::testing::Test {
 protected:
  RecorderProcess() {
    bus_.subscribe<process_status_t>(
        "PROCESS_STATUS", drops_,
        [this](const process_status_t& status, const auto&) { state_ = status.state; });
  }

  std::unique_ptr<Program> start() const {
    return std::make_unique<Program>("marco-recorder", std::vector{home_.string()}, output_);
  }
  std::string said() const { return files::read_whole_file(output_); }
  std::vector<Recording> all() const { return recordings_in(home_); }
  std::vector<fs::path> pieces() const { return pieces_of(all().back().folder); }

  /// Publishes 6 MB/s until `what` holds. @returns whether it did, within 20 s
  bool until(const std::function<bool()>& what) {
    const std::vector<uint8_t> bytes(60'000, 7);
    for (const auto end = Clock::now() + std::chrono::seconds(20); Clock::now() < end;) {
      bus_.publish_raw("NUMBERS", bytes, {});
      while (bus_.handle_once(0)) {
      }
      if (what()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return false;
  }
  bool until_recording(int64_t bytes = 100'000) {
    const std::size_t before = all().size();
    return until([&] { return all().size() > before && all().back().bytes > bytes; });
  }

  testing::TemporaryFolder folder_;
  fs::path home_ = folder_.path() / "recordings";
  std::string output_ = folder_.path() / "output.log";
  process::LcmBus bus_{""};
  process::DropCounter drops_;
  std::string state_;
};

TEST_F(RecorderProcess, ManyShortRecordingsAreAllThere) {
  constexpr int kStarts = 25;
  std::string first;
  for (int i = 0; i < kStarts; ++i) {
    auto recorder = start();
    ASSERT_TRUE(until_recording(1)) << said();
    recorder->signal(SIGINT);
    ASSERT_EQ(recorder->wait(5.0), 0) << said();
    if (i == 0) first = files::read_whole_file(pieces().front());
  }
  EXPECT_EQ(all().size(), kStarts);
  EXPECT_EQ(files::read_whole_file(pieces_of(all().front().folder).front()), first);
  const std::string shown = testing::run_log("recordings " + home_.string()).output;
  EXPECT_THAT(shown, HasSubstr(all().front().folder.filename().string()));
  EXPECT_THAT(shown, HasSubstr("25 recordings"));
}

TEST_F(RecorderProcess, ReportsSizeRateAndRoom) {
  auto recorder = start();
  ASSERT_TRUE(until([this] { return state_.find("room for") != std::string::npos; })) << state_;
  EXPECT_THAT(state_,
              ::testing::ContainsRegex("^recording 2.*: .* MB, [1-9].*MB/min, .* free, room for"));
}

TEST_F(RecorderProcess, NothingIsLostWhenItOrTheLoggerIsKilled) {
  std::mt19937 random(5);
  for (int i = 0; i < 5; ++i) {
    auto recorder = start();
    ASSERT_TRUE(until_recording(std::uniform_int_distribution<int64_t>(1, 2'000'000)(random)));
    recorder->signal(SIGKILL);
    recorder->wait(5.0);
    EXPECT_TRUE(until([this] { return !all().back().running; })) << "lcm-logger lives on";
    files::EventLogReader reader(pieces().back());
    while (reader.next_head()) {
    }
    EXPECT_EQ(reader.damage().bytes_skipped, 0);
  }
  EXPECT_EQ(all().size(), 5U) << "a cut recording was continued";

  auto recorder = start();
  ASSERT_TRUE(until_recording());
  const auto logger = testing::run("pgrep -P " + std::to_string(recorder->pid()));
  kill(std::stoi(logger.output), SIGKILL);
  EXPECT_TRUE(
      until([this] { return pieces().size() == 2 && fs::file_size(pieces()[1]) > 100'000; }));
  EXPECT_THAT(said(), HasSubstr("lcm-logger ended with Killed: starting a new piece"));
}

TEST_F(RecorderProcess, AFullDiskTakesTheOldestThenWaits) {
  fs::create_directories(home_);
  if (mount("tmpfs", home_.c_str(), "tmpfs", 0, "size=100m") != 0)
    GTEST_SKIP() << "SKIPPED: no mount";
  const auto old_one = [this](int64_t bytes) {
    const RunningRecording old(home_, std::time(nullptr));
    std::ofstream(old.folder() / "live.lcm.00")
        << std::string(static_cast<std::size_t>(bytes), 'x');
    return old.folder();
  };
  const fs::path kept = old_one(4'000'000), oldest = old_one(8'000'000);
  EXPECT_EQ(testing::run_log("keep " + kept.string()).exit_code, 0);
  std::ofstream(home_ / "of others") << std::string(76'000'000, 'x');

  auto recorder = start();
  EXPECT_TRUE(until([&] { return !fs::exists(oldest); })) << said();
  EXPECT_THAT(said(), HasSubstr("deleted the oldest recording, " + oldest.string()));
  EXPECT_TRUE(until([this] { return state_.starts_with("waiting for room"); })) << state_;
  EXPECT_THAT(said(), HasSubstr("no recording may be deleted"));
  EXPECT_TRUE(fs::exists(kept));
  EXPECT_GT(fs::space(home_).available, 0U);
  const auto first = pieces();
  files::EventLogReader reader(first.back());
  while (reader.next_head()) {
  }
  EXPECT_EQ(reader.damage().bytes_skipped, 0);

  fs::remove(home_ / "of others");
  EXPECT_TRUE(until([&] { return pieces().size() > first.size(); })) << said();
  EXPECT_TRUE(until([this] { return state_.starts_with("recording"); })) << state_;
  recorder->signal(SIGTERM);
  EXPECT_EQ(recorder->wait(5.0), 0);
  recorder.reset();
  umount2(home_.c_str(), MNT_DETACH);
}

}  // namespace
}  // namespace marco::recorder
