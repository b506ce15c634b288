#pragma once

#include <string>

#include "drivers/transport/byte_stream.hpp"

namespace marco::drivers {

/// A file descriptor that closes itself.
class FileHandle {
 public:
  explicit FileHandle(int fd = -1) : fd_(fd) {}
  FileHandle(FileHandle&& other) noexcept : fd_(other.release()) {}
  FileHandle& operator=(FileHandle&& other) noexcept {
    if (this != &other) reset(other.release());
    return *this;
  }
  FileHandle(const FileHandle&) = delete;
  FileHandle& operator=(const FileHandle&) = delete;
  ~FileHandle() { reset(); }

  int get() const { return fd_; }
  bool valid() const { return fd_ >= 0; }
  void reset(int fd = -1);
  int release() {
    const int fd = fd_;
    fd_ = -1;
    return fd;
  }

 private:
  int fd_;
};

/// The common part of a serial port and a TCP connection: a non-blocking descriptor and poll().
class DescriptorStream : public ByteStream {
 public:
  std::size_t read(std::span<uint8_t> into, std::chrono::microseconds timeout) override;
  void write(std::span<const uint8_t> bytes) override;
  void discard_input() override;
  int descriptor() const override { return fd(); }

 protected:
  DescriptorStream(FileHandle handle, std::string name)
      : handle_(std::move(handle)), name_(std::move(name)) {}
  int fd() const { return handle_.get(); }
  const std::string& name() const { return name_; }
  [[noreturn]] void lost(const std::string& why) const;

 private:
  /// @returns whether `events` came within the timeout.
  bool wait(short events, std::chrono::microseconds timeout) const;

  FileHandle handle_;
  std::string name_;
};

/// Discards what was written and has not left. Ignored without a terminal.
void discard_output(int fd);

/// A serial device or the slave of a pseudo-terminal: raw, 8 bits, no flow control, any baud rate
/// (termios2), exclusive (TIOCEXCL, and a file lock that also stops a second driver run by root). A
/// shared lock is that of a guardian whose driver is gone (drivers/guardian/): it ends soon.
/// Refuses a pseudo-terminal that is not a device (drivers/transport/port_claim.hpp).
class SerialStream final : public DescriptorStream {
 public:
  /// @throws as open_stream.
  SerialStream(const std::string& path, const LineSettings& line);
  ~SerialStream() override;

  void set_line(const LineSettings& line) override;
  void discard_input() override;
  void set_dtr(bool raised) override;
};

/// @throws StreamLost when nobody answers within two seconds.
std::unique_ptr<ByteStream> open_tcp(const std::string& host, const std::string& port);

/// The baud rate of a terminal; at the master of a pseudo-terminal, that of its slave.
/// @returns 0 when `fd` is not a terminal.
int baud_of_terminal(int fd);

/// Whether keys cause signals (ISIG): a person's terminal. Those of devices are raw.
bool takes_keys(int fd);

bool is_pseudo_terminal(int fd);

/// Makes a terminal raw at this speed and parity; leaves DTR. @returns whether its driver can.
bool set_terminal(int fd, const LineSettings& line);

}  // namespace marco::drivers
