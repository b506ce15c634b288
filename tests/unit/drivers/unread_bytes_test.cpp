#include "drivers/transport/unread_bytes.hpp"

#include <gmock/gmock.h>

namespace marco::drivers {
namespace {

using ::testing::ElementsAre;
using Bytes = std::vector<uint8_t>;

TEST(UnreadBytes, GivesWhatIsLeftInOrderAndCountsOnlyWhatWasSkipped) {
  UnreadBytes unread;
  EXPECT_TRUE(unread.empty());
  unread.push(Bytes{1, 2, 3, 4});
  unread.skip();
  unread.take(2);
  EXPECT_THAT(unread.rest(), ElementsAre(4));
  unread.push(Bytes{5, 6});
  EXPECT_THAT(unread.rest(), ElementsAre(4, 5, 6));
  EXPECT_EQ(unread.size(), 3u);
  unread.skip(2);
  unread.clear();
  EXPECT_TRUE(unread.empty());
  unread.push(Bytes{7});
  EXPECT_THAT(unread.rest(), ElementsAre(7));
  EXPECT_EQ(unread.skipped(), 3);
}

}  // namespace
}  // namespace marco::drivers
