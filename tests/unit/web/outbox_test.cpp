#include "web/outbox.hpp"

#include <gmock/gmock.h>

namespace marco::web {
namespace {

Outgoing message(const std::string& body) {
  return {false, "", std::make_shared<const std::string>(body)};
}

std::string next(Outbox& outbox) {
  const auto taken = outbox.take();
  return taken ? *taken->body : "nothing";
}

TEST(Outbox, SendsControlFirstAndInOrder) {
  Outbox outbox;
  outbox.push_data(1, 0, message("data"));
  EXPECT_TRUE(outbox.push_control(message("a")));
  EXPECT_TRUE(outbox.push_control(message("b")));
  EXPECT_EQ(outbox.bytes(), 6U);
  EXPECT_EQ(next(outbox), "a");
  EXPECT_EQ(next(outbox), "b");
  EXPECT_EQ(next(outbox), "data");
  EXPECT_EQ(next(outbox), "nothing");
  EXPECT_EQ(outbox.bytes(), 0U);
}

TEST(Outbox, KeepsTheNewestOfAChannelsSlot) {
  Outbox outbox;
  outbox.push_data(1, 0, message("old"));
  outbox.push_data(1, 7, message("tile"));
  outbox.push_data(2, 0, message("other"));
  outbox.push_data(1, 0, message("newest"));
  EXPECT_EQ(outbox.dropped(), 0);
  EXPECT_EQ(next(outbox), "newest");  // in the place of the old one
  EXPECT_EQ(next(outbox), "tile");
  EXPECT_EQ(next(outbox), "other");
}

TEST(Outbox, SendsStatesBeforePartsOfMaps) {
  Outbox outbox;
  const std::string part(Outbox::kLargeBytes, 'p');
  for (const uint64_t tile : {0, 1}) outbox.push_data(1, tile, message(part));
  outbox.push_data(2, 0, message("pose"));
  EXPECT_EQ(next(outbox), "pose");
  EXPECT_EQ(next(outbox), part);
  outbox.push_data(2, 0, message("newer pose"));
  EXPECT_EQ(next(outbox), "newer pose");
  EXPECT_EQ(next(outbox), part);
  EXPECT_TRUE(outbox.empty());
}

TEST(Outbox, SendsAPartEachSoManyBytesThoughStatesNeverEnd) {
  Outbox outbox;
  const std::string state(Outbox::kLargeBytes / 4, 's'), part(Outbox::kLargeBytes, 'p');
  for (const uint64_t tile : {0, 1}) outbox.push_data(1, tile, message(part));
  std::string sent;
  for (int n = 0; n < 10; ++n) {
    outbox.push_data(2, 0, message(state));
    sent += next(outbox).front();
  }
  EXPECT_EQ(sent, "sssspssssp");
}

TEST(Outbox, KeepsTheNewestThoughItIsOfAnotherSize) {
  Outbox outbox;
  outbox.push_data(1, 0, message(std::string(Outbox::kLargeBytes, 'p')));
  outbox.push_data(1, 0, message("little"));
  EXPECT_EQ(outbox.bytes(), 6U);
  EXPECT_EQ(next(outbox), "little");
  EXPECT_TRUE(outbox.empty());
}

TEST(Outbox, ForgetsAChannel) {
  Outbox outbox;
  outbox.push_data(1, 0, message("a"));
  outbox.push_data(1, 5, message("b"));
  outbox.push_data(2, 0, message("c"));
  outbox.drop(1);
  EXPECT_EQ(outbox.bytes(), 1U);
  EXPECT_EQ(next(outbox), "c");
  EXPECT_TRUE(outbox.empty());
}

TEST(Outbox, IsBoundedForAClientThatNeverReads) {
  Outbox outbox;
  const std::string megabyte(1 << 20, 'x');
  for (uint64_t slot = 0; slot < 100; ++slot) outbox.push_data(1, slot, message(megabyte));
  EXPECT_LE(outbox.bytes(), Outbox::kMostBytes);
  EXPECT_EQ(outbox.dropped(), 100 - static_cast<int64_t>(Outbox::kMostBytes >> 20));
  bool fits = true;
  int pushed = 0;
  for (; fits && pushed < 100; ++pushed) fits = outbox.push_control(message(megabyte));
  EXPECT_EQ(pushed, static_cast<int>(Outbox::kMostControlBytes >> 20) + 1);
}

TEST(Outbox, KeepsOneMessageHoweverLarge) {
  Outbox outbox;
  outbox.push_data(1, 0, message("small"));
  outbox.push_data(1, 1, message(std::string(Outbox::kMostBytes + 1, 'x')));
  EXPECT_EQ(next(outbox).size(), Outbox::kMostBytes + 1);
}

}  // namespace
}  // namespace marco::web
