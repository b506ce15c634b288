#include "recordings/ros/file_sources.hpp"

#include <fcntl.h>
#include <sqlite3.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "lcm_tools/base/check.hpp"
#include "lcm_tools/files/readable.hpp"
#include "recordings/ros/compression.hpp"
#include "recordings/ros/db3_pages.hpp"

namespace marco::ros {
namespace {

struct DatabaseCloser {
  void operator()(sqlite3* database) const { sqlite3_close(database); }
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};
using Database = std::unique_ptr<sqlite3, DatabaseCloser>;

// A statement whose rows are read one after the other.
class Rows {
 public:
  Rows(sqlite3* database, const std::string& query) {
    sqlite3_stmt* raw = nullptr;
    status_ = sqlite3_prepare_v2(database, query.c_str(), -1, &raw, nullptr);
    statement_.reset(raw);
  }
  bool is_valid() const { return statement_ != nullptr; }
  /// From the first row on, of what "?" is.
  void begin(int64_t value) {
    sqlite3_reset(statement_.get());
    sqlite3_bind_int64(statement_.get(), 1, value);
  }
  bool next() {
    if (statement_ == nullptr) return false;
    status_ = sqlite3_step(statement_.get());
    return status_ == SQLITE_ROW;
  }
  bool is_broken() const {
    return status_ != SQLITE_OK && status_ != SQLITE_ROW && status_ != SQLITE_DONE;
  }
  int64_t integer(int column) const { return sqlite3_column_int64(statement_.get(), column); }
  std::span<const uint8_t> blob(int column) const {
    const auto* data = static_cast<const uint8_t*>(sqlite3_column_blob(statement_.get(), column));
    return {data, static_cast<std::size_t>(sqlite3_column_bytes(statement_.get(), column))};
  }
  std::string text(int column) const {
    const auto bytes = blob(column);
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  }

 private:
  std::unique_ptr<sqlite3_stmt, DatabaseCloser> statement_;
  int status_ = SQLITE_OK;
};

// As sqlite's URIs want it.
std::string escaped(const std::string& path) {
  std::string uri;
  for (const char letter : path) {
    if (letter == '%')
      uri += "%25";
    else if (letter == '?')
      uri += "%3f";
    else if (letter == '#')
      uri += "%23";
    else
      uri += letter;
  }
  return uri;
}

// The bytes of a file that has no name, which SQLite does not open: /proc/self/fd/N is a link.
class MappedFile {
 public:
  explicit MappedFile(const std::filesystem::path& path) {
    const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC);
    struct stat status = {};
    if (descriptor >= 0 && fstat(descriptor, &status) == 0 && status.st_size > 0) {
      size_ = static_cast<std::size_t>(status.st_size);
      data_ = mmap(nullptr, size_, PROT_READ | PROT_WRITE, MAP_PRIVATE, descriptor, 0);
    }
    if (descriptor >= 0) close(descriptor);
    require(data_ != MAP_FAILED, path.string() + ": cannot be mapped into memory");
  }
  ~MappedFile() { munmap(data_, size_); }
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;

  unsigned char* data() const { return static_cast<unsigned char*>(data_); }
  std::size_t size() const { return size_; }

 private:
  void* data_ = MAP_FAILED;
  std::size_t size_ = 0;
};

/// @param bytes  filled for a file without a name, and outlives the database.
Database opened(const std::filesystem::path& path, std::optional<MappedFile>& bytes) {
  files::require_readable(path);
  sqlite3* raw = nullptr;
  const std::string name = std::filesystem::absolute(path).string();
  if (name.starts_with("/proc/self/fd/")) {
    bytes.emplace(path);
    // A write-ahead log would be another file: the version without one.
    constexpr std::size_t kWriteVersion = 18, kReadVersion = 19;
    if (bytes->size() > kReadVersion)
      bytes->data()[kWriteVersion] = bytes->data()[kReadVersion] = 1;
    const auto size = static_cast<sqlite3_int64>(bytes->size());
    sqlite3_open_v2(":memory:", &raw, SQLITE_OPEN_READWRITE | SQLITE_OPEN_NOMUTEX, nullptr);
    sqlite3_deserialize(raw, "main", bytes->data(), size, size, SQLITE_DESERIALIZE_READONLY);
  } else {
    const std::string uri = "file:" + escaped(name) + "?immutable=1";
    sqlite3_open_v2(uri.c_str(), &raw, SQLITE_OPEN_READONLY | SQLITE_OPEN_URI | SQLITE_OPEN_NOMUTEX,
                    nullptr);
  }
  // Else it reads nothing of a file that is cut off.
  sqlite3_exec(raw, "PRAGMA writable_schema=ON", nullptr, nullptr, nullptr);
  return Database(raw);
}

// Rows that are computed, by a view, a module or a column's formula, may never end.
bool has_computed_rows(sqlite3* database) {
  const std::string names = "name IN ('topics', 'messages', 'message_definitions')";
  Rows tables(database, "SELECT COUNT(*) FROM sqlite_master WHERE " + names +
                            " AND (type != 'table' OR rootpage = 0)");
  Rows columns(database, "SELECT COUNT(*) FROM (SELECT name AS of FROM sqlite_master WHERE " +
                             names + "), pragma_table_xinfo(of) WHERE hidden > 0");
  return (tables.next() && tables.integer(0) > 0) || (columns.next() && columns.integer(0) > 0);
}

class Db3Source : public MessageSource {
 public:
  explicit Db3Source(const std::filesystem::path& path)
      : path_(path.string()), database_(opened(path, bytes_)) {
    require(!has_computed_rows(database_.get()),
            path_ + ": its tables are views or formulas, not stored rows");
    require(Rows(database_.get(), "SELECT topic_id, timestamp, data FROM messages").is_valid() &&
                read_topics(),
            path_ +
                ": is not a rosbag2 recording, or its beginning is damaged: no topics and "
                "messages (" +
                sqlite3_errmsg(database_.get()) + ")");
    read_definitions();
    note_wal();
    rewind();
  }

  std::string format() const override { return "rosbag2 (sqlite3)"; }
  std::vector<std::string> paths() const override { return {path_}; }

  void select(std::function<bool(const Topic&)> is_wanted) override {
    is_wanted_ = std::move(is_wanted);
    rewind();
  }

  std::optional<Message> next() override {
    while (next_row()) {
      has_given_ = true;
      const auto topic = topics_.find(row_.topic);
      if (topic == topics_.end()) continue;
      return Message{&topic->second, row_.time_ns, row_.time_ns, unpacker_.message(data_)};
    }
    return std::nullopt;
  }

  void rewind() override {
    std::string wanted;
    for (const auto& [id, topic] : topics_) {
      if (is_wanted_ && !is_wanted_(topic)) continue;
      wanted += (wanted.empty() ? "" : ",") + std::to_string(id);
    }
    // With its index on timestamps sqlite need not sort.
    // Else it sorts their numbers: messages themselves may be more than the memory.
    const std::string from = " FROM messages WHERE ";
    const std::string columns = "SELECT rowid, topic_id, timestamp, coalesce(length(data), 0) <= " +
                                std::to_string(kMostMessageBytes) + ", data" + from;
    const std::string in_order = "topic_id IN (" + wanted + ") ORDER BY timestamp, rowid";
    order_.reset();
    if (sorts(columns + in_order))
      order_.emplace(database_.get(), "SELECT rowid" + from + in_order);
    rows_.emplace(database_.get(), columns + (order_ ? "rowid = ?" : in_order));
    has_given_ = false;
    row_ = {};
    pages_.reset();
    damage_ = {};
  }

  std::optional<TimeSpan> span() const override {
    Rows ends(database_.get(), "SELECT MIN(timestamp), MAX(timestamp) FROM messages");
    if (!ends.next() || last_id_ == 0) return std::nullopt;
    return TimeSpan{ends.integer(0), ends.integer(1)};
  }
  std::vector<const Topic*> topics() const override {
    count_messages();
    std::vector<const Topic*> topics;
    for (const auto& [id, topic] : topics_) topics.push_back(&topic);
    return topics;
  }
  const Damage& damage() const override { return damage_; }
  const std::vector<std::string>& notes() const override { return notes_; }
  double progress() const override {
    return last_id_ > 0
               ? std::clamp(static_cast<double>(row_.id) / static_cast<double>(last_id_), 0.0, 1.0)
               : 1.0;
  }

 private:
  bool next_row() {
    if (!pages_) {
      while (next_in_order()) {
        row_.id = rows_->integer(0);
        row_.topic = rows_->integer(1);
        row_.time_ns = rows_->integer(2);
        given_until_ = {row_.time_ns, row_.id};
        if (rows_->integer(3) == 0) {
          note_once(notes_, kTooLarge);
          continue;
        }
        data_ = rows_->blob(4);
        return true;
      }
      if (!is_broken_) return false;
      read_pages();
    }
    while (auto row = pages_->next()) {
      const auto topic = topics_.find(row->topic);
      const bool is_wanted = topic != topics_.end() && (!is_wanted_ || is_wanted_(topic->second));
      const bool is_new = std::pair(row->time_ns, row->id) > given_until_;
      if (!is_wanted || !is_new) continue;
      row_ = std::move(*row);
      data_ = row_.data;
      return true;
    }
    return false;
  }

  bool sorts(const std::string& query) {
    Rows plan(database_.get(), "EXPLAIN QUERY PLAN " + query);
    while (plan.next()) {
      if (plan.text(3).find("TEMP B-TREE") != std::string::npos) return true;
    }
    return false;
  }

  bool next_in_order() {
    const bool is_there = !order_ || order_->next();
    if (is_there && order_) rows_->begin(order_->integer(0));
    if (is_there && rows_->next()) return true;
    is_broken_ = order_ ? is_there || order_->is_broken() : rows_->is_broken();
    return false;
  }

  // The index or a tree is damaged: from there on what the pages themselves hold.
  void read_pages() {
    if (!has_given_) given_until_ = {INT64_MIN, INT64_MIN};
    pages_.emplace(path_);
    damage_ = {1, pages_->missing_bytes(), 0, pages_->missing_bytes() > 0};
    note_once(notes_, std::string("the database is damaged: ") + sqlite3_errmsg(database_.get()));
  }

  bool read_topics() {
    Rows topics(database_.get(),
                "SELECT id, name, type, serialization_format FROM topics WHERE length(name) < 1e6 "
                "AND length(type) < 1e6");
    if (!topics.is_valid()) return false;
    while (topics.next()) {
      count_topic_bytes(sizeof(Topic) + topics.blob(1).size() + topics.blob(2).size());
      Topic topic;
      topic.id = static_cast<uint32_t>(topics.integer(0));
      topic.name = topics.text(1);
      topic.type = plain_type(topics.text(2));
      topic.encoding = topics.text(3);
      topics_.emplace(topics.integer(0), std::move(topic));
    }
    Rows profiles(
        database_.get(),
        "SELECT id, offered_qos_profiles FROM topics WHERE length(offered_qos_profiles) < 1e6");
    while (profiles.next()) {
      const auto topic = topics_.find(profiles.integer(0));
      if (topic == topics_.end()) continue;
      count_topic_bytes(profiles.blob(1).size());
      std::string& text = topic->second.metadata["offered_qos_profiles"];
      text = profiles.text(1);
      topic->second.is_latched = text.find("transient_local") != std::string::npos ||
                                 text.find("durability: 1") != std::string::npos;
    }
    Rows last(database_.get(), "SELECT MAX(id) FROM messages");
    if (last.next()) last_id_ = last.integer(0);
    return true;
  }

  // A walk over the whole table: for those who ask.
  void count_messages() const {
    if (are_counted_) return;
    are_counted_ = true;
    for (auto& [id, topic] : topics_) topic.messages = 0;
    Rows counts(database_.get(), "SELECT topic_id, COUNT(*) FROM messages GROUP BY topic_id");
    while (counts.next()) {
      const auto topic = topics_.find(counts.integer(0));
      if (topic != topics_.end()) topic->second.messages = counts.integer(1);
    }
  }

  // Recordings from 2023 on have them.
  void read_definitions() {
    Rows rows(database_.get(),
              "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions "
              "WHERE length(encoded_message_definition) < 1e8");
    std::multimap<std::string, Topic*> by_type;
    for (auto& [id, topic] : topics_) by_type.emplace(topic.type, &topic);
    while (rows.next()) {
      const auto [begin, end] = by_type.equal_range(plain_type(rows.text(0)));
      for (auto of_type = begin; of_type != end; ++of_type) {
        count_topic_bytes(rows.blob(2).size());
        of_type->second->schema_encoding = rows.text(1);
        of_type->second->schema = rows.text(2);
      }
    }
  }

  void count_topic_bytes(std::size_t bytes) {
    topic_bytes_ += bytes;
    require(topic_bytes_ <= kMostTopicBytes, path_ + kTooManyTopics);
  }

  void note_wal() {
    std::error_code none;
    const auto bytes = std::filesystem::file_size(path_ + "-wal", none);
    if (!none && bytes > 0) {
      notes_.push_back(path_ +
                       "-wal contains messages that are not in the database yet: open and close it "
                       "once with sqlite3 to include them");
    }
  }

  std::string path_;
  std::optional<MappedFile> bytes_;
  Database database_;
  mutable std::map<int64_t, Topic> topics_;  // nodes: messages point to them
  mutable bool are_counted_ = false;
  std::function<bool(const Topic&)> is_wanted_;
  std::optional<Rows> order_, rows_;
  std::optional<Db3Pages> pages_;  // where sqlite fails
  Db3Row row_;                     // its bytes where pages are read
  std::span<const uint8_t> data_;  // of the row
  Unpacker unpacker_;
  std::pair<int64_t, int64_t> given_until_;  // time and id, by sqlite
  bool has_given_ = false, is_broken_ = false;
  int64_t last_id_ = 0;
  std::size_t topic_bytes_ = 0;
  Damage damage_;
  std::vector<std::string> notes_;
};

}  // namespace

std::unique_ptr<MessageSource> open_db3(const std::filesystem::path& path) {
  return std::make_unique<Db3Source>(path);
}

}  // namespace marco::ros
