#include "recordings/ros/file_sources.hpp"

#include <gmock/gmock.h>
#include <sqlite3.h>
#include <zstd.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "recordings/ros/open_messages.hpp"
#include "tests/fuzz/memory_file.hpp"

namespace marco::ros {
namespace {

using ::marco::testing::TemporaryFolder;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

void write_database(const std::filesystem::path& path, const std::string& statements) {
  sqlite3* raw = nullptr;
  ASSERT_EQ(sqlite3_open(path.c_str(), &raw), SQLITE_OK);
  const std::unique_ptr<sqlite3, decltype(&sqlite3_close)> database(raw, &sqlite3_close);
  ASSERT_EQ(sqlite3_exec(raw, statements.c_str(), nullptr, nullptr, nullptr), SQLITE_OK)
      << sqlite3_errmsg(raw);
}

// The tables of 2022.
const std::string kTables =
    "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT,"
    " offered_qos_profiles TEXT);"
    "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB);"
    "INSERT INTO topics VALUES(1,'/a','std_msgs/msg/String','cdr','durability: 1');"
    "INSERT INTO topics VALUES(2,'/b','std_msgs/msg/String','cdr','');";

std::string insert(int id, int topic, int at_ns, const std::string& text) {
  return "INSERT INTO messages VALUES(" + std::to_string(id) + "," + std::to_string(topic) + "," +
         std::to_string(at_ns) + ",CAST('" + text + "' AS BLOB));";
}

std::vector<std::string> contents(MessageSource& source) {
  std::vector<std::string> contents;
  while (const auto message = source.next()) {
    contents.emplace_back(message->bytes.begin(), message->bytes.end());
  }
  return contents;
}

TEST(Db3, GivesMessagesByTime) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "a #1%.db3";
  const std::string fast = "PRAGMA page_size=65536;PRAGMA synchronous=OFF;PRAGMA journal_mode=OFF;";
  write_database(path, fast + kTables + insert(1, 1, 30, "three") + insert(2, 2, 10, "one") +
                           insert(3, 1, 20, "two"));
  const auto source = open_db3(path);
  EXPECT_THAT(contents(*source), ElementsAre("one", "two", "three"));
  ASSERT_EQ(source->topics().size(), 2U);
  EXPECT_EQ(source->topics()[0]->type, "std_msgs/String");
  EXPECT_TRUE(source->topics()[0]->is_latched);
  EXPECT_FALSE(source->topics()[1]->is_latched);
  EXPECT_EQ(source->topics()[0]->messages, 2);
  source->select([](const Topic& topic) { return topic.name == "/b"; });
  EXPECT_THAT(contents(*source), ElementsAre("one"));
}

TEST(Db3, GivesDefinitionsWhereTheDatabaseHasThem) {
  const TemporaryFolder folder;
  write_database(folder.path() / "a.db3",
                 kTables +
                     "CREATE TABLE message_definitions(id INTEGER PRIMARY KEY, topic_type TEXT,"
                     " encoding TEXT, encoded_message_definition TEXT);"
                     "INSERT INTO message_definitions VALUES(1,'std_msgs/msg/String','ros2msg',"
                     "'string data');");
  const auto source = open_db3(folder.path() / "a.db3");
  EXPECT_EQ(source->topics()[0]->schema, "string data");
  EXPECT_EQ(source->topics()[0]->schema_encoding, "ros2msg");
}

// As rosbag2 makes them, with an index on the times.
void write_many(const std::filesystem::path& path, int messages) {
  std::string statements = kTables + "CREATE INDEX timestamp_idx ON messages(timestamp ASC);BEGIN;";
  for (int i = 1; i <= messages; ++i) {
    statements += insert(i, 1, 10 * i, std::to_string(i) + std::string(500, '.'));
  }
  write_database(path, statements + "COMMIT;");
}

// Of up to five pages, their times in another order than their rows: with the index the reading
// jumps from page to page, without it sqlite sorts.
TEST(Db3, MessagesOfAnySizeAreReadWholeInAnyOrder) {
  constexpr int kMessages = 1500;
  const TemporaryFolder folder;
  for (const char* index : {"CREATE INDEX timestamp_idx ON messages(timestamp ASC);", ""}) {
    std::mt19937 random(4);
    std::map<int, std::string> by_time;
    std::string statements = kTables + index + "BEGIN;";
    for (int i = 1; i <= kMessages; ++i) {
      const auto at_ns = static_cast<int>(random() >> 1U);
      const std::string text(random() % 20'000, static_cast<char>('a' + i % 26));
      by_time[at_ns] = std::to_string(i) + text;
      statements += insert(i, 1, at_ns, by_time[at_ns]);
    }
    const auto path = folder.path() / (*index == 0 ? "sorted.db3" : "indexed.db3");
    write_database(path, statements + "COMMIT;");
    const auto source = open_db3(path);
    const std::vector<std::string> found = contents(*source);
    ASSERT_EQ(found.size(), by_time.size());
    auto wanted = by_time.begin();
    for (const std::string& text : found) ASSERT_TRUE(text == (wanted++)->second) << index;
  }
}

// As fuzzers give it: its name leads to no file of a folder.
TEST(Db3, AFileInMemoryIsRead) {
  const TemporaryFolder folder;
  write_database(folder.path() / "a.db3", kTables + insert(1, 1, 10, "one"));
  std::ifstream in(folder.path() / "a.db3", std::ios::binary);
  const std::vector<uint8_t> bytes{std::istreambuf_iterator<char>(in), {}};
  const fuzz::MemoryFile file(bytes);
  EXPECT_THAT(contents(*open_db3(file.path())), ElementsAre("one"));
}

TEST(Db3, OfADatabaseThatIsCutOffTheRestIsRead) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "a.db3";
  constexpr int kMessages = 2000;
  write_many(path, kMessages);
  for (const double part : {0.98, 0.6, 0.3}) {
    const auto size = static_cast<double>(std::filesystem::file_size(path));
    std::filesystem::copy_file(path, folder.path() / "cut.db3",
                               std::filesystem::copy_options::overwrite_existing);
    std::filesystem::resize_file(folder.path() / "cut.db3", static_cast<uint64_t>(part * size));
    const auto source = open_db3(folder.path() / "cut.db3");
    for (int reading = 0; reading < 2; ++reading) {
      const auto found = contents(*source);
      EXPECT_GT(static_cast<double>(found.size()), (part - 0.1) * kMessages);
      EXPECT_LT(static_cast<double>(found.size()), kMessages);
      EXPECT_TRUE(found.front().starts_with("1."));
      EXPECT_TRUE(source->damage().is_cut_off);
      EXPECT_NEAR(static_cast<double>(source->damage().bytes), (1.0 - part) * size, 5000.0);
      source->rewind();
    }
    EXPECT_THAT(source->notes(), Contains(HasSubstr("the database is damaged")));
  }
}

TEST(Db3, PagesThatAreDamagedArePassedOver) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "a.db3";
  constexpr int kMessages = 2000;
  write_many(path, kMessages);
  {
    constexpr std::streamoff kPage = 4096;
    std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
    for (const std::streamoff page : {100, 101, 150}) {
      file.seekp(page * kPage);
      file.write(std::string(kPage, 'x').data(), kPage);
    }
  }
  const auto source = open_db3(path);
  const auto found = contents(*source);
  EXPECT_GT(found.size(), kMessages - 100U);
  EXPECT_LT(found.size(), kMessages);
  EXPECT_TRUE(found.back().starts_with("2000."));
  EXPECT_GE(source->damage().places, 1);
  EXPECT_FALSE(source->damage().is_cut_off);
}

TEST(Db3, PartsFollowEachOtherByTheirNumbers) {
  const TemporaryFolder folder;
  write_database(folder.path() / "run_2.db3", kTables + insert(1, 1, 20, "second"));
  write_database(folder.path() / "run_10.db3", kTables + insert(1, 1, 30, "third"));
  write_database(folder.path() / "run_0.db3", kTables + insert(1, 1, 10, "first"));
  folder.write("metadata.yaml", "rosbag2_bagfile_information:\n");
  const auto source = open_messages(folder.path());
  EXPECT_THAT(contents(*source), ElementsAre("first", "second", "third"));
  source->rewind();
  EXPECT_THAT(contents(*source), ElementsAre("first", "second", "third"));
}

TEST(Db3, IsReadFromAZstdFileAndLeavesNothingBehind) {
  const TemporaryFolder folder;
  write_database(folder.path() / "a.db3", kTables + insert(1, 1, 10, "one"));
  std::ifstream in(folder.path() / "a.db3", std::ios::binary);
  const std::string plain(std::istreambuf_iterator<char>(in), {});
  std::string packed(ZSTD_compressBound(plain.size()), '\0');
  packed.resize(ZSTD_compress(packed.data(), packed.size(), plain.data(), plain.size(), 3));
  const auto path = folder.write("a.db3.zstd", packed);
  const std::filesystem::path temporary = folder.path() / "tmp";
  std::filesystem::create_directory(temporary);
  setenv("TMPDIR", temporary.c_str(), 1);
  {
    const auto source = open_messages(path);
    EXPECT_THAT(contents(*source), ElementsAre("one"));
    EXPECT_THAT(source->format(), HasSubstr("zstd"));
    EXPECT_TRUE(std::filesystem::is_empty(temporary));
  }
  unsetenv("TMPDIR");
}

TEST(Db3, RefusesOtherDatabases) {
  const TemporaryFolder folder;
  write_database(folder.path() / "a.db3", "CREATE TABLE other(id INTEGER);");
  EXPECT_THAT(
      [&] { open_db3(folder.path() / "a.db3"); },
      ::testing::ThrowsMessage<std::invalid_argument>(HasSubstr("not a rosbag2 recording")));
}

// Rows that a database computes have no end, and no size that its file tells.
TEST(Db3, RefusesRowsThatAreComputed) {
  const TemporaryFolder folder;
  const std::string endless =
      " AS WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) SELECT i AS ";
  const std::string topics = kTables.substr(0, kTables.find("CREATE TABLE messages"));
  const std::string messages = kTables.substr(topics.size());
  const std::string with_view =
      topics + "CREATE VIEW messages" + endless +
      "id, 1 AS topic_id, i AS timestamp, zeroblob(1000000) AS data FROM n;";
  const std::string with_topics =
      messages.substr(0, messages.find("INSERT")) + "CREATE VIEW topics" + endless +
      "id, '/a' AS name, 'a/B' AS type, '' AS serialization_format, '' AS offered_qos_profiles "
      "FROM n;";
  const std::string generated =
      topics +
      "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data "
      "BLOB AS (zeroblob(900000000)));INSERT INTO messages(topic_id, timestamp) VALUES(1, 1);";
  const std::string with_module =
      topics + "CREATE VIRTUAL TABLE messages USING fts5(topic_id, timestamp, data);";
  const std::string with_definitions =
      kTables + "CREATE VIEW message_definitions" + endless +
      "topic_type, '' AS encoding, '' AS encoded_message_definition FROM n;";
  for (const std::string& statements :
       {with_view, with_topics, with_definitions, generated, with_module}) {
    std::filesystem::remove(folder.path() / "a.db3");
    write_database(folder.path() / "a.db3", statements);
    EXPECT_THAT([&] { open_db3(folder.path() / "a.db3"); },
                ::testing::ThrowsMessage<std::invalid_argument>(HasSubstr("not stored rows")))
        << statements;
  }
}

TEST(Db3, LeavesOutAMessageLargerThanAnyRecorderWrites) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "a.db3";
  const std::string fast = "PRAGMA page_size=65536;PRAGMA synchronous=OFF;PRAGMA journal_mode=OFF;";
  write_database(path, fast + kTables + insert(1, 1, 30, "three") + insert(2, 2, 10, "one") +
                           "INSERT INTO messages VALUES(3, 1, 20, zeroblob(" +
                           std::to_string(kMostMessageBytes + 1) + "));");
  const auto source = open_db3(path);
  EXPECT_THAT(contents(*source), ElementsAre("one", "three"));
  EXPECT_THAT(source->notes(), ElementsAre("messages of more than 256 MB are left out"));
}

}  // namespace
}  // namespace marco::ros
