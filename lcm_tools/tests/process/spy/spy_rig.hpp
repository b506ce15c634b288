#pragma once

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sched.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <lcm/lcm-cpp.hpp>
#include <nlohmann/json.hpp>
#include <thread>

#include "bot_core/planar_lidar_t.hpp"
#include "robot/pose2_t.hpp"

/// What the tests of the spy share: how it is started, and who it hears.
namespace marco::testing {

namespace fs = std::filesystem;
using nlohmann::json;
using std::chrono::milliseconds;
using ::testing::HasSubstr;

inline std::string spy() {
  const char* folder = std::getenv("MARCO_BIN");
  return std::string(folder == nullptr ? "." : folder) + "/marco-spy ";
}

inline std::string output_of(const std::string& command) {
  std::FILE* pipe = popen(command.c_str(), "r");
  std::string result;
  std::array<char, 4096> part;
  while (const std::size_t count = std::fread(part.data(), 1, part.size(), pipe))
    result.append(part.data(), count);
  pclose(pipe);
  return result;
}

inline json spy_json(const std::string& arguments) {
  const std::string text = output_of("timeout 30 " + spy() + arguments + " --once --json");
  return json::accept(text) ? json::parse(text) : json(text);
}

inline json channel_named(const json& report, const std::string& name) {
  for (const json& channel : report["channels"]) {
    if (channel["channel"] == name) return channel;
  }
  return {};
}

inline bool own_namespace() { return output_of("ip -o link").find("2:") == std::string::npos; }

/// Publishes POSE at 100 Hz and LIDAR at 10 Hz until destroyed.
class Publisher {
 public:
  explicit Publisher(const std::string& url = "") : lcm_(url), thread_([this] { run(); }) {}
  ~Publisher() {
    stop_ = true;
    thread_.join();
  }
  Publisher(const Publisher&) = delete;
  Publisher& operator=(const Publisher&) = delete;

 private:
  void run() {
    bot_core::planar_lidar_t lidar = {};
    lidar.nranges = 360;
    lidar.radstep = 0.0174533F;
    lidar.ranges.assign(360, 2.5F);
    for (int i = 0; !stop_; ++i) {
      robot::pose2_t pose = {};
      pose.x_m = i % 100;
      lcm_.publish("POSE", &pose);
      if (i % 10 == 0) lcm_.publish("LIDAR", &lidar);
      if (i % 10 == 0) lcm_.publish("LCM_SELF_TEST", "x", 1);
      std::this_thread::sleep_for(milliseconds(10));
    }
  }

  lcm::LCM lcm_;
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

// What a sender does, without liblcm's cost, so that the numbers are known exactly.
class Flood {
 public:
  Flood() : socket_(::socket(AF_INET, SOCK_DGRAM, 0)) {
    const char* url = std::getenv("LCM_DEFAULT_URL");
    const std::string text = url == nullptr ? "udpm://239.255.76.67:7667" : url;
    group_.sin_family = AF_INET;
    group_.sin_port = htons(static_cast<uint16_t>(std::atoi(text.c_str() + text.rfind(':') + 1)));
    inet_pton(AF_INET, "239.255.76.67", &group_.sin_addr);
    const unsigned char stay = 0;
    ::setsockopt(socket_, IPPROTO_IP, IP_MULTICAST_TTL, &stay, sizeof stay);
    const robot::pose2_t pose = {};
    std::memcpy(bytes_.data(), "LC02", 4);
    std::memcpy(bytes_.data() + 8, "POSE", 5);
    size_ = 13 + static_cast<std::size_t>(pose.encode(bytes_.data() + 13, 0, 100));
  }
  ~Flood() { ::close(socket_); }
  Flood(const Flood&) = delete;
  Flood& operator=(const Flood&) = delete;

  void send(int count) {
    for (; count > 0; --count, ++sent_) {
      const uint32_t number = htonl(static_cast<uint32_t>(sent_));
      std::memcpy(bytes_.data() + 4, &number, 4);
      ::sendto(socket_, bytes_.data(), size_, 0, reinterpret_cast<const sockaddr*>(&group_),
               sizeof group_);
    }
  }
  void send_paced(int per_second, double seconds) {
    const auto start = std::chrono::steady_clock::now();
    const int64_t first = sent_;
    const auto all = static_cast<int64_t>(per_second * seconds);
    while (sent_ - first < all) {
      const double elapsed_s =
          std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
      send(static_cast<int>(std::min(all, static_cast<int64_t>(elapsed_s * per_second)) -
                            (sent_ - first)));
      std::this_thread::sleep_for(std::chrono::microseconds(300));
    }
  }
  int64_t sent() const { return sent_; }

 private:
  int socket_;
  sockaddr_in group_ = {};
  std::array<uint8_t, 128> bytes_ = {};
  std::size_t size_ = 0;
  int64_t sent_ = 0;
};

}  // namespace marco::testing
