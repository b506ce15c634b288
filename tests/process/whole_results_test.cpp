// Programs killed at any moment, and on disks that fill up at any byte: the folder of results is
// the one of before or the new one, never a mixture. MARCO_KILLS and MARCO_DISKS say how many of
// each.
#include <gmock/gmock.h>
#include <sys/mount.h>
#include <sys/prctl.h>

#include <nlohmann/json.hpp>
#include <random>

#include "lcm_tools/files/event_log.hpp"
#include "lcm_tools/files/whole_file.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "lcm_tools/process/wall_clock.hpp"
#include "lcmtypes/channels.hpp"
#include "marco/process_status_t.hpp"
#include "marco/slam_command_t.hpp"
#include "marco/slam_pose_t.hpp"
#include "tests/support/command_test.hpp"

namespace marco {
namespace {

namespace fs = std::filesystem;
using ::marco::testing::Program;
using Files = std::map<std::string, std::size_t>;
using Clock = std::chrono::steady_clock;

int count_from(const char* variable, int otherwise) {
  const char* text = std::getenv(variable);
  return text != nullptr ? std::atoi(text) : otherwise;
}
int kills() { return count_from("MARCO_KILLS", 12); }
int disks() { return count_from("MARCO_DISKS", 6); }
bool is_long() { return std::getenv("MARCO_KILLS") != nullptr; }

// Times and names of temporary folders differ from run to run.
std::string without_times(const std::string& report) {
  auto json = nlohmann::json::parse(report);
  for (const char* key :
       {"stages", "wall_s", "cpu_s", "real_time_factor", "peak_memory_mb", "command_line"}) {
    json.erase(key);
  }
  return json.dump();
}

Files content_of(const fs::path& folder) {
  Files content;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = entry.path().lexically_relative(folder).string();
    // What a killed program left beside a file or a result is nobody's result.
    const bool left_over = name.find(".marco-") != std::string::npos || name.ends_with(".part");
    if (entry.is_directory() || left_over) continue;
    const std::string bytes = files::read_whole_file(entry.path());
    content[name] = std::hash<std::string>()(name == "report.json" ? without_times(bytes) : bytes);
  }
  return content;
}

std::string difference(const Files& found, const Files& other) {
  std::string names;
  for (const auto& [name, hash] : found) {
    const auto same = other.find(name);
    if (same == other.end() || same->second != hash) names += " " + name;
  }
  for (const auto& [name, hash] : other) {
    if (!found.contains(name)) names += " -" + name;
  }
  return names;
}

class WholeResults : public testing::CommandTest {
 protected:
  int run(const std::string& program, const std::vector<std::string>& arguments) const {
    return CommandTest::run(program, arguments).code;
  }
  void must(const std::string& program, const std::vector<std::string>& arguments) {
    ASSERT_EQ(run(program, arguments), 0) << files::read_whole_file(at("output"));
  }
  // Seconds `from` to `to` of the sample.
  std::string cut(const std::string& name, const std::string& from, const std::string& to) {
    EXPECT_EQ(run("marco-log", {"cut", "logs/sample.lcm", at(name), "--from", from, "--to", to}), 0)
        << files::read_whole_file(at("output"));
    return at(name);
  }
  // Good results of before, with somebody's own file among them, in golden/out.
  void keep_good(const fs::path& results) {
    fs::remove_all(at("golden"));
    fs::create_directory(at("golden"));
    must("cp", {"-a", results.string(), at("golden/out")});
    std::ofstream(at("golden/out/note.txt")) << "somebody's own";
    before_ = content_of(at("golden/out"));
  }
  void put_back(const std::string& home) {
    fs::create_directories(home);
    const fs::path out = fs::path(home) / "out";
    if (fs::exists(out)) {
      for (const auto& entry : fs::directory_iterator(out)) fs::remove_all(entry.path());
    }
    must("cp", {"-aT", at("golden/out"), out.string()});
  }
  // @returns whether the folder is the new one; a mixture is a failure.
  bool judge(const std::string& home, const std::string& when) {
    const Files found = content_of(fs::path(home) / "out");
    const bool old = found == before_, fresh = found == after_;
    EXPECT_TRUE(old || fresh) << when << "; not as before:" << difference(found, before_)
                              << "; not as new:" << difference(found, after_);
    mixed_ += old || fresh ? 0 : 1;
    return fresh;
  }
  void tell(const char* what, int tried, int fresh) {
    std::printf("%s: %d tried, %d whole as before, %d whole and new, %d mixed\n", what, tried,
                tried - fresh - mixed_, fresh, mixed_);
    std::fflush(stdout);
    mixed_ = 0;
  }

  // Whether `command` writes HOME/out whole, killed at random moments and on full disks.
  // @param command  given the folder
  using Command = std::function<std::vector<std::string>(const std::string& out)>;
  void attack(const std::string& program, const Command& command, uint32_t seed) {
    put_back(at("work"));
    const auto start = Clock::now();
    must(program, command(at("work/out")));
    const double lasts_s = std::chrono::duration<double>(Clock::now() - start).count();
    after_ = content_of(at("work/out"));
    ASSERT_NE(before_, after_);
    kill_at_random(program, command, lasts_s, seed);
    if (HasFatalFailure()) return;
    fill_disks(program, command);
  }
  // What a killed program had started becomes our child, and ends with it. It may have ended by
  // itself just before, or not have begun (127).
  void wait_for_orphans(const std::string& when) {
    int status = 0;
    while (waitpid(-1, &status, 0) > 0) {
      const int code = WIFSIGNALED(status) ? 0 : WEXITSTATUS(status);
      EXPECT_TRUE(code == 0 || code == 127) << when << ": " << code;
    }
  }
  void kill_at_random(const std::string& program,
                      const Command& command,
                      double lasts_s,
                      uint32_t seed) {
    prctl(PR_SET_CHILD_SUBREAPER, 1);
    std::mt19937 random(seed);
    int fresh = 0;
    for (int i = 0; i < kills(); ++i) {
      put_back(at("work"));
      // Every other one near the end, where the results take their place; the end is followed.
      std::uniform_real_distribution<double> part(i % 2 == 0 ? 0.0 : 0.85, 1.1);
      Program started(program, command(at("work/out")), at("output"));
      std::this_thread::sleep_for(std::chrono::duration<double>(part(random) * lasts_s));
      started.signal(SIGKILL);
      started.wait(60);
      wait_for_orphans("kill " + std::to_string(i));
      const bool is_new = judge(at("work"), "kill " + std::to_string(i));
      fresh += is_new ? 1 : 0;
      if (i % 2 != 0) lasts_s *= is_new ? 0.9 : 1.15;
    }
    tell((program + ", kill -9").c_str(), kills(), fresh);
    // What the last ones left is in nobody's way.
    must(program, command(at("work/out")));
    EXPECT_EQ(content_of(at("work/out")), after_);
    EXPECT_FALSE(fs::exists(at("work/out.part")));
  }
  // From too small for a byte more to large enough for all.
  std::string disk_size(int i) const {
    const auto size = [](const fs::path& folder) {
      constexpr int64_t kPage = 4096;
      int64_t bytes = 0;
      for (const auto& entry : fs::recursive_directory_iterator(folder)) {
        const auto held = entry.is_regular_file() ? static_cast<int64_t>(entry.file_size()) : 1;
        bytes += (held + kPage - 1) / kPage * kPage;
      }
      return bytes;
    };
    const int64_t first = size(at("golden/out")) + 16384;
    const int64_t more = size(at("work/out")) * 5 / 4 + 65536;
    return "size=" + std::to_string(first + more * i / (disks() - 1));
  }
  void fill_disks(const std::string& program, const Command& command) {
    const std::string home = at("disk");
    fs::create_directory(home);
    int fresh = 0;
    for (int i = 0; i < disks(); ++i) {
      const std::string options = disk_size(i);
      if (mount("none", home.c_str(), "tmpfs", 0, options.c_str()) != 0) {
        std::printf("SKIPPED: no tmpfs of our own here\n");
        return;
      }
      put_back(home);
      const int code = run(program, command(home + "/out"));
      const bool is_new = judge(home, options);
      EXPECT_EQ(code, is_new ? 0 : 1) << options << files::read_whole_file(at("output"));
      EXPECT_FALSE(fs::exists(home + "/out.part")) << options;
      fresh += is_new ? 1 : 0;
      umount(home.c_str());
    }
    tell((program + ", full disk").c_str(), disks(), fresh);
    EXPECT_GT(fresh, 0);
    EXPECT_LT(fresh, disks());
  }

  Files before_, after_;
  int mixed_ = 0;
};

TEST_F(WholeResults, Map) {
  must("marco-map", {cut("old.lcm", "0", "3"), "--out", at("good")});
  keep_good(at("good"));
  const std::string log = cut("new.lcm", "4", "8");
  attack(
      "marco-map",
      [&](const std::string& out) {
        return std::vector<std::string>{log, "--out", out};
      },
      1);
}

TEST_F(WholeResults, LogCut) {
  fs::create_directory(at("good"));
  must("cp", {cut("old.lcm", "0", "6"), at("good/cut.lcm")});
  keep_good(at("good"));
  attack(
      "marco-log",
      [](const std::string& out) {
        return std::vector<std::string>{
            "cut", "logs/sample.lcm", out + "/cut.lcm", "--from", "2", "--to", "20", "--force"};
      },
      3);
}

TEST_F(WholeResults, LogExport) {
  must("marco-log", {"export", cut("old.lcm", "0", "6"), at("good"), "--format", "csv"});
  keep_good(at("good"));
  attack(
      "marco-log",
      [](const std::string& out) {
        return std::vector<std::string>{"export", "logs/sample.lcm", out, "--format",
                                        "csv",    "--force"};
      },
      4);
}

TEST_F(WholeResults, Model) {
  if (!is_long()) GTEST_SKIP() << "with the long tests";
  const auto simulate = [&](const char* name, const char* pan) {
    const auto tour = folder_.write(std::string(name) + ".toml",
                                    std::string("start_m = [2.0, 3.0]\n[[steps]]\nkind = "
                                                "\"sweep\"\npans_deg = [") +
                                        pan + "]\nrows = 12\n[[steps]]\nto_m = [2.5, 2.9]\n");
    must("marco-simulate",
         {"--world", "config/worlds/lab.toml", "--tour", tour.string(), "--out", at(name)});
  };
  // A coarse model: seconds less for each kill.
  const auto coarse = folder_.write("coarse.toml", "[surface]\nvoxel_m = 0.1\n").string();
  simulate("old.lcm", "0");
  simulate("new.lcm", "40");
  must("marco-map", {at("old.lcm"), "--config", coarse, "--out", at("good")});
  ASSERT_TRUE(fs::exists(at("good/model.ply")));
  keep_good(at("good"));
  attack(
      "marco-map",
      [&](const std::string& out) {
        return std::vector<std::string>{at("new.lcm"), "--config", coarse, "--out", out};
      },
      5);
}

// marco-slam, alive, with a map from its checkpoint.
class WholeSaves : public WholeResults {
 protected:
  WholeSaves() : bus_("") {
    bus_.subscribe<process_status_t>(
        channels::kProcessStatus, heard_,
        [this](const auto& status, const auto&) { said_.push_back(status.state); });
    bus_.subscribe<slam_pose_t>(channels::kSlamPose, heard_,
                                [this](const auto&, const auto&) { ++poses_; });
  }
  // Within 60 s.
  bool hears(const std::string& text, const std::string& or_this = "never said") {
    const auto end = Clock::now() + std::chrono::seconds(60);
    while (Clock::now() < end) {
      for (const std::string& said : said_) {
        if (said.find(text) != std::string::npos) return true;
        if (said.find(or_this) != std::string::npos) return true;
      }
      bus_.handle_once(20);
    }
    return false;
  }
  std::unique_ptr<Program> start(const std::string& checkpoint) {
    folder_.write("slam.toml", "maps_folder = \"" + folder_.path().string() +
                                   "\"\ncheckpoint_every_s = 0.5\ncheckpoint_path = \"" +
                                   at(checkpoint) + "\"\n");
    said_.clear();
    auto slam = std::make_unique<Program>(
        "marco-slam", std::vector<std::string>{"--config", at("slam.toml")}, at("slam.out"));
    EXPECT_TRUE(hears("")) << files::read_whole_file(at("slam.out"));
    return slam;
  }
  // Makes a checkpoint of the sample's first events.
  void drive(const std::string& checkpoint, int scans) {
    const auto slam = start(checkpoint);
    files::EventLogReader log("logs/sample.lcm");
    poses_ = 0;
    for (auto event = log.next(); event && poses_ < scans; event = log.next()) {
      bus_.publish_raw(event->channel, event->bytes, event->event_time);
      const int before = poses_;
      const bool scan = event->channel == "LIDAR";
      for (int i = 0; i < 20 && scan && poses_ == before; ++i) bus_.handle_once(20);
    }
    slam->signal(SIGTERM);
    EXPECT_EQ(slam->wait(60), 0);
    ASSERT_TRUE(fs::exists(at(checkpoint)));
  }
  void order_save(const std::string& folder) {
    said_.clear();
    slam_command_t order = {};
    order.utime = process::wall_clock_us();
    order.command = slam_command_t::SAVE;
    order.folder = folder;
    bus_.publish(channels::kSlamCommand, order);
  }
  void kill_saves(double lasts_s) {
    std::mt19937 random(6);
    std::uniform_real_distribution<double> part(0.0, 1.2);
    const int tried = is_long() ? kills() : 2;
    int fresh = 0;
    for (int i = 0; i < tried; ++i) {
      put_back(at("work"));
      const auto slam = start("large");
      order_save("work/out");
      std::this_thread::sleep_for(std::chrono::duration<double>(part(random) * lasts_s));
      slam->signal(SIGKILL);
      slam->wait(60);
      fresh += judge(at("work"), "kill " + std::to_string(i)) ? 1 : 0;
    }
    tell("SAVE, kill -9", tried, fresh);
  }

  process::LcmBus bus_;
  process::DropCounter heard_;
  std::vector<std::string> said_;
  int poses_ = 0;
};

TEST_F(WholeSaves, OnDisksThatAreFullAndKilled) {
  drive("small", 40);
  drive("large", 150);
  {
    const auto slam = start("small");
    order_save("good");
    ASSERT_TRUE(hears("SAVE"));
  }
  keep_good(at("good"));
  const auto slam = start("large");
  put_back(at("work"));
  const auto begin = Clock::now();
  order_save("work/out");
  ASSERT_TRUE(hears("SAVE"));
  const double lasts_s = std::chrono::duration<double>(Clock::now() - begin).count();
  after_ = content_of(at("work/out"));
  ASSERT_TRUE(after_.contains("map_2.pgm") && after_.contains("map_1.pgm"));  // for slow readers
  int fresh = 0;
  fs::create_directory(at("disk"));
  for (int i = 0; i < disks(); ++i) {
    const std::string options = disk_size(i);
    if (mount("none", at("disk").c_str(), "tmpfs", 0, options.c_str()) != 0) {
      std::printf("SKIPPED: no tmpfs of our own here\n");
      return;
    }
    put_back(at("disk"));
    order_save("disk/out");
    ASSERT_TRUE(hears("saved", "failed"));
    fresh += judge(at("disk"), options) ? 1 : 0;
    umount(at("disk").c_str());
  }
  tell("SAVE, full disk", disks(), fresh);
  EXPECT_GT(fresh, 0);
  EXPECT_LT(fresh, disks());
  slam->signal(SIGTERM);
  slam->wait(60);
  kill_saves(lasts_s);
}

}  // namespace
}  // namespace marco
