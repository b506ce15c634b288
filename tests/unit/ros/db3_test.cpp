#include "recordings/ros/db3_source.hpp"

#include <gmock/gmock.h>
#include <sqlite3.h>
#include <zstd.h>

#include <memory>
#include <string>
#include <vector>

#include "lcm_tools/tests/support/temporary_folder.hpp"
#include "recordings/ros/open_messages.hpp"

namespace marco::ros {
namespace {

using ::marco::testing::TemporaryFolder;
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
  write_database(path, kTables + insert(1, 1, 30, "three") + insert(2, 2, 10, "one") +
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
  }
  EXPECT_TRUE(std::filesystem::is_empty(temporary));
  unsetenv("TMPDIR");
}

TEST(Db3, RefusesOtherDatabases) {
  const TemporaryFolder folder;
  write_database(folder.path() / "a.db3", "CREATE TABLE other(id INTEGER);");
  EXPECT_THAT(
      [&] { open_db3(folder.path() / "a.db3"); },
      ::testing::ThrowsMessage<std::invalid_argument>(HasSubstr("no recording of rosbag2")));
}

}  // namespace
}  // namespace marco::ros
