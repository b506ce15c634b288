#include "recordings/ros/db3_vfs.hpp"

#include <sqlite3.h>

#include <algorithm>
#include <exception>
#include <memory>

#include "recordings/ros/byte_file.hpp"

namespace marco::ros {
namespace {

constexpr int64_t kBlockBytes = 1 << 17;

// Of an open database: the file, and its last block.
class Blocks {
 public:
  explicit Blocks(const char* path) : file_(path) {}

  int64_t size() const { return file_.size(); }
  std::size_t read(int64_t offset, std::span<uint8_t> into) {
    const auto wanted = static_cast<int64_t>(into.size());
    const int64_t block_end = block_at_ + static_cast<int64_t>(block_.size());
    const bool goes_on = offset == last_end_ || offset == block_end;
    last_end_ = offset + wanted;
    if (offset < block_at_ || offset + wanted > block_end) {
      // A page by itself (the tree that leads to the others) leaves the block as it is.
      if (!goes_on || wanted > kBlockBytes) return file_.read(offset, into);
      file_.read(offset, kBlockBytes, block_);
      block_at_ = offset;
    }
    const auto there = block_.bytes().subspan(static_cast<std::size_t>(offset - block_at_));
    const std::size_t size = std::min(there.size(), into.size());
    std::copy_n(there.begin(), size, into.begin());
    return size;
  }

 private:
  ByteFile file_;
  ByteBuffer block_;
  int64_t block_at_ = 0;
  int64_t last_end_ = -1;  // of what was read last
};

// Sqlite allots it, and knows its beginning.
struct OpenFile {
  sqlite3_file base;
  Blocks* blocks;
};

Blocks& blocks_of(sqlite3_file* file) { return *reinterpret_cast<OpenFile*>(file)->blocks; }

int close_file(sqlite3_file* file) {
  delete reinterpret_cast<OpenFile*>(file)->blocks;  // NOLINT(cppcoreguidelines-owning-memory)
  return SQLITE_OK;
}

int read_file(sqlite3_file* file, void* into, int bytes, sqlite3_int64 offset) {
  const std::span<uint8_t> wanted(static_cast<uint8_t*>(into), static_cast<std::size_t>(bytes));
  try {
    const std::size_t got = blocks_of(file).read(offset, wanted);
    std::fill(wanted.begin() + static_cast<std::ptrdiff_t>(got), wanted.end(), uint8_t{0});
    return got == wanted.size() ? SQLITE_OK : SQLITE_IOERR_SHORT_READ;
  } catch (const std::exception&) {  // no memory: nothing may be thrown through sqlite
    return SQLITE_IOERR_NOMEM;
  }
}

int size_of_file(sqlite3_file* file, sqlite3_int64* bytes) {
  *bytes = blocks_of(file).size();
  return SQLITE_OK;
}

int refuse_write(sqlite3_file*, const void*, int, sqlite3_int64) { return SQLITE_READONLY; }
int refuse_truncate(sqlite3_file*, sqlite3_int64) { return SQLITE_READONLY; }
int need_no_lock(sqlite3_file*, int) { return SQLITE_OK; }
int know_no_lock(sqlite3_file*, int* is_reserved) {
  *is_reserved = 0;
  return SQLITE_OK;
}
int know_no_order(sqlite3_file*, int, void*) { return SQLITE_NOTFOUND; }
int no_sector(sqlite3_file*) { return 0; }
int is_immutable(sqlite3_file*) { return SQLITE_IOCAP_IMMUTABLE; }

constexpr sqlite3_io_methods methods() {
  sqlite3_io_methods methods{};
  methods.iVersion = 1;
  methods.xClose = close_file;
  methods.xRead = read_file;
  methods.xWrite = refuse_write;
  methods.xTruncate = refuse_truncate;
  methods.xSync = need_no_lock;
  methods.xFileSize = size_of_file;
  methods.xLock = need_no_lock;
  methods.xUnlock = need_no_lock;
  methods.xCheckReservedLock = know_no_lock;
  methods.xFileControl = know_no_order;
  methods.xSectorSize = no_sector;
  methods.xDeviceCharacteristics = is_immutable;
  return methods;
}
constexpr sqlite3_io_methods kMethods = methods();

// What sqlite sorts aside goes into files of the system's own.
int open_file(sqlite3_vfs*, const char* path, sqlite3_file* file, int flags, int* flags_got) {
  if ((flags & SQLITE_OPEN_MAIN_DB) == 0) {
    sqlite3_vfs* system = sqlite3_vfs_find(nullptr);
    return system->xOpen(system, path, file, flags, flags_got);
  }
  auto* open = reinterpret_cast<OpenFile*>(file);
  open->base.pMethods = nullptr;
  try {
    open->blocks = std::make_unique<Blocks>(path).release();
  } catch (const std::exception&) {
    return SQLITE_CANTOPEN;
  }
  open->base.pMethods = &kMethods;
  if (flags_got != nullptr) *flags_got = flags;
  return SQLITE_OK;
}

int keep_path(sqlite3_vfs*, const char* path, int room, char* into) {
  sqlite3_snprintf(room, into, "%s", path);
  return SQLITE_OK;
}

}  // namespace

const char* block_reading_vfs() {
  static sqlite3_vfs vfs = [] {
    const sqlite3_vfs& system = *sqlite3_vfs_find(nullptr);
    sqlite3_vfs ours = system;
    ours.pNext = nullptr;
    ours.zName = "marco_blocks";
    ours.szOsFile = std::max(system.szOsFile, static_cast<int>(sizeof(OpenFile)));
    ours.xOpen = open_file;
    ours.xFullPathname = keep_path;
    return ours;
  }();
  static const int is_registered = sqlite3_vfs_register(&vfs, 0);
  (void)is_registered;
  return vfs.zName;
}

}  // namespace marco::ros
