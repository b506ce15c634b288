#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include <filesystem>
#include <fstream>
#include <random>

#include "lcm_tools/process/state_folder.hpp"
#include "lcm_tools/procman/output_log.hpp"
#include "lcm_tools/procman/process/deputy_line.hpp"
#include "lcm_tools/procman/process/deputy_process.hpp"
#include "lcm_tools/procman/process/keeper_message.hpp"
#include "lcm_tools/procman/process/message_check.hpp"
#include "lcm_tools/procman/process/messages.hpp"
#include "lcm_tools/procman/process/output_pump.hpp"
#include "lcm_tools/procman/utf8.hpp"
#include "procman_lcm/discovery_t.hpp"
#include "procman_lcm/output_span_t.hpp"
#include "procman_lcm/output_t.hpp"

namespace marco::procman {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Pair;

TEST(Utf8Cleaner, KeepsWhatIsValidAndReplacesTheRest) {
  Utf8Cleaner cleaner;
  EXPECT_EQ(cleaner.clean("a\xc3\xa4\xe2\x82\xac\xf0\x9f\x98\x80"),
            "a\xc3\xa4\xe2\x82\xac\xf0\x9f\x98\x80");
  EXPECT_EQ(cleaner.clean(std::string_view("x\0y", 3)), "x\xef\xbf\xbdy");
  EXPECT_EQ(cleaner.clean("\xff\xc0\x80"), "\xef\xbf\xbd\xef\xbf\xbd\xef\xbf\xbd");
  EXPECT_EQ(cleaner.clean("\xed\xa0\x80"), "\xef\xbf\xbd\xef\xbf\xbd\xef\xbf\xbd") << "a surrogate";
}

TEST(Utf8Cleaner, ACharacterMayComeInPieces) {
  Utf8Cleaner cleaner;
  EXPECT_EQ(cleaner.clean("\xe2\x82"), "");
  EXPECT_EQ(cleaner.clean("\xac."), "\xe2\x82\xac.");
  EXPECT_EQ(cleaner.clean("\xf0\x9f"), "");
  EXPECT_EQ(cleaner.flush(), "\xef\xbf\xbd\xef\xbf\xbd");
}

TEST(Utf8Cleaner, HowTheBytesAreCutDoesNotMatter) {
  std::mt19937 random(3);
  for (int round = 0; round < 300; ++round) {
    std::string bytes;
    for (int i = 0; i < 40; ++i) bytes += static_cast<char>(random() % 2 ? random() : 0xc3 + i % 4);
    Utf8Cleaner whole;
    Utf8Cleaner pieces;
    std::string expected = whole.clean(bytes);
    expected += whole.flush();
    std::string out;
    for (std::size_t at = 0; at < bytes.size();) {
      const std::size_t size = 1 + random() % 5;
      out += pieces.clean(std::string_view(bytes).substr(at, size));
      at += size;
    }
    ASSERT_EQ(out + pieces.flush(), expected);
  }
}

TEST(KeeperMessage, ComesBackWhateverItsTexts) {
  KeeperMessage message;
  message.kind = "run";
  message.spec = {"id \n\\n", "exec \\ \n x", "a/b", true, 15, 2.5};
  message.runid = -7;
  message.allowed_s = 0.001;
  message.output_end = int64_t{1} << 40;
  EXPECT_EQ(decode_keeper_message(encode(message)), message);
  const std::string bytes = encode(message);
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_EQ(decode_keeper_message(bytes.substr(0, size)), std::nullopt);
  }
}

// An update of the deputy finds the keepers that the one before started.
TEST(KeeperMessage, AKeeperOfBeforeHeartbeatsIsUnderstood) {
  KeeperMessage message;
  message.cause = "said";
  std::string bytes = encode(message);
  EXPECT_EQ(decode_keeper_message(bytes), message);
  bytes.erase(bytes.find("cause said\n"), 11);
  message.cause.clear();
  EXPECT_EQ(decode_keeper_message(bytes), message);
}

template <class Message>
std::vector<uint8_t> bytes_of(const Message& message) {
  std::vector<uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

/// Good as it is; with flipped and cut bytes either refused or decoded to the last byte.
template <class Message>
void check_hostile(const Message& message, const char* layout) {
  const std::vector<uint8_t> good = bytes_of(message);
  ASSERT_TRUE(is_well_formed(good, layout));
  std::mt19937 random(5);
  int refused = 0;
  for (int round = 0; round < 3000; ++round) {
    std::vector<uint8_t> bad = good;
    bad[8 + random() % (bad.size() - 8)] ^= static_cast<uint8_t>(1U << random() % 8);
    if (round % 3 == 0) bad.resize(random() % bad.size());
    Message decoded;
    if (!is_well_formed(bad, layout)) {
      ++refused;
    } else {
      EXPECT_EQ(decoded.decode(bad.data(), 0, static_cast<int>(bad.size())),
                static_cast<int>(bad.size()));
    }
  }
  EXPECT_GT(refused, 1000);
}

TEST(MessageCheck, HostileLengthsAreRefusedBeforeDecoding) {
  const CommandSpec spec = {"lidar", "lidar --fast", "drivers", true, 15, 3.0};
  check_hostile(to_message(Orders{1, "base", "sheriff", {{spec, 1, false}, {spec, 2, true}}}),
                layouts::kOrders);
  check_hostile(to_message(DeputyInfo{1, "base", {}, {{spec, 1, 2, 3, 0.5, 4, 5}}}),
                layouts::kInfo);
  procman_lcm::output_t output;
  output.num_commands = 2;
  output.command_ids = {"a", "b"};
  output.text = {"one", ""};
  check_hostile(output, layouts::kOutput);
  procman_lcm::output_span_t span;
  span.num_commands = 1;
  span.command_ids = {"a"};
  span.first_bytes = {1};
  span.end_bytes = {2};
  span.files = {"/f"};
  check_hostile(span, layouts::kOutputSpan);
  procman_lcm::discovery_t question;
  question.transmitter_id = "base";
  EXPECT_TRUE(is_well_formed(bytes_of(question), layouts::kDiscover));
}

// Length and last byte of a string must agree: lcm-gen's decoder would read on to any length.
TEST(MessageCheck, AStringEndsWithAZero) {
  procman_lcm::discovery_t question;
  question.transmitter_id = "base";
  const std::vector<uint8_t> good = bytes_of(question);
  const std::size_t zero = 8 + 8 + 4 + 4;
  ASSERT_EQ(good.at(zero), 0);
  std::vector<uint8_t> bad = good;
  bad[zero] = 'x';
  EXPECT_FALSE(is_well_formed(bad, layouts::kDiscover));
  bad = good;
  bad[zero - 5] = 0;  // its length: a string has one byte at least
  EXPECT_FALSE(is_well_formed(bad, layouts::kDiscover));
}

TEST(PeerOf, TellsTheUserAtTheOtherEnd) {
  int ends[2] = {-1, -1};
  ASSERT_EQ(socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends), 0);
  const Descriptor one(ends[0]);
  const Descriptor other(ends[1]);
  EXPECT_EQ(peer_of(one), getuid());
  EXPECT_EQ(peer_of(Descriptor()), std::nullopt);
}

// Whoever can reach the socket could otherwise stop the command and take its output.
TEST(DeputyLine, ACallOfAnotherUserIsIgnored) {
  if (getuid() != 0) GTEST_SKIP() << "only root can become another user";
  char folder[] = "/tmp/marco-deputy-line-XXXXXX";
  ASSERT_NE(mkdtemp(folder), nullptr);
  const std::string path = std::string(folder) + "/keeper.sock";
  int ends[2] = {-1, -1};
  ASSERT_EQ(socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends), 0);
  const Descriptor deputy(ends[1]);
  DeputyLine line{Descriptor(ends[0]), path};
  line.listen();
  chmod(folder, 0755);
  chmod(path.c_str(), 0777);
  const auto call = [&path] {
    const auto address = socket_address(path);
    Descriptor caller(socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0));
    return connect(caller.get(), reinterpret_cast<const sockaddr*>(&*address), sizeof *address);
  };
  const pid_t stranger = fork();
  constexpr int kNoOtherUser = 77;
  if (stranger == 0) _exit(setuid(65534) != 0 ? kNoOtherUser : call() == 0 ? 0 : 1);
  int status = -1;
  ASSERT_EQ(waitpid(stranger, &status, 0), stranger);
  if (WEXITSTATUS(status) == kNoOtherUser) GTEST_SKIP() << "this namespace has no other user";
  ASSERT_EQ(status, 0) << "the stranger's call went through";
  const int before = line.fd();
  EXPECT_FALSE(line.accept());
  EXPECT_EQ(line.fd(), before);
  ASSERT_EQ(call(), 0);
  EXPECT_TRUE(line.accept());
  EXPECT_NE(line.fd(), before);
  std::filesystem::remove_all(folder);
}

// Anybody on the network can send output: nothing of it may fill the memory.
TEST(OutputLog, IsBoundedWhateverComes) {
  OutputLog log;
  std::size_t most = 0;
  const auto hear = [&](const std::string& id, const std::string& text) {
    log.on_output("d", 0, {id}, {text});
    most = std::max(most, log.bytes());
  };
  const std::string megabyte(1 << 20, 'x');
  for (int i = 0; i < 8; ++i) hear("one", megabyte);
  EXPECT_LE(most, OutputLog::kMaxCommandBytes + megabyte.size()) << "no line ends in it";
  EXPECT_LE(log.lines("one").front().size(), OutputLog::kMaxLineBytes);
  for (int i = 0; i < 100; ++i) hear("command " + std::to_string(i), megabyte);
  EXPECT_LE(most, OutputLog::kMaxBytes + megabyte.size());
  EXPECT_THAT(log.lines("command 99"), testing::Not(IsEmpty())) << "the newest is there";
  for (int i = 0; i < 2; ++i) hear("many", std::string(1 << 20, '\n'));
  EXPECT_LE(log.lines("many").size(), 5000U);
  hear(megabyte, "an id of a megabyte");
  EXPECT_THAT(log.lines(megabyte), IsEmpty());
}

TEST(FileName, NoCommandLeavesTheFolderOrSharesAFile) {
  EXPECT_EQ(process::file_name_of("lidar-2_a.b"), "lidar-2_a.b");
  EXPECT_EQ(process::file_name_of("../etc"), "%2E.%2Fetc");
  EXPECT_EQ(process::file_name_of("a b"), "a%20b");
  const std::string long_name(300, 'x');
  EXPECT_LT(process::file_name_of(long_name).size(), 230U);
  EXPECT_NE(process::file_name_of(long_name + "1"), process::file_name_of(long_name + "2"));
}

TEST(OutputLog, JoinsPiecesToLines) {
  OutputLog log(3);
  EXPECT_THAT(log.on_output("d", 1, {"a"}, {"on"}), IsEmpty());
  EXPECT_THAT(log.on_output("d", 2, {"a", "b"}, {"e\r\ntwo\nthr", "x\n"}),
              ElementsAre(Pair("a", "one"), Pair("a", "two"), Pair("b", "x")));
  EXPECT_THAT(log.lines("a"), ElementsAre("one", "two", "thr"));
  log.on_output("d", 3, {"a"}, {"ee\nfour\n"});
  EXPECT_THAT(log.lines("a"), ElementsAre("three", "four", "")) << "the last three";
}

TEST(OutputLog, ALostMessageLeavesALineThatSaysSo) {
  OutputLog log(100);
  log.on_span("d", 1, {{"a", 0, 10, "/logs/a"}});
  log.on_output("d", 1, {"a"}, {"123456789\n"});
  log.on_span("d", 2, {{"a", 10, 30, "/logs/a"}});  // its output is lost
  log.on_span("d", 3, {{"a", 30, 32, "/logs/a"}});
  log.on_output("d", 3, {"a"}, {"x\n"});
  EXPECT_THAT(log.lines("a"),
              ElementsAre("123456789", "",
                          "[20 bytes lost in transit; all output is in /logs/a of d]", "x", ""));
  EXPECT_EQ(log.lost_bytes(), 20);
}

TEST(OutputLog, ALostSpanIsNoLostOutput) {
  OutputLog log(100);
  log.on_span("d", 1, {{"a", 0, 2, "/logs/a"}});
  log.on_output("d", 1, {"a"}, {"1\n"});
  log.on_output("d", 2, {"a"}, {"2\n"});  // its span is lost
  log.on_span("d", 3, {{"a", 4, 6, "/logs/a"}});
  log.on_output("d", 3, {"a"}, {"3\n"});
  EXPECT_THAT(log.lines("a"), ElementsAre("1", "2", "3", ""));
  EXPECT_EQ(log.lost_bytes(), 0);
}

TEST(Printable, LeavesOutControlSequences) {
  EXPECT_EQ(printable("\x1b[1;31mred\x1b[0m\ttab\x07"), "red  tab");
  EXPECT_EQ(printable("10 %\r100 %"), "100 %");
  EXPECT_EQ(printable("end\x1b["), "end");
}

/// A file that grows, in a folder of its own.
class OutputPumpTest : public testing::Test {
 protected:
  OutputPumpTest() {
    folder_ = testing::TempDir() + "output_pump_test";
    std::filesystem::create_directories(folder_);
    path_ = folder_ + "/a.log";
    std::filesystem::remove(path_);
  }
  ~OutputPumpTest() override { std::filesystem::remove_all(folder_); }

  int64_t write(const std::string& text) {
    std::ofstream(path_, std::ios::app) << text;
    return static_cast<int64_t>(std::filesystem::file_size(path_));
  }

  std::string folder_;
  std::string path_;
};

TEST_F(OutputPumpTest, HandsOutWhatIsNewWithItsPlaceInTheFile) {
  OutputPump pump(1e6);
  EXPECT_EQ(pump.next_due_us(), std::nullopt);
  const int64_t old_end = write("old");
  pump.open_run("a", path_, old_end);
  pump.on_growth("a", write("new\n"));
  const auto pieces = pump.take(0);
  ASSERT_EQ(pieces.size(), 1U);
  EXPECT_EQ(pieces[0].text, "new\n");
  EXPECT_EQ(pieces[0].first_byte, 3);
  EXPECT_EQ(pieces[0].end_byte, 7);
  EXPECT_EQ(pump.shown("a").bytes, 7);
  EXPECT_EQ(pump.next_due_us(), std::nullopt);
}

TEST_F(OutputPumpTest, KeepsThePaceAndLosesNothing) {
  OutputPump pump(1e6);
  pump.open_run("a", (write(""), path_), 0);
  std::string all;
  for (int i = 0; i < 30000; ++i) all += std::to_string(i) + "\n";
  pump.on_growth("a", write(all));
  std::string got;
  int64_t now_us = 0;
  while (pump.next_due_us()) {
    now_us = *pump.next_due_us();
    for (const OutputPiece& piece : pump.take(now_us)) got += piece.text;
    EXPECT_THAT(pump.take(now_us), IsEmpty()) << "not before its time";
  }
  EXPECT_EQ(got, all);
  // 16 kB a message: all but the last message's time has passed at 1 MB/s.
  EXPECT_GE(now_us, static_cast<int64_t>(all.size()) - 16384);
}

TEST_F(OutputPumpTest, ALineOfTheDeputysStandsWhereItHappened) {
  OutputPump pump(1e9);
  pump.open_run("a", (write(""), path_), 0);
  pump.on_growth("a", write("one\n"));
  pump.tell("a", "Killed");
  pump.open_run("a", path_, 4);
  pump.on_growth("a", write("two\n"));
  std::string got;
  while (pump.next_due_us()) got += pump.take(*pump.next_due_us()).at(0).text;
  EXPECT_EQ(got, "one\nKilled\ntwo\n");
}

TEST_F(OutputPumpTest, ALineOfTheDeputysDoesNotEndARunsOutput) {
  OutputPump pump(1e9);
  pump.open_run("a", (write(""), path_), 0);
  pump.tell("a", "kept running");
  EXPECT_EQ(pump.take(0).at(0).text, "kept running\n");
  pump.on_growth("a", write("more\n"));
  EXPECT_EQ(pump.take(*pump.next_due_us()).at(0).text, "more\n");
}

// The keeper has begun a new file: the rest of the old one comes first, and no more of older ones.
TEST_F(OutputPumpTest, ANewFileFollowsTheOldOne) {
  OutputPump pump(1e9);
  const auto rotate = [&](const std::string& text) {
    std::filesystem::rename(path_, path_ + ".1");
    write(text);
    struct stat status = {};
    stat(path_.c_str(), &status);
    return static_cast<int64_t>(status.st_ino);
  };
  const auto take_all = [&] {
    std::string got;
    while (pump.next_due_us()) got += pump.take(*pump.next_due_us()).at(0).text;
    return got;
  };
  pump.open_run("a", (write(""), path_), 0);
  pump.on_growth("a", write("one\n"));
  write("two\n");  // that it grew was never heard
  const int64_t second = rotate("three\n");
  EXPECT_FALSE(pump.open_next_file("a", path_, second + 1)) << "not the file that is meant";
  ASSERT_TRUE(pump.open_next_file("a", path_, second));
  pump.on_growth("a", 6);
  EXPECT_EQ(take_all(), "one\ntwo\nthree\n");
  EXPECT_EQ(pump.shown("a").inode, second);
  pump.on_growth("a", write("four\n"));
  ASSERT_TRUE(pump.open_next_file("a", path_, rotate("five\n")));
  ASSERT_TRUE(pump.open_next_file("a", path_, rotate("six\n")));
  pump.on_growth("a", 4);
  EXPECT_EQ(take_all(), "\n[5 bytes left out: too much output]\nfive\nsix\n");
}

TEST_F(OutputPumpTest, CommandsTakeTurns) {
  OutputPump pump(1e9);
  pump.open_run("a", (write(""), path_), 0);
  pump.on_growth("a", write(std::string(100000, 'x')));
  pump.tell("b", "here");
  bool heard_b = false;
  for (int message = 0; message < 2; ++message) {
    for (const OutputPiece& piece : pump.take(*pump.next_due_us())) {
      heard_b = heard_b || piece.id == "b";
    }
  }
  EXPECT_TRUE(heard_b);
}

}  // namespace
}  // namespace marco::procman
