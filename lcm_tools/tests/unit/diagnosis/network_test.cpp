#include "lcm_tools/diagnosis/network.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace marco::diagnosis {
namespace {

using ::testing::HasSubstr;

TEST(UdpUrl, PartsMayBeMissing) {
  EXPECT_EQ(parse_udp_url("udpm://").text(), "udpm://239.255.76.67:7667");
  EXPECT_EQ(parse_udp_url("udpm://:7000").text(), "udpm://239.255.76.67:7000");
  const UdpUrl url = parse_udp_url("udpm://239.1.2.3:99?ttl=1&recv_buf_size=2097152");
  EXPECT_EQ(url.text(), "udpm://239.1.2.3:99");
  EXPECT_EQ(url.ttl, 1);
  EXPECT_EQ(url.recv_buf_bytes, 2097152);
}

TEST(UdpUrl, WhatCannotBeSpiedOnIsRefused) {
  for (const char* url :
       {"memq://", "tcpq://", "239.255.76.67", "udpm://10.0.0.1:7667", "udpm://239.1.2:1",
        "udpm://239.1.2.3:0", "udpm://239.1.2.3:70000", "udpm://?ttl=x"}) {
    EXPECT_THROW(parse_udp_url(url), std::invalid_argument) << url;
  }
}

// As the kernel prints them on a little-endian machine.
constexpr const char* kUdp =
    "   sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt   uid  timeout "
    "inode ref pointer drops\n"
    " 1127: 00000000:1DF3 00000000:0000 07 00000000:00000000 00:00000000 00000000     0        0 "
    "4401 2 0000000000000000 17\n"
    " 2345: 0100007F:A02B 00000000:0000 07 00000000:00000000 00:00000000 00000000  1000        0 "
    "4402 2 0000000000000000 0\n"
    "garbage\n";

TEST(ProcTables, SocketsAreRead) {
  const auto sockets = parse_udp_sockets(kUdp);
  ASSERT_EQ(sockets.size(), 2U);
  EXPECT_EQ(sockets[0].local.port, 7667);
  EXPECT_EQ(sockets[0].inode, 4401U);
  EXPECT_EQ(sockets[0].drops, 17);
  EXPECT_EQ(to_string(sockets[1].local), "127.0.0.1:41003");
}

TEST(ProcTables, TheRouteOfAGroupIsTheMostSpecificOne) {
  const auto routes = parse_routes(
      "Iface\tDestination\tGateway \tFlags\tRefCnt\tUse\tMetric\tMask\t\tMTU\tWindow\tIRTT\n"
      "eth0\t00000000\t0101A8C0\t0003\t0\t0\t100\t00000000\t0\t0\t0\n"
      "wlan0\t00000000\t0101A8C0\t0003\t0\t0\t50\t00000000\t0\t0\t0\n"
      "lo\t000000E0\t00000000\t0001\t0\t0\t0\t000000F0\t0\t0\t0\n");
  ASSERT_EQ(routes.size(), 3U);
  EXPECT_EQ(route_to(routes, 0xEFFF4C43)->device, "lo");
  EXPECT_EQ(route_to(routes, 0x08080808)->device, "wlan0");
  EXPECT_EQ(route_to({}, 0xEFFF4C43), nullptr);
}

TEST(ProcTables, JoinedGroupsAreRead) {
  const auto groups = parse_joined_groups(
      "Idx\tDevice    : Count Querier\tGroup    Users Timer\tReporter\n"
      "1\tlo        :     2      V3\n"
      "\t\t\t\t434CFFEF     1 0:00000000\t\t0\n"
      "\t\t\t\t010000E0     1 0:00000000\t\t0\n");
  EXPECT_THAT(groups, ::testing::ElementsAre(0xEFFF4C43));
}

class Diagnosis : public ::testing::Test {
 protected:
  Diagnosis() {
    state_.routes = {{"lo", 0xE0000000, 0xF0000000, 0}};
    state_.interfaces = {{"lo", true, true}, {"eth0", true, true}};
    state_.self_test = true;
    state_.rmem_max = 212992;
  }
  Finding first() const { return diagnose(state_).at(0); }
  NetworkState state_;
};

TEST_F(Diagnosis, NoRoute) {
  state_.routes.clear();
  EXPECT_THAT(first().text, HasSubstr("no route"));
  EXPECT_EQ(first().command,
            "sudo ip link set lo multicast on && sudo ip route add 224.0.0.0/4 dev lo");
  state_.interfaces[0].up = false;
  EXPECT_THAT(first().command, HasSubstr("lo up multicast on"));
}

TEST_F(Diagnosis, InterfaceDown) {
  state_.interfaces[0].up = false;
  EXPECT_EQ(first().command, "sudo ip link set lo up");
}

TEST_F(Diagnosis, NoMulticastFlag) {
  state_.interfaces[0].multicast = false;
  EXPECT_EQ(first().command, "sudo ip link set lo multicast on");
}

TEST_F(Diagnosis, ProbeDoesNotComeBack) {
  state_.self_test = false;
  EXPECT_THAT(first().text, HasSubstr("firewall"));
  EXPECT_THAT(first().command, HasSubstr("iptables"));
}

TEST_F(Diagnosis, AnotherUrlIsSpokenOn) {
  state_.heard_urls = {"udpm://239.255.76.67:7668"};
  EXPECT_EQ(first().command, "marco-spy --lcm-url 'udpm://239.255.76.67:7668'");
  state_.heard_urls.clear();
  state_.other_urls = {{{12, "drive"}, "udpm://239.255.76.67:7669"}};
  EXPECT_THAT(first().text, HasSubstr("drive (12)"));
}

TEST_F(Diagnosis, NobodyPublishesHereAndOtherHostsNeedARouteOrTtl) {
  EXPECT_THAT(first().text, HasSubstr("nobody publishes"));
  EXPECT_THAT(diagnose(state_).at(1).command, HasSubstr("dev eth0"));
  state_.routes[0].device = "eth0";
  EXPECT_THAT(diagnose(state_).at(1).command, HasSubstr("ttl=1"));
}

TEST_F(Diagnosis, BufferOverflowIsSaidAlsoWhenMessagesCome) {
  state_.heard_messages = 1000;
  EXPECT_TRUE(diagnose(state_).empty());
  state_.listeners = {{{7, "logger"}, 12, false}, {{}, 0, true}};
  ASSERT_EQ(diagnose(state_).size(), 1U);
  EXPECT_THAT(first().text, HasSubstr("logger (7)'s receive buffer overflowed: 12"));
  EXPECT_THAT(first().command, HasSubstr("sysctl -w net.core.rmem_max"));
}

}  // namespace
}  // namespace marco::diagnosis
