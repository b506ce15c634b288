#pragma once

namespace marco::ros {

/// Name of a file system for sqlite3_open_v2: it reads a database that nobody writes, in blocks
/// where pages are read one after the other. Sqlite asks for one page at a time, and each would be
/// a call of the system: a third of what reading a recording costs. Its paths are absolute, links
/// in them are followed by the system.
const char* block_reading_vfs();

}  // namespace marco::ros
