#include "lcm_tools/log/moment.hpp"

#include <gtest/gtest.h>

#include "lcm_tools/tests/unit/log/tiny_log.hpp"

namespace marco::logs {
namespace {

TEST(Moment, IsUnderstoodAsPeopleWriteIt) {
  const LogSpan span{Utime::from_us(kStartUs), Utime::from_us(kStartUs + 100'000'000)};
  const auto offset_s = [&](const char* text) {
    return (parse_moment(text).in(span)-span.first).seconds();
  };
  EXPECT_DOUBLE_EQ(offset_s("12.5"), 12.5);
  EXPECT_DOUBLE_EQ(offset_s("1:30"), 90.0);
  EXPECT_DOUBLE_EQ(offset_s("1:02:03.5"), 3723.5);
  EXPECT_DOUBLE_EQ(offset_s("-10"), 90.0);
  EXPECT_DOUBLE_EQ(offset_s("@1454600007.25"), 7.25);
  EXPECT_DOUBLE_EQ(offset_s("2016-02-04T15:33:21.5Z"), 1.5);
  for (const char* wrong : {"", "x", "1:2:3:4", "1e99", "nan", "-", "@", "2016-02-04", "12s",
                            "2016-02-04T15:33:21", "1:-2"}) {
    EXPECT_THROW(parse_moment(wrong), std::invalid_argument) << wrong;
  }
}

TEST(Moment, ItsTextReadsBack) {
  for (const int64_t us : {int64_t{0}, kStartUs + 1, int64_t{-1}, int64_t{253402300799999999}}) {
    const Utime time = Utime::from_us(us);
    // parse_moment goes through double seconds: 1 us is kept below 2^53 us.
    EXPECT_EQ(parse_moment(to_text(time)).in({}).us, us) << to_text(time);
  }
  EXPECT_EQ(to_text(Utime::from_us(kStartUs)), "2016-02-04T15:33:20.000000Z");
  EXPECT_EQ(to_text(Utime::from_us(INT64_MAX)).front(), '@');
}

TEST(Moment, ARangeThatHoldsNothingIsRefused) {
  const LogSpan span{Utime::from_us(kStartUs), Utime::from_us(kStartUs + 100'000'000)};
  EXPECT_THROW(parse_range("20", "10", span), std::invalid_argument);
  const TimeRange open = parse_range("", "", span);
  EXPECT_TRUE(open.contains(span.first) && open.contains(span.last));
  const TimeRange range = parse_range("10", "20", span);
  EXPECT_TRUE(range.contains(span.first + Duration::from_seconds(10)));
  EXPECT_FALSE(range.contains(span.first + Duration::from_seconds(20)));
}

TEST(Moment, TheSpanIsThatOfTheEndsAlsoBehindDamage) {
  const ScratchFolder folder;
  write_poses(folder / "log", 50);
  {
    files::EventLogReader reader(folder / "log");
    const LogSpan span = find_span(reader);
    EXPECT_EQ(span.first.us, kStartUs);
    EXPECT_EQ(span.last.us, kStartUs + 4'900'000);
    EXPECT_EQ(reader.next()->event_time.us, kStartUs);  // stands at the beginning again
  }
  // Damage at the end larger than the first look back.
  write_text(folder / "long", read_text(folder / "log") + std::string(300000, 'x'));
  files::EventLogReader damaged(folder / "long");
  EXPECT_EQ(find_span(damaged).last.us, kStartUs + 4'900'000);
  write_text(folder / "none", "no log at all");
  files::EventLogReader none(folder / "none");
  EXPECT_THROW(find_span(none), std::invalid_argument);
}

}  // namespace
}  // namespace marco::logs
