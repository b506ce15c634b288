#include "tools/bridge/websocket.hpp"

#include <gtest/gtest.h>

namespace marco::bridge {
namespace {

TEST(WebSocketUrl, HasAHostAndPerhapsAPortAndAPath) {
  const auto is = [](const std::string& url, const char* host, const char* port, const char* path) {
    const WebSocketUrl parsed = parse_websocket_url(url);
    EXPECT_EQ(parsed.host, host) << url;
    EXPECT_EQ(parsed.port, port) << url;
    EXPECT_EQ(parsed.path, path) << url;
  };
  is("ws://robot", "robot", "8765", "/");
  is("ws://robot:9090/a/b", "robot", "9090", "/a/b");
  is("ws://[::1]:9090", "::1", "9090", "/");
  is("ws://[::1]", "::1", "8765", "/");
  for (const char* url :
       {"wss://robot", "ws://", "ws://:8765", "ws://robot:", "ws://robot:x", "robot"}) {
    EXPECT_THROW(parse_websocket_url(url), std::invalid_argument) << url;
  }
}

}  // namespace
}  // namespace marco::bridge
