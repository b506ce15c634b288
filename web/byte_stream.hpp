#pragma once

#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/websocket/teardown.hpp>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "web/rate_limit.hpp"
#include "web/steady_clock.hpp"

namespace marco::web {

namespace asio = boost::asio;
namespace beast = boost::beast;
using Tcp = asio::ip::tcp;
using boost::system::error_code;

/// A certificate and its key.
class Tls {
 public:
  /// @throws std::runtime_error where they cannot be read
  Tls(const std::string& certificate, const std::string& key);
  ~Tls();
  struct Context;
  Context& context() { return *context_; }

 private:
  std::unique_ptr<Context> context_;
};

/// A TCP connection, plain or under TLS. One type for both: Beast's templates, which are large, are
/// instantiated once, and the TLS below them for reads and writes alone. Models Beast's
/// AsyncStream. Handlers run on the io_context's thread; there is only one.
class ByteStream {
 public:
  using executor_type = beast::tcp_stream::executor_type;
  using Moved = std::function<void(error_code, std::size_t)>;
  using Done = std::function<void(error_code)>;
  /// A write takes this many buffers at most, as one packet where they are small.
  using Parts = std::array<asio::const_buffer, 16>;

  /// @param tls  null: plain; else outlives the stream
  ByteStream(Tcp::socket socket, Tls* tls);

  /// Plain: `done` is called at once.
  void handshake(Done done) { transport_->handshake(std::move(done)); }
  beast::tcp_stream& tcp() { return transport_->tcp(); }
  executor_type get_executor() { return tcp().get_executor(); }

  /// From here on a peer that sends more than that ends with asio::error::no_buffer_space.
  void limit(const RateLimit& bytes) { limit_ = std::make_shared<RateLimit>(bytes); }

  /// Reads little at once: other peers have their turn.
  template <class Buffers, class Handler>
  void async_read_some(const Buffers& buffers, Handler&& handler) {
    constexpr std::size_t kMostAtOnce = 4096;
    asio::mutable_buffer first;
    for (auto it = asio::buffer_sequence_begin(buffers);
         it != asio::buffer_sequence_end(buffers) && first.size() == 0; ++it) {
      first = asio::mutable_buffer(*it);
    }
    auto kept = std::make_shared<std::decay_t<Handler>>(std::forward<Handler>(handler));
    transport_->read(asio::buffer(first, kMostAtOnce),
                     [kept, limit = limit_](error_code error, std::size_t n) {
                       if (!error && limit && !limit->take(steady_s(), static_cast<double>(n))) {
                         error = asio::error::no_buffer_space;
                       }
                       std::move (*kept)(error, n);
                     });
  }

  template <class Buffers, class Handler>
  void async_write_some(const Buffers& buffers, Handler&& handler) {
    Parts parts;
    std::size_t n = 0;
    for (auto it = asio::buffer_sequence_begin(buffers);
         it != asio::buffer_sequence_end(buffers) && n < parts.size(); ++it) {
      const asio::const_buffer part(*it);
      if (part.size() > 0) parts[n++] = part;
    }
    transport_->write(parts, copyable(std::forward<Handler>(handler)));
  }

  /// The end of a WebSocket, which Beast finds by the argument's type.
  template <class Handler>
  friend void async_teardown(beast::role_type, ByteStream& stream, Handler&& handler) {
    auto kept = std::make_shared<std::decay_t<Handler>>(std::forward<Handler>(handler));
    stream.transport_->teardown([kept](error_code error) { std::move (*kept)(error); });
  }
  friend void beast_close_socket(ByteStream& stream) {
    error_code ignored;
    stream.tcp().socket().close(ignored);
  }

 private:
  struct Transport {
    virtual ~Transport() = default;
    virtual beast::tcp_stream& tcp() = 0;
    virtual void handshake(Done done) = 0;
    virtual void read(asio::mutable_buffer into, Moved moved) = 0;
    virtual void write(const Parts& parts, Moved moved) = 0;
    virtual void teardown(Done done) = 0;
  };
  struct Plain;
  struct Secured;

  // Beast's handlers can only be moved.
  template <class Handler>
  static Moved copyable(Handler&& handler) {
    auto kept = std::make_shared<std::decay_t<Handler>>(std::forward<Handler>(handler));
    return [kept](error_code error, std::size_t n) { std::move (*kept)(error, n); };
  }

  std::unique_ptr<Transport> transport_;
  std::shared_ptr<RateLimit> limit_;
};

}  // namespace marco::web
