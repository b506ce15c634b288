#include "drivers/process/line_watch.hpp"

#include <gmock/gmock.h>

#include <cmath>

namespace marco::drivers {
namespace {

using ::testing::HasSubstr;
using Trouble = LineWatch::Trouble;

class Line : public ::testing::Test {
 protected:
  Line() {
    watch_.on_line({9600});
    watch_.judge(false, 0.0);
  }
  // Steps of 0.1 s; at each, `bytes` come.
  Trouble run(double seconds, const std::vector<uint8_t>& bytes = {}, bool answers = false) {
    Trouble trouble = Trouble::none;
    for (long left = std::lround(seconds * 10.0); left > 0; --left) {
      watch_.on_bytes(bytes);
      trouble = watch_.judge(answers, now_s_ += 0.1);
    }
    return trouble;
  }
  static std::vector<uint8_t> ascii(const std::string& text) { return {text.begin(), text.end()}; }

  LineWatch watch_{"/dev/ttyUSB0"};
  double now_s_ = 0.0;
};

TEST_F(Line, ThatCarriesNothingIsToldAfterThreeSeconds) {
  EXPECT_EQ(run(2.8), Trouble::none);
  EXPECT_EQ(watch_.text(), "");
  EXPECT_EQ(run(0.4), Trouble::silent);
  EXPECT_THAT(watch_.text(), HasSubstr("no bytes at all from /dev/ttyUSB0 at 9600 baud: is the "
                                       "device powered"));
  watch_.on_line({38400});
  EXPECT_THAT(watch_.text(), HasSubstr("at 9600, 38400 baud"));
  EXPECT_EQ(run(0.1, {1}), Trouble::none);
}

TEST_F(Line, OfADeviceThatAnswersIsNeverWrong) {
  EXPECT_EQ(run(60.0, {1, 2, 3}, true), Trouble::none);
  EXPECT_EQ(run(60.0, {}, true), Trouble::none) << "a device may have nothing to say";
  EXPECT_EQ(run(3.2), Trouble::silent) << "but when it does not answer any more";
}

TEST_F(Line, TimeInWhichTheProcessStoodStillIsNoSilence) {
  now_s_ += 60.0;
  EXPECT_EQ(watch_.judge(false, now_s_), Trouble::none);
}

TEST_F(Line, TextOfAGpsReceiverIsNamed) {
  const auto line = ascii("\r\n$GPGGA,123519,4807.038,N,01131.000,E*47\r\n");
  EXPECT_EQ(run(9.5, line), Trouble::none) << "a driver looks for the rate meanwhile";
  EXPECT_EQ(run(1.0, line), Trouble::garbled);
  EXPECT_THAT(watch_.text(), HasSubstr("bytes from /dev/ttyUSB0 at 9600 baud make no telegram: "
                                       "0d 0a 24 47 50 47 47 41"));
  EXPECT_THAT(watch_.text(), HasSubstr("text, `$GPGGA,123519,4807.038,N,01131.000,E*47`: a GPS"));
  EXPECT_EQ(run(0.1, line, true), Trouble::none);
}

TEST_F(Line, OtherTextAndOtherBytesAreToldApart) {
  run(11.0, ascii("hello world\n"));
  EXPECT_THAT(watch_.text(), HasSubstr("`hello world`: another device?"));
  run(0.1, {}, true);
  run(11.0, {0xff, 0x00, 0xff, 0xff});
  EXPECT_THAT(watch_.text(), HasSubstr("almost all 00 or ff: another baud rate"));
  run(0.1, {}, true);
  run(11.0, {0x81, 0x3c, 0xe0, 0x99});
  EXPECT_THAT(watch_.text(), HasSubstr("81 3c e0 99"));
  EXPECT_THAT(watch_.text(), HasSubstr("another baud rate, or another device?"));
}

TEST_F(Line, AFewBytesNowAndThenAreNotYetGarbage) {
  EXPECT_EQ(run(12.0), Trouble::silent);
  EXPECT_EQ(run(0.1, {1, 2, 3}), Trouble::none);
}

TEST(LineOverTcp, HasNoBaudRate) {
  LineWatch watch("tcp:robot:4001");
  watch.on_line({9600});
  for (int i = 0; i < 100; ++i) watch.judge(false, 0.1 * i);
  EXPECT_THAT(watch.text(), HasSubstr("no bytes at all from tcp:robot:4001: is the device behind"));
}

}  // namespace
}  // namespace marco::drivers
