#pragma once

namespace marco::ros {

/// Name of a read-only VFS for sqlite3_open_v2. SQLite asks for one page at a time, and a system
/// call for each is a third of the cost of reading a recording; this one reads consecutive pages in
/// blocks. The database must not be written meanwhile. Paths are absolute.
const char* block_reading_vfs();

}  // namespace marco::ros
