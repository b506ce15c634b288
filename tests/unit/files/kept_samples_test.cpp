// A recording that is read several times and opened once.
#include "recordings/kept_samples.hpp"

#include <gmock/gmock.h>

#include <stdexcept>

namespace marco {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr std::size_t kPlenty = 1'000'000;
constexpr int kSamples = 60;

// Scans, odometry and a gyroscope's rates in turn, each with its number as its stamp.
class Counting : public files::SampleReader {
 public:
  std::optional<Sample> next() override {
    if (next_ == kSamples) {
      report_.given["samples"] = kSamples;
      return std::nullopt;
    }
    const int number = next_++;
    if (number % 3 == 0) {
      LaserScan scan;
      scan.utime = Utime{number};
      scan.ranges_m.assign(10, static_cast<float>(number));
      return scan;
    }
    if (number % 3 == 1) return OdometrySample{Utime{number}, {0.1 * number, 0.0, 0.0}};
    return ImuSample{Utime{number}};
  }
  const files::InputReport& report() const override { return report_; }
  double progress() const override { return static_cast<double>(next_) / kSamples; }

 private:
  int next_ = 0;
  files::InputReport report_;
};

class Kept : public ::testing::Test {
 protected:
  KeptSamples kept(std::size_t most_bytes) {
    return {[this] {
              ++opened_;
              return std::make_unique<Counting>();
            },
            most_bytes};
  }
  // The stamps of the samples up to the end, or of as many. Contents that belong to another stamp
  // give -1.
  static std::vector<int64_t> read(KeptSamples& samples, int most = kSamples + 1) {
    std::vector<int64_t> stamps;
    while (static_cast<int>(stamps.size()) < most) {
      const auto sample = samples.next();
      if (!sample) break;
      int64_t stamp = std::visit([](const auto& value) { return value.utime.us; }, *sample);
      const auto number = static_cast<double>(stamp);
      if (const auto* scan = std::get_if<LaserScan>(&*sample)) {
        if (scan->ranges_m != std::vector<float>(10, static_cast<float>(number))) stamp = -1;
      }
      if (const auto* odometry = std::get_if<OdometrySample>(&*sample)) {
        if (odometry->odom_from_robot.x_m != 0.1 * number) stamp = -1;
      }
      stamps.push_back(stamp);
    }
    return stamps;
  }
  static std::vector<int64_t> first(int count) {
    std::vector<int64_t> stamps;
    for (int i = 0; i < count; ++i) stamps.push_back(i);
    return stamps;
  }

  int opened_ = 0;
};

TEST_F(Kept, IsOpenedOnceHoweverOftenItIsRead) {
  KeptSamples samples = kept(kPlenty);
  EXPECT_EQ(opened_, 0);
  for (int pass = 0; pass < 3; ++pass) {
    EXPECT_EQ(read(samples), first(kSamples));
    EXPECT_FALSE(samples.next().has_value());
    EXPECT_EQ(samples.report().given.at("samples"), kSamples);
    samples.rewind();
  }
  EXPECT_EQ(opened_, 1);
}

TEST_F(Kept, APassThatStopsEarlyLeavesTheRestToTheNext) {
  KeptSamples samples = kept(kPlenty);
  EXPECT_EQ(read(samples, 7), first(7));
  samples.rewind();
  EXPECT_EQ(read(samples, 4), first(4));
  EXPECT_LT(samples.progress(), 0.08);  // of what was read, 4 of 7
  samples.rewind();
  EXPECT_EQ(read(samples), first(kSamples));
  EXPECT_EQ(samples.progress(), 1.0);
  EXPECT_EQ(opened_, 1);
}

TEST_F(Kept, ALargeOneIsOpenedForEachPassAndTheReportSaysSo) {
  KeptSamples samples = kept(2000);
  EXPECT_EQ(read(samples), first(kSamples));
  EXPECT_THAT(samples.report().notes, ElementsAre(HasSubstr("it is read from the disk")));
  samples.rewind();
  EXPECT_EQ(read(samples), first(kSamples));
  EXPECT_EQ(opened_, 2);
}

TEST_F(Kept, ALargeOneThatWasReadInPartBeginsAnew) {
  KeptSamples samples = kept(2000);
  EXPECT_EQ(read(samples, 40), first(40));
  samples.rewind();
  EXPECT_EQ(read(samples), first(kSamples));
  EXPECT_EQ(opened_, 2);
}

TEST_F(Kept, AfterTheLastPassThereIsNoOther) {
  KeptSamples samples = kept(kPlenty);
  read(samples, 7);
  samples.rewind_for_the_last_time();
  EXPECT_EQ(read(samples), first(kSamples));
  EXPECT_FALSE(samples.next().has_value());
  EXPECT_THAT(samples.report().notes, IsEmpty());
  EXPECT_EQ(opened_, 1);
  EXPECT_THROW(samples.rewind(), std::logic_error);
}

}  // namespace
}  // namespace marco
