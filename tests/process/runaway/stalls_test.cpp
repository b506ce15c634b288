// A whole robot under procman on a quarter of a core, whose driver, or all of it, stands still now
// and then: each stall of more than half a second is a stop, and nothing else happens. Two minutes,
// or MARCO_STALLS_S.
#include <gmock/gmock.h>

#include <random>
#include <sstream>

#include "tests/process/runaway/driven_robot.hpp"

namespace marco {
namespace {

using testing::DrivenRobot;

/// A quarter of a core (cgroup v1 or v2), or all, where the system makes no cgroup.
class QuarterCore {
 public:
  QuarterCore() {
    const std::string name = "/marco-stalls-" + std::to_string(getpid());
    for (const std::string folder : {"/sys/fs/cgroup/cpu", "/sys/fs/cgroup"}) {
      path_ = folder + name;
      if (mkdir(path_.c_str(), 0700) != 0) continue;
      const bool v1 =
          static_cast<bool>(std::ofstream(path_ + "/cpu.cfs_quota_us") << 25'000 << std::flush);
      const bool v2 =
          static_cast<bool>(std::ofstream(path_ + "/cpu.max") << "25000 100000" << std::flush);
      if (v1 || v2) return;
      rmdir(path_.c_str());
    }
    path_.clear();
  }
  ~QuarterCore() {
    if (!path_.empty()) rmdir(path_.c_str());
  }
  /// Of a shell's line: enters it.
  std::string join() const {
    return path_.empty() ? "" : "echo $$ > " + path_ + "/cgroup.procs && ";
  }

 private:
  std::string path_;
};

/// The numbers behind each occurrence of the words; 0 where there is none.
std::vector<double> numbers_behind(const std::string& words, const std::string& text) {
  std::vector<double> numbers;
  for (std::size_t at = 0; (at = text.find(words, at)) != text.npos;) {
    at += words.size();
    numbers.push_back(std::atof(text.c_str() + at));
  }
  return numbers;
}

TEST(Stalls, EachLongOneIsAStopAndNothingElse) {
  const char* asked = std::getenv("MARCO_STALLS_S");
  const double whole_s = asked != nullptr ? std::atof(asked) : 120.0;
  DrivenRobot robot(DrivenRobot::kCreate);
  const QuarterCore quarter;
  std::ofstream(robot.file("create.procman"))
      << "cmd \"base\" { exec = \"" << robot.driver_line()
      << "\"; deputy = \"localhost\"; auto_respawn = \"true\"; }\n"
      << "script \"go\" { start cmd \"base\"; }\n";
  const char* bin = std::getenv("MARCO_BIN");
  const std::string line = quarter.join() + "exec " + std::string(bin != nullptr ? bin : ".") +
                           "/marco-procman-sheriff -n -l --output " + robot.file("create.procman") +
                           " go";
  const auto sheriff = robot.start("sh", {"-c", line});
  const auto up = [&] { return robot.status && robot.status->link == BaseStatus::Link::up; };
  ASSERT_TRUE(robot.wait(up)) << robot.log("sh");
  const pid_t driver = robot.driver(), guardian = robot.guardian(driver);
  ASSERT_GT(guardian, 0);
  const std::vector<pid_t> all{sheriff->pid(), testing::parent_of(testing::parent_of(driver)),
                               testing::parent_of(driver), driver, guardian};
  std::mt19937 random(20261128);
  std::uniform_real_distribution<double> stall_s(0.2, 2.0), work_s(0.8, 2.5);
  const char* seed = std::getenv("MARCO_STALLS_SEED");
  if (seed != nullptr) random.seed(static_cast<unsigned>(std::atoi(seed)));
  std::size_t stalls = 0, long_ones = 0;
  for (double t = 0.0; t < whole_s; ++stalls) {
    const double works_s = work_s(random), stands_s = stall_s(random);
    t += works_s + stands_s;
    robot.drive(works_s);
    const std::vector<pid_t> standing = random() % 2 == 0 ? all : std::vector<pid_t>{driver};
    for (const pid_t pid : standing) kill(pid, SIGSTOP);
    robot.drive(stands_s);
    EXPECT_FALSE(standing.size() == 1 && stands_s > 1.5 && robot.turns()) << stands_s;
    for (const pid_t pid : standing) kill(pid, SIGCONT);
    long_ones += stands_s > 0.5 ? 1 : 0;
  }
  robot.drive(2.0);
  EXPECT_TRUE(robot.turns());
  const std::string log = robot.log("sh");
  const std::vector<double> hangs_s = numbers_behind("this driver hung for ", log);
  std::printf("%zu stalls, %zu of more than 0.5 s: %zu stops\n", stalls, long_ones, hangs_s.size());
  EXPECT_GE(hangs_s.size(), long_ones);
  // A busy machine adds some of its own.
  EXPECT_THAT(hangs_s, ::testing::Each(::testing::Ge(0.5)));
  EXPECT_EQ(robot.driver(), driver);
  EXPECT_EQ(robot.guardian(driver), guardian);
  EXPECT_THAT(numbers_behind("heartbeat was silent", log), ::testing::IsEmpty());
  EXPECT_EQ(numbers_behind("is open", log).size(), 1U);
  sheriff->signal(SIGTERM);
  EXPECT_EQ(sheriff->wait(DrivenRobot::kPatienceS), 0);
}

}  // namespace
}  // namespace marco
