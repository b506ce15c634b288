#include <gtest/gtest.h>

#include "procman_lcm/deputy_info_t.hpp"
#include "procman_lcm/discovery_t.hpp"
#include "procman_lcm/orders_t.hpp"
#include "procman_lcm/output_t.hpp"

namespace procman_lcm {
namespace {

template <class Message>
uint64_t fingerprint() {
  return static_cast<uint64_t>(Message::getHash());
}

// The first eight bytes of the public procman's messages.
TEST(ProcmanFingerprint, IsThePublicProcmans) {
  EXPECT_EQ(fingerprint<cmd_t>(), 0x2277f449a855d330U);
  EXPECT_EQ(fingerprint<cmd_desired_t>(), 0xb2a6c7a09ba54539U);
  EXPECT_EQ(fingerprint<cmd_status_t>(), 0xa8e0208786cf86e3U);
  EXPECT_EQ(fingerprint<deputy_info_t>(), 0x8876aeb040efd01fU);
  EXPECT_EQ(fingerprint<orders_t>(), 0xd343f45b171ab855U);
  EXPECT_EQ(fingerprint<discovery_t>(), 0xb1c83182bed74b95U);
  EXPECT_EQ(fingerprint<output_t>(), 0x8efa5caf5da01eb3U);
}

}  // namespace
}  // namespace procman_lcm
