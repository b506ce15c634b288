#include "lcm_tools/spy/view.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "bot_core/pose_t.hpp"
#include "lcm_tools/tests/unit/spy/spy_fixture.hpp"
#include "marco/emergency_stop_t.hpp"
#include "marco/process_status_t.hpp"
#include "robot/slam_pose_t.hpp"

namespace marco::spy {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

class Screen : public ::testing::Test {
 protected:
  Screen() : model_(test_decoder()) {
    around_.source = "udpm://239.255.76.67:7667";
    around_.now_us = 10'000'000;
    for (int i = 0; i < 100; ++i) {
      robot::slam_pose_t pose = {};
      pose.x_m = i;
      pose.covariance[1][2] = 0.25;
      model_.add_datagram(100000 * i, {1, 1},
                          short_datagram(static_cast<uint32_t>(i), "SLAM_POSE", encoded(pose)));
      if (i % 2 == 0)
        model_.add_datagram(
            100000 * i, {1, 2},
            short_datagram(static_cast<uint32_t>(i), "LIDAR", std::vector<uint8_t>(16, 7)));
    }
    process_status_t status = {};
    status.process = "marco-slam";
    status.num_causes = 1;
    status.drop_causes = {"time_backwards"};
    status.drop_counts = {3};
    model_.add_datagram(9'900'000, {1, 1}, short_datagram(100, "PROCESS_STATUS", encoded(status)));
  }
  std::string screen(int width = 110, int height = 20) {
    return draw(model_, view_, around_, width, height).to_text();
  }
  Action press(char c) { return handle_key(view_, {Key::character, c}, model_, around_); }
  Action press(Key key) { return handle_key(view_, {key, 0}, model_, around_); }
  void type(const char* text) {
    for (; *text != '\0'; ++text) press(*text);
  }
  std::vector<std::string> order() {
    std::vector<std::string> names;
    for (const int i : visible_channels(model_, view_, around_))
      names.push_back(model_.channels()[static_cast<std::size_t>(i)].name);
    return names;
  }

  Model model_;
  View view_;
  Surroundings around_;
};

TEST_F(Screen, TheTableShowsEveryColumn) {
  const std::string text = screen();
  EXPECT_THAT(text, HasSubstr("SLAM_POSE"));
  EXPECT_THAT(text, HasSubstr("slam_pose_t (robot)"));
  EXPECT_THAT(text, HasSubstr("?? 0707070707070707"));
  EXPECT_THAT(text, ::testing::ContainsRegex(
                        "SLAM_POSE +slam_pose_t \\(robot\\) +100 +10 +0 ms +1210 +0.1 s +0 +0"));
  EXPECT_THAT(text, ::testing::ContainsRegex("LIDAR .* 50 +5 +0 ms +80 +0.2 s +50 +49"));
}

TEST_F(Screen, SortsByAnyColumnBothWays) {
  EXPECT_THAT(order(), ElementsAre("LIDAR", "PROCESS_STATUS", "SLAM_POSE"));
  press('r');
  EXPECT_THAT(order(), ElementsAre("SLAM_POSE", "PROCESS_STATUS", "LIDAR"));
  press('s');
  press('s');
  EXPECT_EQ(view_.sort, Column::count);
  EXPECT_THAT(order(), ElementsAre("SLAM_POSE", "LIDAR", "PROCESS_STATUS"));
  view_.sort = Column::lost;
  EXPECT_EQ(order().front(), "LIDAR");
}

TEST_F(Screen, FiltersByNameAndType) {
  press('/');
  type("slam");
  EXPECT_THAT(screen(), HasSubstr("filter: slam_"));
  press(Key::enter);
  EXPECT_THAT(order(), ElementsAre("SLAM_POSE"));
  press('/');
  for (int i = 0; i < 9; ++i) press(Key::erase);
  type("STATUS_T");
  EXPECT_THAT(order(), ElementsAre("PROCESS_STATUS"));
  press(Key::back);
  EXPECT_EQ(order().size(), 3U);
  EXPECT_EQ(view_.page, Page::table);
}

TEST_F(Screen, KeysAskForPauseClearTypeAndQuit) {
  EXPECT_EQ(press('p'), Action::pause);
  EXPECT_EQ(press('c'), Action::clear);
  EXPECT_EQ(press('t'), Action::next_type);
  EXPECT_EQ(press('q'), Action::quit);
  EXPECT_EQ(press('z'), Action::none);
}

TEST_F(Screen, AtEightyCellsTheTypesNameIsThere) {
  const std::string text = screen(80, 24);
  EXPECT_THAT(text, HasSubstr("SLAM_POSE      slam_pose_t ("));
  EXPECT_THAT(text, HasSubstr("PROCESS_STATUS process_statu~"));
  EXPECT_THAT(text,
              ::testing::ContainsRegex("CHANNEL.*TYPE.*COUNT.*HZ.*JITTER.*B/S.*AGE.*UNDEC.*LOST"));
  EXPECT_THAT(text, ::testing::ContainsRegex(" 100 +10 +0 ms +1210 +0.1 s +0 +0\n"));
}

TEST_F(Screen, AtEightyCellsNoHelpNorKeyIsCut) {
  for (const Page page :
       {Page::table, Page::channel, Page::plot, Page::picture, Page::who, Page::help}) {
    view_.page = page;
    view_.selected = "SLAM_POSE";
    const std::string text = screen(80, 24);
    const std::size_t keys = text.rfind('\n', text.size() - 2);
    EXPECT_THAT(text.substr(keys), HasSubstr("q quit\n")) << text;
  }
  const std::string text = screen(80, 24);  // help
  EXPECT_THAT(text, Not(HasSubstr("~\n")));
  EXPECT_THAT(text, HasSubstr("v g +    draw the scan"));
  EXPECT_THAT(text, HasSubstr("releases it, after asking\n"));
  view_.asks_release = true;
  EXPECT_THAT(screen(80, 24), HasSubstr("other keys no\n"));
}

TEST_F(Screen, NumbersInNamesSortByTheirValue) {
  model_.clear();
  for (const char* name :
       {"B-10", "B-2", "B-02", "A", "B-2x", "B-10a", "B9", "B-100000000000000000001"})
    model_.add_message(1, name, std::vector<uint8_t>{1});
  EXPECT_THAT(order(), ElementsAre("A", "B-02", "B-2", "B-2x", "B-10", "B-10a",
                                   "B-100000000000000000001", "B9"));
}

TEST_F(Screen, WhoHearsNothingIsToldWhatToDo) {
  model_.clear();
  around_.findings.push_back(
      {"no route leads to 239.255.76.67: no process on this host can publish, and none can hear, "
       "as "
       "long as that is so",
       "sudo ip route add 224.0.0.0/4 dev lo"});
  const std::string text = screen(80, 24);
  EXPECT_THAT(text, HasSubstr("no messages yet\n"));
  EXPECT_THAT(text, HasSubstr("marco-log play LOG"));
  EXPECT_THAT(
      text,
      HasSubstr("publish, and\n   none can hear, as long as that is so\n"));  // wrapped, not cut
  EXPECT_THAT(text, HasSubstr("     sudo ip route add 224.0.0.0/4 dev lo\n"));
  EXPECT_THAT(text, Not(HasSubstr("~\n")));
  around_.findings.clear();
  around_.is_log = true;
  EXPECT_THAT(screen(80, 24), Not(HasSubstr("marco-log play")));
  around_.is_log = false;
  around_.hints = {"ask the robot"};
  EXPECT_THAT(screen(80, 24), HasSubstr("ask the robot\n"));
}

TEST_F(Screen, RobotsAreStoppedAtOnceAndReleasedOnlyAfterAQuestion) {
  for (const Page page : {Page::table, Page::channel, Page::plot, Page::who, Page::help}) {
    view_.page = page;
    EXPECT_EQ(press('x'), Action::stop);
    EXPECT_EQ(press('X'), Action::none);
    EXPECT_THAT(screen(80, 24), HasSubstr("Release the emergency stop?"));
    EXPECT_EQ(press('n'), Action::none);
    EXPECT_EQ(press('y'), Action::none);  // the question is over
    press('X');
    EXPECT_EQ(press('y'), Action::release);
  }
  view_.page = Page::table;
  press('/');
  EXPECT_EQ(press('x'), Action::none);  // a letter of the filter
  press(Key::back);
  around_.is_log = true;
  press('X');
  EXPECT_FALSE(view_.asks_release);
}

TEST_F(Screen, AnEngagedStopIsShownWithItsSender) {
  EXPECT_FALSE(emergency_stop(model_));
  emergency_stop_t stop = {};
  stop.engaged = 1;
  stop.sender = "teleop";
  stop.reason = "space";
  model_.add_message(1, "EMERGENCY_STOP", encoded(stop));
  around_.emergency = emergency_stop(model_);
  ASSERT_TRUE(around_.emergency);
  for (const Page page : {Page::table, Page::channel, Page::help}) {
    view_.page = page;
    EXPECT_THAT(screen(80, 24), HasSubstr("EMERGENCY STOP by teleop: space"));
    EXPECT_THAT(screen(80, 24), HasSubstr("X release  q quit\n"));
  }
  stop.engaged = 0;
  model_.add_message(2, "EMERGENCY_STOP", encoded(stop));
  around_.emergency = emergency_stop(model_);
  EXPECT_FALSE(around_.emergency->engaged);
  EXPECT_THAT(screen(80, 24), Not(HasSubstr("EMERGENCY STOP by")));
  // Something else on the channel says nothing.
  model_.add_message(3, "EMERGENCY_STOP", encoded(robot::slam_pose_t{}));
  EXPECT_FALSE(emergency_stop(model_));
}

TEST_F(Screen, AChannelOpensWithFoldedFields) {
  press(Key::end);
  press(Key::enter);
  EXPECT_EQ(view_.selected, "SLAM_POSE");
  std::string text = screen();
  EXPECT_THAT(text, HasSubstr("▸ covariance"));
  EXPECT_THAT(text, HasSubstr("double[3][3]"));
  EXPECT_THAT(text, ::testing::ContainsRegex("x_m +double +99 +▁"));
  EXPECT_THAT(text, Not(HasSubstr("[1][2]")));
  for (int i = 0; i < 4; ++i) press(Key::down);
  EXPECT_EQ(view_.cursor, "covariance");
  press(Key::enter);
  EXPECT_THAT(screen(), ::testing::ContainsRegex("\\[1\\]\\[2\\] +0.25"));
  press(Key::enter);
  EXPECT_THAT(screen(), Not(HasSubstr("[1][2]")));
  press(Key::back);
  EXPECT_EQ(view_.page, Page::table);
}

TEST_F(Screen, StringsAndListsUnfold) {
  view_.page = Page::channel;
  view_.selected = "PROCESS_STATUS";
  view_.unfolded.insert("PROCESS_STATUS/drop_causes");
  const std::string text = screen();
  EXPECT_THAT(text, HasSubstr("\"marco-slam\""));
  EXPECT_THAT(text, ::testing::ContainsRegex("\\[0\\].*\"time_backwards\""));
}

TEST_F(Screen, AFieldIsPlotted) {
  view_.page = Page::channel;
  view_.selected = "SLAM_POSE";
  view_.cursor = "x_m";
  press('g');
  EXPECT_EQ(view_.page, Page::plot);
  const std::string text = screen();
  EXPECT_THAT(text, HasSubstr("x_m = 99"));
  // A straight line from the lower left to the upper right.
  EXPECT_THAT(text, ::testing::ContainsRegex("\n +99┤"));
  EXPECT_THAT(text, ::testing::ContainsRegex("\n +0┤"));
  EXPECT_THAT(text, HasSubstr("-9.9 s"));
  press(Key::back);
  EXPECT_EQ(view_.page, Page::channel);
}

TEST_F(Screen, WhoDrawsSendersChannelsAndLosses) {
  around_.publishers[{1, 2}] = {77, "sick-driver"};
  around_.listeners = {{{78, "lcm-logger"}, 5, false}};
  press('w');
  const std::string text = screen();
  EXPECT_THAT(text, HasSubstr("sick-driver (77)  0.0.0.1:2   50 messages, lost 49"));
  EXPECT_THAT(text, ::testing::ContainsRegex("└──▶ LIDAR .* lost 49"));
  EXPECT_THAT(text, HasSubstr("├──▶ SLAM_POSE"));
  EXPECT_THAT(text, HasSubstr("lcm-logger (78)   lost 5"));
}

TEST_F(Screen, EverySizeAndPageIsDrawn) {
  around_.findings.push_back({"something", "command"});
  around_.problems = {"a", "b", "c", "d"};
  for (const Page page :
       {Page::table, Page::channel, Page::plot, Page::picture, Page::who, Page::help}) {
    for (const char* channel : {"SLAM_POSE", "LIDAR", "NONE"}) {
      for (const int size : {1, 2, 5, 20, 200}) {
        view_.page = page;
        view_.selected = channel;
        view_.plotted = {"x_m", "covariance[1][2]", "nothing"};
        EXPECT_EQ(draw(model_, view_, around_, size, size).width(), size);
        for (const Key key :
             {Key::up, Key::down, Key::page_down, Key::enter, Key::home, Key::end}) {
          view_.page = page;
          press(key);
        }
      }
    }
  }
}

TEST_F(Screen, SeriesFollowAField) {
  const Channel& channel = model_.channels()[static_cast<std::size_t>(model_.find("SLAM_POSE"))];
  EXPECT_THAT(series_of(model_, channel, "x_m", 3).values, ElementsAre(97, 98, 99));
  EXPECT_THAT(series_of(model_, channel, "covariance[1][2]", 1).values, ElementsAre(0.25));
  EXPECT_TRUE(std::isnan(series_of(model_, channel, "covariance[1][3]", 1).values[0]));
  EXPECT_TRUE(std::isnan(series_of(model_, channel, "covariance[1]", 1).values[0]));
  EXPECT_TRUE(std::isnan(series_of(model_, channel, "covariance", 1).values[0]));
}

TEST(Canvas, CutsTextAndRefusesWildCharacters) {
  Canvas canvas(6, 1);
  canvas.text(0, 0, "abcdefgh");
  EXPECT_EQ(canvas.to_text(), "abcde~\n");
  canvas.text(0, 0, "a\x1b[2J\xff", Style::normal);
  EXPECT_EQ(canvas.to_text(), "a?[2J?\n");
}

TEST(Canvas, NumbersAreShort) {
  EXPECT_EQ(short_number(0), "0");
  EXPECT_EQ(short_number(6.637), "6.64");
  EXPECT_EQ(short_number(9994), "9994");
  EXPECT_EQ(short_number(97900), "97.9k");
  EXPECT_EQ(short_number(2.74e6), "2.74M");
  EXPECT_EQ(short_number(INFINITY), "-");
}

TEST(Canvas, SparklinesSpanMinimumToMaximum) {
  const double values[] = {5, 0, 7, NAN, 3.5};
  EXPECT_EQ(sparkline(values, 4), U"▁█ ▅");
  const double huge[] = {-1e308, 1e308};
  EXPECT_EQ(sparkline(huge, 9), U"▁█");
  EXPECT_EQ(sparkline(std::vector<double>{2, 2}, 9), U"▁▁");
}

}  // namespace
}  // namespace marco::spy
