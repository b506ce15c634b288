#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>
#include <sys/socket.h>

#include <algorithm>
#include <cstdlib>
#include <sstream>

#include "lcm_tools/diagnosis/host.hpp"
#include "lcm_tools/diagnosis/listening_socket.hpp"
#include "lcm_tools/process/lcm_bus.hpp"
#include "lcm_tools/process/status_publisher.hpp"
#include "marco/process_status_t.hpp"

namespace marco::process {
namespace {

using testing::HasSubstr;

const std::string kGroup = "udpm://239.255.76.67:7667";

/// The receive buffer that the one UDP socket has that was opened since `before`.
int buffer_since(const std::set<int>& before) {
  int bytes = 0;
  for (const int socket : diagnosis::own_udp_sockets()) {
    socklen_t size = sizeof bytes;
    if (!before.contains(socket)) getsockopt(socket, SOL_SOCKET, SO_RCVBUF, &bytes, &size);
  }
  return bytes / 2;
}

TEST(ReceiveBuffer, IsTwoMegabytesUnlessTheUrlNamesASize) {
  const int most = std::atoi(diagnosis::read_text("/proc/sys/net/core/rmem_max").c_str());
  const std::map<std::string, int> cases = {{"", 2 << 20},
                                            {"?ttl=0", 2 << 20},
                                            {"?ttl=0&", 2 << 20},
                                            {"?recv_buf_size=0&ttl=0", 2 << 20},
                                            {"?recv_buf_size=65536&ttl=0", 65536},
                                            {"?ttl=0&recv_buf_size=65536", 65536}};
  for (const auto& [options, bytes] : cases) {
    LcmBus bus(kGroup + options);
    const std::set<int> before = diagnosis::own_udp_sockets();
    bus.subscribe_raw("A", [](const RawMessage&) {});
    // More where we have root's rights.
    EXPECT_GE(buffer_since(before), std::min(bytes, most)) << options;
    EXPECT_LE(buffer_since(before), bytes) << options;
  }
}

TEST(ReceiveBuffer, SaysOnceWhatTheSystemDoesNotGiveAndHowToMendIt) {
  std::ostringstream text;
  const auto before = spdlog::default_logger();
  spdlog::set_default_logger(
      std::make_shared<spdlog::logger>("", std::make_shared<spdlog::sinks::ostream_sink_st>(text)));
  LcmBus bus(kGroup + "?ttl=0&recv_buf_size=1000000000");
  const std::set<int> sockets = diagnosis::own_udp_sockets();
  bus.subscribe_raw("A", [](const RawMessage&) {});
  bus.subscribe_raw("B", [](const RawMessage&) {});
  spdlog::set_default_logger(before);
  if (buffer_since(sockets) == 1'000'000'000) {
    EXPECT_EQ(text.str(), "") << "with root's rights";
    return;
  }
  const std::string line = "sudo sysctl -w net.core.rmem_max=";
  EXPECT_THAT(text.str(), HasSubstr("kB instead of 976562: large messages may be lost"));
  EXPECT_NE(text.str().find(line), std::string::npos);
  EXPECT_EQ(text.str().find(line), text.str().rfind(line)) << text.str();
}

TEST(ReceiveBuffer, WhatItLosesIsCountedAndPublished) {
  LcmBus bus(kGroup + "?ttl=0&recv_buf_size=4096");
  EXPECT_EQ(bus.lost_datagrams(), 0);
  bus.subscribe_raw("GRID", [](const RawMessage&) {});
  LcmBus other(kGroup + "?ttl=0");
  const std::vector<uint8_t> grid(1'000'000);
  for (int i = 0; i < 1000 && bus.lost_datagrams() == 0; ++i) other.publish_raw("GRID", grid, {});
  const int64_t lost = bus.lost_datagrams();
  ASSERT_GT(lost, 0);
  EXPECT_EQ(other.lost_datagrams(), 0) << "of its own sockets only";
  DropCounter drops;
  process_status_t status;
  other.subscribe<process_status_t>("PROCESS_STATUS", drops,
                                    [&](const auto& message, const auto&) { status = message; });
  StatusPublisher(bus, "test", drops).send("");
  for (int i = 0; i < 500 && status.process != "test"; ++i) other.handle_once(10);
  ASSERT_EQ(status.num_causes, 1);
  EXPECT_EQ(status.drop_causes[0], "the receive buffer overflowed: datagrams");
  EXPECT_GE(status.drop_counts[0], lost);
  EXPECT_LE(status.drop_counts[0], bus.lost_datagrams());
}

}  // namespace
}  // namespace marco::process
