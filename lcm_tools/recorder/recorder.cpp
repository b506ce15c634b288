#include "lcm_tools/recorder/recorder.hpp"

#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstring>
#include <ctime>
#include <stdexcept>
#include <thread>

#include "lcm_tools/base/amounts.hpp"

namespace marco::recorder {
namespace {

constexpr std::chrono::seconds kLookEvery{1}, kRateOver{60};

std::string size(int64_t bytes) { return size_text(static_cast<double>(bytes)); }

DiskSpace space_of(const std::filesystem::path& folder) {
  const auto space = std::filesystem::space(folder);
  return {static_cast<int64_t>(space.available), static_cast<int64_t>(space.capacity)};
}

}  // namespace

LoggerChild::LoggerChild(const std::string& url,
                         const std::filesystem::path& folder,
                         const std::string& piece_mb) {
  const std::string split = "--split-mb=" + piece_mb, network = "--lcm-url=" + url,
                    file = folder / "live.lcm";
  const std::array words = {"lcm-logger", "-q", "-i", split.c_str(), network.c_str(), file.c_str()};
  std::array<char*, words.size() + 1> arguments = {};
  for (std::size_t i = 0; i < words.size(); ++i) arguments[i] = const_cast<char*>(words[i]);
  const pid_t parent = getpid();
  pid_ = fork();
  if (pid_ < 0) throw std::runtime_error("lcm-logger: cannot start a process");
  if (pid_ > 0) return;
  prctl(PR_SET_PDEATHSIG, SIGINT);
  if (getppid() != parent) _exit(1);
  execvp(arguments[0], arguments.data());
  _exit(kNotInstalled);
}

LoggerChild::~LoggerChild() { stop(Told::no); }

std::optional<int> LoggerChild::ended() {
  int status = 0;
  if (pid_ <= 0 || waitpid(pid_, &status, WNOHANG) == 0) return std::nullopt;
  pid_ = -1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

bool LoggerChild::ends_within(double seconds) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (pid_ > 0 && !ended()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return true;
}

void LoggerChild::stop(Told told) {
  constexpr double kOfItselfS = 0.5, kLongestS = 3.0;
  if (pid_ <= 0 || (told == Told::already && ends_within(kOfItselfS))) return;
  ::kill(pid_, SIGINT);
  if (ends_within(kLongestS)) return;
  ::kill(pid_, SIGKILL);
  ends_within(kLongestS);
}

Recorder::Recorder(RecorderOptions options, std::function<void(const std::string&)> say)
    : options_(std::move(options)), say_(std::move(say)) {}

std::vector<Recording> Recorder::look() {
  std::filesystem::create_directories(options_.home);
  disk_ = space_of(options_.home);
  std::vector<Recording> all = recordings_in(options_.home);
  for (Recording& recording : all) {
    if (!recording_ || recording.folder != recording_->folder()) continue;
    recording.running = true;
    bytes_ = recording.bytes;
  }
  may_delete_ = std::any_of(all.begin(), all.end(), [](const auto& one) { return one.may_go(); });
  return all;
}

std::string Recorder::make_room() {
  // Resuming needs a little more than stopping did, or it would be stopped again at once.
  constexpr double kMoreToResume = 1.05;
  const std::vector<Recording> all = look();
  DiskSpace asked = disk_;
  const int64_t reserve = reserve_bytes(disk_);
  if (!waiting_.empty()) {
    asked.free_bytes -= static_cast<int64_t>((kMoreToResume - 1.0) * static_cast<double>(reserve));
  }
  for (const Recording& oldest : in_the_way(all, asked)) {
    remove(oldest);
    ++deleted_;
    asked.free_bytes += oldest.bytes;
    say_("deleted the oldest recording, " + oldest.folder.string() + " (" + size(oldest.bytes) +
         "): less than " + size(reserve) + " of the disk were free");
  }
  if (asked.free_bytes >= reserve) return "";
  return "room: " + size(disk_.free_bytes) + " free, " + size(reserve) +
         " stay free, and no recording may be deleted";
}

void Recorder::begin() {
  if (!recording_ || !recording_->is_there()) {
    recording_ = std::make_unique<RunningRecording>(options_.home, std::time(nullptr));
  }
  sizes_.clear();
  child_ = std::make_unique<LoggerChild>(options_.url, recording_->folder(), options_.piece_mb);
  say_("recording " + recording_->folder().string());
}

void Recorder::wait_for(const std::string& what) {
  child_.reset();
  if (waiting_.empty()) say_("waiting for " + what);
  waiting_ = what;
}

void Recorder::note_end(int code) {
  child_.reset();
  if (code == LoggerChild::kNotInstalled) {
    throw std::runtime_error("lcm-logger is not installed (Debian: liblcm-bin)");
  }
  say_("lcm-logger ended with " +
       (code < 0 ? std::string(strsignal(-code)) : std::to_string(code)) +
       ": starting a new piece");
}

void Recorder::step(Clock::time_point now) {
  if (child_) {
    if (const auto code = child_->ended()) note_end(*code);
  }
  if (now < next_) return;
  next_ = now + kLookEvery;
  try {
    const std::string lacking = make_room();
    if (!lacking.empty()) return wait_for(lacking);
    waiting_.clear();
    if (!child_) begin();
  } catch (const std::runtime_error& wrong) {  // a disk that was taken out, or may not be written
    return wait_for("a folder that can be written: " + std::string(wrong.what()));
  }
  sizes_.push_back({now, bytes_});
  while (now - sizes_.front().time > kRateOver) sizes_.pop_front();
}

void Recorder::stop(LoggerChild::Told told) {
  if (child_) child_->stop(told);
  child_.reset();
}

double Recorder::rate_bytes_per_s() const {
  if (sizes_.size() < 2) return 0.0;
  const Sample &first = sizes_.front(), &last = sizes_.back();
  return static_cast<double>(last.bytes - first.bytes) /
         std::chrono::duration<double>(last.time - first.time).count();
}

std::string Recorder::state() const {
  if (!waiting_.empty()) return "waiting for " + waiting_;
  if (!recording_) return "waiting for a folder";
  const double rate = rate_bytes_per_s();
  std::string text = "recording " + recording_->name() + ": " + size(bytes_) + ", " +
                     size_text(60.0 * rate) + "/min, " + size(disk_.free_bytes) + " free";
  if (rate > 0.0) {
    const auto room = static_cast<double>(disk_.free_bytes - reserve_bytes(disk_));
    text += ", room for " + span_text(std::max(0.0, room) / rate) +
            (may_delete_ ? ", then the oldest recordings are deleted" : "");
  }
  if (deleted_ > 0) text += "; " + std::to_string(deleted_) + " old recordings were deleted";
  return text;
}

}  // namespace marco::recorder
