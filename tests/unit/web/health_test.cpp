#include "web/health.hpp"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

namespace marco::web {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using Json = nlohmann::json;

constexpr int64_t kSecond = 1'000'000;

Json told(const Health& health, int64_t now_us, const Surroundings& around = {}) {
  return Json::parse(health.json(around, 42, now_us));
}

TEST(HealthOfPrograms, IsWhatTheySayAndHowLongAgo) {
  Health health;
  health.take_status("marco-slam", "matched", 0, 10 * kSecond);
  health.take_status("marco-sick", "no device: /dev/ttyUSB0", 0, 10 * kSecond);
  health.take_status("marco-mapping3d", "waiting for scans; 0 scenes", 0, 10 * kSecond);
  const Json now = told(health, 11 * kSecond);
  EXPECT_EQ(now["utime"], 42);
  ASSERT_THAT(now["programs"], SizeIs(3));
  EXPECT_EQ(now["programs"][0]["state"], "warning");
  EXPECT_EQ(now["programs"][1]["state"], "error");
  EXPECT_EQ(now["programs"][2]["state"], "ok");
  EXPECT_EQ(now["programs"][2]["age_s"], 1.0);
  ASSERT_THAT(now["findings"], SizeIs(1));
  EXPECT_EQ(now["findings"][0]["severity"], "error");
  EXPECT_THAT(now["findings"][0]["text"].get<std::string>(), HasSubstr("/dev/ttyUSB0"));
  const Json later = told(health, 16 * kSecond);
  EXPECT_EQ(later["programs"][2]["state"], "silent");
  EXPECT_THAT(later["findings"], SizeIs(3));
  health.take_status("marco-slam", "matched", 0, 700 * kSecond);
  EXPECT_THAT(told(health, 700 * kSecond)["programs"], SizeIs(1));  // others ended long ago
}

TEST(HealthOfPrograms, ThatAnnouncedLongWorkMayBeSilentForAMinute) {
  Health health;
  health.take_status("marco-mapping3d", "busy: joining 9 scenes", 0, 10 * kSecond);
  EXPECT_THAT(told(health, 69 * kSecond)["findings"], SizeIs(0));
  EXPECT_EQ(told(health, 69 * kSecond)["programs"][0]["state"], "ok");
  EXPECT_THAT(told(health, 71 * kSecond)["findings"], SizeIs(1));
}

TEST(HealthOfPrograms, WarnsWhileTheyDrop) {
  Health health;
  health.take_status("marco-slam", "matched", 100, 10 * kSecond);  // before the page began
  EXPECT_EQ(told(health, 10 * kSecond)["programs"][0]["state"], "ok");
  health.take_status("marco-slam", "matched", 101, 11 * kSecond);
  EXPECT_EQ(told(health, 11 * kSecond)["programs"][0]["state"], "warning");
  health.take_status("marco-slam", "matched", 101, 22 * kSecond);
  EXPECT_EQ(told(health, 22 * kSecond)["programs"][0]["state"], "ok");
}

TEST(HealthOfPrograms, HoldsTextsAsTexts) {
  Health health;
  health.take_status("<script>alert(\"1\")</script>", "\xff\n", 0, kSecond);
  const Json now = told(health, kSecond);
  EXPECT_EQ(now["programs"][0]["name"], "<script>alert(\"1\")</script>");
}

TEST(HealthOfPrograms, OneThatProcmanStoppedIsNotMissed) {
  Health health;
  health.take_status("marco-tour", "driving", 0, kSecond);
  EXPECT_EQ(told(health, 20 * kSecond)["findings"].size(), 1U);
  health.forget("marco-tour");
  EXPECT_THAT(told(health, 20 * kSecond)["findings"], IsEmpty());
  EXPECT_THAT(told(health, 20 * kSecond)["programs"], IsEmpty());
}

TEST(HealthOfPrograms, IsBounded) {
  Health health;
  for (int i = 0; i < 5000; ++i) health.take_status(std::to_string(i), "", 0, kSecond);
  EXPECT_THAT(told(health, kSecond)["programs"], SizeIs(200));
}

TEST(HealthOfTheBase, IsItsBatteriesAndItsLink) {
  Health health;
  health.take_base("hcs12", true, {12.5, 25.0}, "", kSecond);
  EXPECT_EQ(told(health, kSecond)["battery_v"], (Json{12.5, 25.0}));
  EXPECT_THAT(told(health, kSecond)["findings"], IsEmpty());
  EXPECT_THAT(told(health, 10 * kSecond)["battery_v"], IsEmpty());
  health.take_base("hcs12", false, {}, "no port", 20 * kSecond);
  EXPECT_THAT(told(health, 20 * kSecond)["findings"][0]["text"].get<std::string>(),
              HasSubstr("no port"));
}

TEST(HealthOfSlam, HasTheWorstLatencyOfASecond) {
  Health health;
  EXPECT_TRUE(told(health, kSecond)["latency_ms"].is_null());
  health.take_pose_age(0.02, 10 * kSecond);
  health.take_pose_age(0.05, 10 * kSecond + 1000);
  health.take_pose_age(0.01, 10 * kSecond + 2000);
  EXPECT_EQ(told(health, 10 * kSecond)["latency_ms"], 50.0);
  health.take_pose_age(0.01, 12 * kSecond);
  EXPECT_EQ(told(health, 12 * kSecond)["latency_ms"], 10.0);
  health.take_pose_age(1e6, 12 * kSecond);  // another clock
  EXPECT_EQ(told(health, 12 * kSecond)["latency_ms"], 10.0);
  EXPECT_TRUE(told(health, 60 * kSecond)["latency_ms"].is_null());
}

TEST(HealthOfAll, PutsErrorsFirst) {
  Surroundings around;
  around.findings = {{false, "w", "r"}, {true, "e", "r"}};
  around.channels = {{"LIDAR", "bot_core.planar_lidar_t", 37.5123, 2, 0.0251}};
  around.clients = 3;
  around.refused = 4;
  around.dropped = 5;
  const Json now = told(Health(), 0, around);
  EXPECT_EQ(now["findings"][0]["text"], "e");
  EXPECT_EQ(now["channels"][0]["hz"], 37.51);
  EXPECT_EQ(now["channels"][0]["lost"], 2);
  EXPECT_EQ(now["clients"], 3);
  EXPECT_EQ(now["refused"], 4);
  EXPECT_EQ(now["dropped"], 5);
}

}  // namespace
}  // namespace marco::web
