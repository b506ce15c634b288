#include "lcm_tools/procman/process/output_pump.hpp"

#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>

#include "lcm_tools/base/check.hpp"

namespace marco::procman {
namespace {

// One datagram of the network, with room for the replacement of bytes that are not UTF-8.
constexpr std::size_t kMessageBytes = std::size_t{32} * 1024;
constexpr std::size_t kPieceBytes = std::size_t{16} * 1024;
constexpr int64_t kPeriodUs = 10'000;
constexpr int64_t kMaxBacklogBytes = int64_t{64} * 1024 * 1024;
constexpr int64_t kKeptOfBacklogBytes = int64_t{1024} * 1024;

struct FileStatus {
  int64_t inode = 0;
  int64_t size = 0;
};

FileStatus status_of(const Descriptor& file) {
  struct stat status = {};
  if (!file.is_open() || fstat(file.get(), &status) != 0) return {};
  return {static_cast<int64_t>(status.st_ino), status.st_size};
}

}  // namespace

OutputPump::OutputPump(double bytes_per_s) : bytes_per_s_(bytes_per_s) {
  require(bytes_per_s > 0.0, "the output's pace must be positive");
}

void OutputPump::open_run(const std::string& id, const std::string& file, int64_t shown) {
  Stream& stream = streams_[id];
  Source source{Descriptor(open(file.c_str(), O_RDONLY | O_CLOEXEC)), 0, file, shown, shown, ""};
  source.inode = status_of(source.file).inode;
  if (source.file.is_open()) stream.sources.push_back(std::move(source));
}

bool OutputPump::open_next_file(const std::string& id, const std::string& file, int64_t inode) {
  Source next{Descriptor(open(file.c_str(), O_RDONLY | O_CLOEXEC)), inode, file, 0, 0, ""};
  if (!next.file.is_open() || status_of(next.file).inode != inode) return false;
  std::deque<Source>& sources = streams_[id].sources;
  int64_t left_out = 0;
  for (auto source = sources.begin(); source != sources.end();) {
    if (!source->file.is_open()) {
      ++source;
      continue;
    }
    const bool is_last = std::none_of(source + 1, sources.end(),
                                      [](const Source& later) { return later.file.is_open(); });
    if (is_last) {
      source->end = std::max(source->end, status_of(source->file).size);
      break;
    }
    left_out += source->end - source->at;
    source = sources.erase(source);
  }
  if (left_out > 0) {
    sources.push_front({Descriptor(), 0, "", 0, 0,
                        "\n[" + std::to_string(left_out) + " bytes left out: too much output]\n"});
  }
  sources.push_back(std::move(next));
  return true;
}

void OutputPump::on_growth(const std::string& id, int64_t end_byte) {
  std::deque<Source>& sources = streams_[id].sources;
  const auto file = std::find_if(sources.rbegin(), sources.rend(),
                                 [](const Source& source) { return source.file.is_open(); });
  if (file != sources.rend()) file->end = std::max(file->end, end_byte);
}

void OutputPump::tell(const std::string& id, const std::string& line) {
  streams_[id].sources.push_back({Descriptor(), 0, "", 0, 0, line + "\n"});
}

bool OutputPump::has_more(const Stream& stream) const {
  return std::any_of(stream.sources.begin(), stream.sources.end(), [](const Source& source) {
    return source.at < source.end || !source.line.empty();
  });
}

void OutputPump::leave_out_old_bytes(Source& source, std::string& text) const {
  const int64_t backlog = source.end - source.at;
  if (backlog <= kMaxBacklogBytes) return;
  const int64_t left_out = backlog - kKeptOfBacklogBytes;
  source.at += left_out;
  text += "\n[" + std::to_string(left_out) + " bytes not sent, they are in " + source.path + "]\n";
}

OutputPiece OutputPump::take_piece(const std::string& id, Stream& stream, std::size_t max_bytes) {
  OutputPiece piece{id, "", -1, -1, ""};
  // A run still going stays in front: a line of the deputy's overtakes it where it has no more.
  const auto done = [](const Source& source) {
    return source.line.empty() && source.at >= source.end;
  };
  while (stream.sources.size() > 1 && done(stream.sources[0]) && stream.sources[1].line.empty()) {
    stream.sources.pop_front();
  }
  const auto next = stream.sources.begin() + (done(stream.sources[0]) ? 1 : 0);
  if (!next->line.empty()) {
    piece.text = stream.cleaner.flush() + next->line;
    stream.sources.erase(next);
    return piece;
  }
  leave_out_old_bytes(*next, piece.text);
  const auto wanted = std::min(static_cast<int64_t>(max_bytes), next->end - next->at);
  std::string bytes(static_cast<std::size_t>(wanted), '\0');
  const ssize_t size = pread(next->file.get(), bytes.data(), bytes.size(), next->at);
  piece.file = next->path;
  piece.first_byte = next->at;
  if (size > 0) {
    bytes.resize(static_cast<std::size_t>(size));
    piece.text += stream.cleaner.clean(bytes);
    next->at += size;
  } else {
    next->at = next->end;  // somebody emptied the file
  }
  piece.end_byte = next->at;
  stream.shown = {next->inode, next->at};
  return piece;
}

std::vector<OutputPiece> OutputPump::take(int64_t now_us) {
  std::vector<OutputPiece> pieces;
  if (now_us < next_us_) return pieces;
  std::size_t total = 0;
  auto at = streams_.upper_bound(last_served_);
  for (std::size_t turn = 0; turn < streams_.size() && total < kMessageBytes; ++turn) {
    if (at == streams_.end()) at = streams_.begin();
    auto& [id, stream] = *at++;
    if (!has_more(stream)) continue;
    pieces.push_back(take_piece(id, stream, std::min(kPieceBytes, kMessageBytes - total)));
    total += pieces.back().text.size();
    last_served_ = id;
  }
  const auto pace_us = static_cast<int64_t>(static_cast<double>(total) / bytes_per_s_ * 1e6);
  if (!pieces.empty()) next_us_ = now_us + std::max(kPeriodUs, pace_us);
  return pieces;
}

std::optional<int64_t> OutputPump::next_due_us() const {
  for (const auto& [id, stream] : streams_) {
    if (has_more(stream)) return next_us_;
  }
  return std::nullopt;
}

OutputPump::Shown OutputPump::shown(const std::string& id) const {
  const auto at = streams_.find(id);
  return at != streams_.end() ? at->second.shown : Shown{};
}

}  // namespace marco::procman
