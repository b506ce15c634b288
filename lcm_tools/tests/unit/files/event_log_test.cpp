#include "lcm_tools/files/event_log.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <random>

#include "lcm_tools/files/whole_file.hpp"

namespace marco::files {
namespace {

namespace fs = std::filesystem;

class EventLog : public ::testing::Test {
 protected:
  EventLog() : path_(fs::temp_directory_path() / ("marco_event_log_" + std::to_string(getpid()))) {}
  ~EventLog() override { fs::remove(path_); }

  // Events of `size` bytes each, contents = its number.
  void write(int count, std::size_t size) {
    EventLogWriter writer(path_);
    for (int i = 0; i < count; ++i) {
      const std::vector<uint8_t> bytes(size, static_cast<uint8_t>(i));
      writer.write("CHANNEL_" + std::to_string(i % 3), bytes, Utime::from_us(1000 * i));
    }
  }
  std::vector<int64_t> numbers(LogDamage* damage = nullptr) {
    EventLogReader reader(path_);
    std::vector<int64_t> result;
    while (const auto event = reader.next()) result.push_back(event->number);
    if (damage != nullptr) *damage = reader.damage();
    return result;
  }
  void overwrite(int64_t offset, char value) {
    std::fstream file(path_, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(offset);
    file.put(value);
  }

  fs::path path_;
};

constexpr int64_t kEventBytes = 28 + 9 + 100;

TEST_F(EventLog, ReadsBackWhatItWrote) {
  write(5, 100);
  EXPECT_EQ(fs::file_size(path_), 5U * kEventBytes);
  EventLogReader reader(path_);
  for (int i = 0; i < 5; ++i) {
    const auto event = reader.next();
    ASSERT_TRUE(event);
    EXPECT_EQ(event->number, i);
    EXPECT_EQ(event->event_time.us, 1000 * i);
    EXPECT_EQ(event->channel, "CHANNEL_" + std::to_string(i % 3));
    EXPECT_EQ(event->bytes, std::vector<uint8_t>(100, static_cast<uint8_t>(i)));
  }
  EXPECT_FALSE(reader.next());
  EXPECT_EQ(reader.damage().places, 0);
}

TEST_F(EventLog, GoesOnBehindADamagedSyncWordAndADamagedLength) {
  write(6, 100);
  overwrite(1 * kEventBytes, 'x');          // sync of event 1
  overwrite(3 * kEventBytes + 24, '\x01');  // length of event 3 beyond the file
  overwrite(4 * kEventBytes + 27, '\x70');  // length of event 4 too long, still inside the file
  LogDamage damage;
  EXPECT_THAT(numbers(&damage), ::testing::ElementsAre(0, 2, 5));
  EXPECT_EQ(damage.places, 2);
  EXPECT_EQ(damage.bytes_skipped, 3 * kEventBytes);
  EXPECT_EQ(damage.first_offset, kEventBytes);
}

TEST_F(EventLog, ALogCutInsideAnEventKeepsAllBeforeIt) {
  write(4, 100);
  fs::resize_file(path_, 3 * kEventBytes + 60);
  LogDamage damage;
  EXPECT_THAT(numbers(&damage), ::testing::ElementsAre(0, 1, 2));
  EXPECT_EQ(damage.bytes_skipped, 60);
}

TEST_F(EventLog, ASyncWordInsideTheDataIsNotAnEvent) {
  {
    EventLogWriter writer(path_);
    std::vector<uint8_t> bytes(64, 0);
    bytes[10] = 0xED;
    bytes[11] = 0xA1;
    bytes[12] = 0xDA;
    bytes[13] = 0x01;
    for (int i = 0; i < 3; ++i) writer.write("A", bytes, {});
  }
  overwrite(0, 'x');
  EXPECT_THAT(numbers(), ::testing::ElementsAre(1, 2));
}

// No logger writes control characters or spaces into a channel's name: the event is damaged.
TEST_F(EventLog, AnEventOnAnUnprintableChannelIsDamage) {
  for (const char wrong : {'\x07', ' ', '\x7F', '\xE4'}) {
    write(3, 100);
    overwrite(1 * kEventBytes + 28 + 2, wrong);
    LogDamage damage;
    EXPECT_THAT(numbers(&damage), ::testing::ElementsAre(0, 2)) << static_cast<int>(wrong);
    EXPECT_EQ(damage.bytes_skipped, kEventBytes);
  }
}

// The search for the next event reads blocks of 128 kB; its sync word may lie across two of them.
TEST_F(EventLog, ASyncWordAcrossTwoBlocksOfTheSearchIsFound) {
  constexpr int64_t kSearchBytes = 128 << 10;
  for (int64_t shift = -5; shift <= 5; ++shift) {
    const int64_t second = 1 + kSearchBytes + shift;  // the search begins at byte 1
    {
      EventLogWriter writer(path_);
      const auto size = static_cast<std::size_t>(second - 28 - 1);
      writer.write("A", std::vector<uint8_t>(size, 0), {});
      writer.write("B", std::vector<uint8_t>(10, 0), {});
    }
    overwrite(0, 'x');
    LogDamage damage;
    EXPECT_THAT(numbers(&damage), ::testing::ElementsAre(1)) << shift;
    EXPECT_EQ(damage.bytes_skipped, second) << shift;
  }
}

TEST_F(EventLog, HeadsTellTheSameAsEventsAlsoOverLargeData) {
  {
    EventLogWriter writer(path_);
    std::mt19937 random(4);
    for (int i = 0; i < 200; ++i) {
      // Some larger than the reader's window of 256 kB.
      const std::size_t size = i % 50 == 7 ? 600000 + random() % 1000 : random() % 4000;
      std::vector<uint8_t> bytes(size);
      for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(random());
      writer.write("C" + std::to_string(random() % 3), bytes, Utime::from_us(i));
    }
  }
  EventLogReader events(path_), heads(path_), both(path_);
  int count = 0;
  while (const auto event = events.next()) {
    ++count;
    const auto head = heads.next_head();
    ASSERT_TRUE(head);
    EXPECT_EQ(head->number, event->number);
    EXPECT_EQ(head->event_time, event->event_time);
    EXPECT_EQ(head->channel, event->channel);
    ASSERT_EQ(head->data_bytes, static_cast<int64_t>(event->bytes.size()));
    EXPECT_TRUE(
        std::equal(head->first_bytes.begin(), head->first_bytes.end(), event->bytes.begin()));
    EXPECT_EQ(heads.position_bytes(), events.position_bytes());
    both.next_head();
    EXPECT_TRUE(std::ranges::equal(both.data(), event->bytes));
  }
  EXPECT_EQ(count, 200);
  EXPECT_FALSE(heads.next_head());
}

TEST_F(EventLog, SeekFindsTheFirstEventBehindAnyByte) {
  write(6, 100);
  EventLogReader reader(path_);
  for (int64_t offset = 0; offset <= 6 * kEventBytes; offset += 23) {
    reader.seek(offset);
    const auto event = reader.next();
    const int64_t expected = (offset + kEventBytes - 1) / kEventBytes;
    ASSERT_EQ(event.has_value(), expected < 6) << offset;
    if (event) {
      EXPECT_EQ(event->number, expected) << offset;
    }
  }
  EXPECT_EQ(reader.damage().places, 0);
}

TEST_F(EventLog, AnyBytesAreReadToTheEndWithoutACrash) {
  std::mt19937 random(11);
  for (int round = 0; round < 200; ++round) {
    write(8, 40);
    for (int flips = 0; flips < 20; ++flips) {
      overwrite(random() % (8 * 77), static_cast<char>(random()));
    }
    EventLogReader reader(path_);
    int64_t bytes = 0;
    while (const auto event = reader.next()) {
      bytes += 28 + static_cast<int64_t>(event->channel.size() + event->bytes.size());
    }
    // Every byte belongs to an event or to the damage.
    EXPECT_EQ(bytes + reader.damage().bytes_skipped, reader.size_bytes());
  }
}

TEST_F(EventLog, NoFileOrAFolderIsRefusedByName) {
  EXPECT_THROW(EventLogReader("/no/such/log"), std::invalid_argument);
  EXPECT_THROW(EventLogReader("/tmp"), std::invalid_argument);
  EXPECT_THROW(EventLogWriter("/no/such/folder/log"), std::runtime_error);
}

TEST_F(EventLog, AFullDiskIsSaid) {
  EventLogWriter writer("/dev/full");
  const std::vector<uint8_t> bytes(100000, 1);
  EXPECT_THROW(
      {
        writer.write("A", bytes, {});
        writer.flush();
      },
      std::runtime_error);
}

// Larger than could be read in an hour.
TEST_F(EventLog, GoesOnBehindAHoleAndSaysHowFarItSearched) {
  write(1, 100);
  const std::string event = read_whole_file(path_);
  constexpr uint64_t kHole = uint64_t{200} << 30U;
  fs::resize_file(path_, kHole);
  std::ofstream(path_, std::ios::app) << event;
  EventLogReader reader(path_);
  std::vector<int64_t> reached;
  reader.on_search([&](int64_t at) { reached.push_back(at); });
  EXPECT_TRUE(reader.next());
  EXPECT_TRUE(reader.next());
  EXPECT_FALSE(reader.next());
  EXPECT_EQ(reader.damage().places, 1);
  ASSERT_FALSE(reached.empty());
  EXPECT_GE(reached.back() + 4096, static_cast<int64_t>(kHole));
}

}  // namespace
}  // namespace marco::files
