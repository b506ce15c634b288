// Devices that fail under a real driver process: it says so on PROCESS_STATUS, and scans come back.
#include <gtest/gtest.h>

#include <filesystem>
#include <map>

#include "lcm_tools/process/lcm_bus.hpp"
#include "lcm_tools/tests/support/program.hpp"
#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "lcmtypes/channels.hpp"
#include "lcmtypes/convert.hpp"
#include "marco/process_status_t.hpp"
#include "marco/sim_fault_t.hpp"

namespace marco {
namespace {

using std::chrono::steady_clock;
using testing::Program;
using testing::TemporaryFolder;

class Faults : public ::testing::Test {
 protected:
  Faults() {
    bus_.subscribe_raw(".*", [this](const process::RawMessage& raw) {
      ++counts_[std::string(raw.channel)];
      if (raw.channel != channels::kProcessStatus) return;
      process_status_t status;
      if (status.decode(raw.bytes.data(), 0, static_cast<int>(raw.bytes.size())) <= 0) return;
      states_[status.process] = status.state;
      int64_t drops = 0;
      for (const int64_t count : status.drop_counts) drops += count;
      drops_[status.process] = drops;
    });
  }
  bool wait(double seconds, const std::function<bool()>& done) {
    const auto end = steady_clock::now() + std::chrono::duration<double>(seconds);
    while (steady_clock::now() < end && !done()) bus_.handle_once(20);
    return done();
  }
  void order(const std::string& kind, double seconds) {
    sim_fault_t fault{};
    fault.device = "laser";
    fault.kind = kind;
    fault.duration_s = seconds;
    bus_.publish(channels::kSimFault, fault);
  }
  bool says(const std::string& process, const std::string& word) {
    return states_[process].find(word) != std::string::npos;
  }

  process::LcmBus bus_{""};
  std::map<std::string, int> counts_;
  std::map<std::string, std::string> states_;
  std::map<std::string, int64_t> drops_;
};

TEST_F(Faults, TheDriverSaysSoAndScansComeBack) {
  const TemporaryFolder folder;
  const auto file = [&folder](const char* name) { return (folder.path() / name).string(); };
  Program simulator("marco-sim",
                    {"--config", "config/robots/michoacan.toml", "--world",
                     "config/worlds/lab.toml", "--start", "2", "3", "0", "--ports", file("ports")},
                    file("sim.log"));
  ASSERT_TRUE(wait(10.0, [&] { return counts_[channels::kTruePose] > 0; }));
  Program sick("marco-sick",
               {"--config", "config/robots/michoacan/sick.toml", "--device", file("ports/laser")},
               file("sick.log"));
  ASSERT_TRUE(wait(15.0, [&] { return counts_[channels::kLidar] > 5; }));

  struct Case {
    const char* kind;
    std::function<bool()> told;  // by the driver
    double lasts_s;
  };
  int64_t drops_before = 0, garbage_before = 0;
  const auto garbage = [&] {
    const std::size_t at = states_["marco-sick"].find("garbage bytes ");
    return at == std::string::npos ? 0L : std::atol(states_["marco-sick"].c_str() + at + 14);
  };
  const Case cases[] = {
      {"garbage", [&] { return drops_["marco-sick"] > drops_before; }, 2.5},
      {"stuck", [&] { return says("marco-sick", "stuck"); }, 3.0},
      {"off", [&] { return says("marco-sick", "the scans stopped"); }, 2.5},
      {"unplugged", [&] { return says("marco-sick", "no device"); }, 3.0},
      {"intermittent",
       [&] {
         return drops_["marco-sick"] > drops_before || !says("marco-sick", "measuring") ||
                garbage() > garbage_before;
       },
       3.0},
  };
  for (const Case& one : cases) {
    drops_before = drops_["marco-sick"];
    garbage_before = garbage();
    order(one.kind, one.lasts_s);
    EXPECT_TRUE(wait(one.lasts_s + 3.0, [&] { return one.told(); }))
        << one.kind << ": " << states_["marco-sick"];
    EXPECT_TRUE(wait(4.0, [&] { return says("marco-sim", "faults: laser"); })) << one.kind;
    ASSERT_TRUE(wait(one.lasts_s + 5.0, [&] { return says("marco-sim", "running"); })) << one.kind;
    // A second of scans, so that what the driver says is of now.
    const int back = counts_[channels::kLidar] + 40;
    ASSERT_TRUE(wait(60.0,  // the driver looks at four speeds in turn
                     [&] {
                       return counts_[channels::kLidar] > back && says("marco-sick", "measuring") &&
                              !says("marco-sick", "stuck");
                     }))
        << one.kind << ": " << states_["marco-sick"];
  }
  // What no driver can tell from its device alone, the simulator tells.
  order("wrong", 1.5);
  EXPECT_TRUE(wait(3.0, [&] { return says("marco-sim", "laser wrong"); }));
  sim_fault_t nonsense{};
  nonsense.device = "toaster";
  nonsense.kind = "off";
  bus_.publish(channels::kSimFault, nonsense);
  EXPECT_TRUE(wait(3.0, [&] { return drops_["marco-sim"] == 1; }));
}

TEST_F(Faults, AScriptTellsThem) {
  const TemporaryFolder folder;
  const std::string script = (folder.path() / "faults.toml").string();
  std::ofstream(script) << "[[faults]]\ndevice = \"base\"\nkind = \"off\"\nstart_s = 0.5\n"
                           "duration_s = 1000\n";
  Program simulator(
      "marco-sim",
      {"--config", "config/robots/michoacan.toml", "--world", "config/worlds/lab.toml", "--start",
       "2", "3", "0", "--fault-script", script, "--ports", (folder.path() / "ports").string()},
      (folder.path() / "sim.log").string());
  ASSERT_TRUE(wait(10.0, [&] { return says("marco-sim", "faults: base off"); }))
      << states_["marco-sim"];
  Program base("marco-base",
               {"--config", "config/robots/michoacan/base.toml", "--device",
                (folder.path() / "ports/base").string()},
               (folder.path() / "base.log").string());
  ASSERT_TRUE(wait(10.0, [&] { return !states_["marco-base"].empty(); }));
  wait(2.0, [] { return false; });
  EXPECT_EQ(counts_[channels::kOdometry], 0);
  EXPECT_FALSE(says("marco-base", "up")) << states_["marco-base"];
}

}  // namespace
}  // namespace marco
