#pragma once

#include <functional>
#include <memory>

#include "drivers/transport/byte_stream.hpp"

namespace marco::drivers::leuze {

/// A stream that opens a connection for each write() and closes the one before. Without a
/// connection, read() only lets time pass.
class ConnectionPerRequest final : public ByteStream {
 public:
  using Connect = std::function<std::unique_ptr<ByteStream>()>;

  /// @param connect  throws StreamLost when nobody answers.
  explicit ConnectionPerRequest(Connect connect) : connect_(std::move(connect)) {}

  std::size_t read(std::span<uint8_t> into, std::chrono::microseconds timeout) override;
  void write(std::span<const uint8_t> bytes) override;
  void set_line(const LineSettings&) override {}
  void discard_input() override { connection_.reset(); }

 private:
  Connect connect_;
  std::unique_ptr<ByteStream> connection_;
};

}  // namespace marco::drivers::leuze
