#include "tools/log/piece_copier.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "common/check.hpp"

namespace marco::logs {
namespace {

// Small enough that what was just scanned is still in the page cache, and that progress moves.
constexpr int64_t kLargestPiece = 16 << 20;

}  // namespace

PieceCopier::PieceCopier(const std::filesystem::path& in, OutputFile& out)
    : source_(open(in.c_str(), O_RDONLY | O_CLOEXEC)), out_(out) {
  require(source_ >= 0, in.string() + ": cannot be read: " + std::strerror(errno));
}

PieceCopier::~PieceCopier() { close(source_); }

void PieceCopier::add(int64_t from, int64_t to) {
  if (from != to_ || to_ - from_ > kLargestPiece) {
    copy();
    from_ = from;
  }
  to_ = to;
}

void PieceCopier::copy() {
  if (to_ > from_) out_.copy_from(source_, from_, to_ - from_);
  from_ = to_;
}

}  // namespace marco::logs
