// Who makes room for whom, and whose turn it is.
#include "web/crowd.hpp"

#include <gmock/gmock.h>

namespace marco::web {
namespace {

using ::testing::ElementsAre;

/// Connections by number; those that were closed, in order.
struct Table {
  Connections connections;
  std::map<int, Connections::Place> places;
  std::vector<int> closed;

  bool open(int number, const std::string& address) {
    const auto close = [this, number] {
      closed.push_back(number);
      connections.remove(places.at(number));
    };
    return connections.add(address, close, places[number]);
  }
};

TEST(Connections, TheOldestThatWaitsOfTheCrowdMakesRoom) {
  Table table;
  table.open(0, "operator");
  const int most = static_cast<int>(Connections::kMost);
  for (int i = 1; i < most; ++i) EXPECT_FALSE(table.open(i, "crowd"));
  EXPECT_TRUE(table.open(most, "crowd"));
  table.connections.set_waiting(table.places[2], false);  // is being answered
  table.connections.set_waiting(table.places[3], false);
  table.connections.set_waiting(table.places[3], true);  // was, and waits since just now
  EXPECT_TRUE(table.open(most + 1, "operator"));
  EXPECT_TRUE(table.open(most + 2, "operator"));
  EXPECT_THAT(table.closed, ElementsAre(1, 4, 5));
  EXPECT_EQ(table.connections.size(), Connections::kMost);
}

TEST(Connections, WhereNoneWaitsTheLongestAnswerEnds) {
  Table table;
  for (int i = 0; i < static_cast<int>(Connections::kMost); ++i) {
    table.open(i, "crowd");
    table.connections.set_waiting(table.places[i], false);
  }
  EXPECT_TRUE(table.open(1000, "other"));
  EXPECT_THAT(table.closed, ElementsAre(0));
}

TEST(GuessPace, AnswersOneASecondOfAnAddressAndFourOfAll) {
  GuessPace pace;
  double last_s = 0.0;
  for (int i = 0; i < 10; ++i) {
    const double at_s = pace.wait_s("a", 100.0);
    EXPECT_GT(at_s, i == 0 ? 0.0 : last_s + 0.99);
    last_s = at_s;
  }
  GuessPace crowd;
  int soon = 0;
  for (int i = 0; i < 10'000; ++i) soon += crowd.wait_s(std::to_string(i), 100.0) < 10.0 ? 1 : 0;
  EXPECT_LE(soon, 41);
  EXPECT_LT(crowd.wait_s("a", 200.0), 0.3);  // it is over
}

TEST(Turns, WhoSteersIsFirstAndWatchersAreNotForgotten) {
  Turns turns;
  std::string order;
  const auto add = [&](Turns::Rank rank, char mark) {
    turns.add(rank, [&, mark] { order += mark; });
  };
  for (int i = 0; i < 20; ++i) add(Turns::Rank::requests, 'r');
  for (int i = 0; i < 3; ++i) add(Turns::Rank::watches, 'w');
  for (int i = 0; i < 2; ++i) add(Turns::Rank::steers, 's');
  while (!turns.empty()) turns.take_one();
  EXPECT_EQ(order, "ssrrrrrrrrwrrrrrrrrwrrrrw");
  turns.take_one();  // nothing
}

}  // namespace
}  // namespace marco::web
