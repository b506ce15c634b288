#include "web/access.hpp"

#include <gmock/gmock.h>

#include <set>

namespace marco::web {
namespace {

using Right = Access::Right;

Right judge(const Access& access, Access::Request request) {
  std::string why;
  const Right right = access.judge(request, why);
  EXPECT_EQ(right == Right::refused, !why.empty());
  return right;
}

TEST(AccessOnLoopback, LetsOwnPagesAndProgramsSteer) {
  const Access access("", true, {}, {"robot"});
  EXPECT_EQ(judge(access, {"127.0.0.1:8765", "", ""}), Right::steer);
  EXPECT_EQ(judge(access, {"localhost:8765", "http://localhost:8765", ""}), Right::steer);
  EXPECT_EQ(judge(access, {"[::1]:8765", "http://[::1]:8765", ""}), Right::steer);
  EXPECT_EQ(judge(access, {"Robot:8765", "http://robot:8765", ""}), Right::steer);
}

TEST(AccessOnLoopback, RefusesPagesOfOtherSites) {
  const Access access("", true, {}, {"robot"});
  EXPECT_EQ(judge(access, {"127.0.0.1:8765", "https://evil.org", ""}), Right::refused);
  EXPECT_EQ(judge(access, {"127.0.0.1:8765", "null", ""}), Right::refused);
  EXPECT_EQ(judge(access, {"127.0.0.1:8765", "http://127.0.0.1:8080", ""}), Right::refused);
  // Its name was made to point here.
  EXPECT_EQ(judge(access, {"evil.org:8765", "http://evil.org:8765", ""}), Right::refused);
  EXPECT_EQ(judge(access, {"", "", ""}), Right::refused);
}

TEST(AccessOnLoopback, LetsFoxgloveLookAndSteerWhereItIsListed) {
  const Access::Request foxglove{"localhost:8765", "https://app.foxglove.dev", ""};
  EXPECT_EQ(judge(Access("", true, {}, {}), foxglove), Right::look);
  EXPECT_EQ(judge(Access("", true, {"https://app.foxglove.dev"}, {}), foxglove), Right::steer);
  EXPECT_EQ(judge(Access("", false, {}, {}), {"10.0.0.2", "https://app.foxglove.dev", ""}),
            Right::refused);
  const Access with_token("secret", true, {}, {});
  EXPECT_EQ(judge(with_token, {"localhost", "https://app.foxglove.dev", "secret"}), Right::steer);
}

TEST(AccessByToken, IsNeededToSteer) {
  const Access access("secret", false, {}, {});
  EXPECT_EQ(judge(access, {"10.0.0.2:8765", "", "secret"}), Right::steer);
  EXPECT_EQ(judge(access, {"10.0.0.2:8765", "", ""}), Right::look);
  EXPECT_EQ(judge(access, {"10.0.0.2:8765", "", "Secret"}), Right::refused);
  EXPECT_EQ(judge(access, {"10.0.0.2:8765", "", "secretsecret"}), Right::refused);
  EXPECT_EQ(judge(access, {"10.0.0.2:8765", "https://evil.org", "secret"}), Right::refused);
}

TEST(Tokens, AreLongAndNeverTheSame) {
  std::set<std::string> tokens;
  for (int i = 0; i < 50; ++i) tokens.insert(new_token());
  EXPECT_EQ(tokens.size(), 50U);
  for (const std::string& token : tokens) EXPECT_GE(token.size(), 20U);
  EXPECT_TRUE(are_equal("", ""));
  EXPECT_FALSE(are_equal("", "a"));
  EXPECT_FALSE(are_equal("ab", "a"));
}

TEST(Tokens, ThatAreEasyToGuessAreRefused) {
  EXPECT_EQ(why_weak(new_token()), "");
  EXPECT_EQ(why_weak("k3jhd84hfkw92-_x"), "");
  for (const char* weak : {"", "1234", "k3jhd84hfkw92-_", "aaaaaaaaaaaaaaaaaaaaaaaa",
                           "passwordpassword", "abcabcabcabcabcabcabc", "with a space in it!!",
                           "k3jhd84hfkw92&x=y", "k3jhd84hfkw92\xc3\xa4\xc3\xb6"}) {
    EXPECT_NE(why_weak(weak), "") << weak;
  }
  EXPECT_NE(why_weak(std::string(1000, 'a')), "");
}

TEST(Hosts, AreNamesWithAPortAndNothingElse) {
  const Access access("", false, {}, {"robot"});
  for (const char* ours :
       {"[::1]", "[::1]:8765", "127.0.0.1", "127.0.0.1:80", "ROBOT:8765", "[fe80::1%25eth0]:1"}) {
    EXPECT_EQ(access.is_our_host(ours), std::string_view(ours).find('%') == std::string_view::npos)
        << ours;
  }
  for (const char* other : {"[::1]evil.com", "[::1]:80evil", "[::1", "127.0.0.1:80@evil.com",
                            "127.0.0.1 evil.com", "robot.evil.com", "robot:x", "[]", ":80",
                            "127.0.0.1\x0b"
                            "evil.com",
                            "evil.com"}) {
    EXPECT_FALSE(access.is_our_host(other)) << other;
  }
  EXPECT_FALSE(access.is_our_host(std::string(100'000, '1')));
}

TEST(Loopback, IsThisHost) {
  EXPECT_TRUE(is_loopback("127.0.0.1"));
  EXPECT_TRUE(is_loopback("127.9.9.9"));
  EXPECT_TRUE(is_loopback("::1"));
  EXPECT_FALSE(is_loopback("0.0.0.0"));
  EXPECT_FALSE(is_loopback("10.0.0.1"));
  EXPECT_FALSE(is_loopback("::"));
}

}  // namespace
}  // namespace marco::web
