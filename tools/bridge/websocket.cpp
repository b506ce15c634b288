#include "tools/bridge/websocket.hpp"

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <deque>
#include <optional>
#include <utility>

#include "lcm_tools/base/check.hpp"

namespace marco::bridge {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = beast::websocket;
using Tcp = asio::ip::tcp;
using boost::system::error_code;

constexpr std::chrono::seconds kRetryAfter{1}, kConnectWithin{5}, kSilence{10};
// Schemas of all topics come in one text.
constexpr std::size_t kLargestIn = 64 << 20;
// Several maps of a large building.
constexpr std::size_t kMostWaiting = 32 << 20;

}  // namespace

WebSocketUrl parse_websocket_url(const std::string& url) {
  constexpr std::string_view kScheme = "ws://";
  const std::string form = "'" + url + "': a robot's foxglove_bridge is ws://HOST[:PORT]";
  require(url.starts_with(kScheme), form);
  const std::string rest = url.substr(kScheme.size());
  const std::size_t slash = std::min(rest.find('/'), rest.size());
  WebSocketUrl parsed{rest.substr(0, slash), "8765", rest.substr(slash)};
  if (parsed.path.empty()) parsed.path = "/";
  const std::size_t bracket = parsed.host.find(']');  // of an IPv6 address
  const std::size_t colon = parsed.host.find(':', bracket == std::string::npos ? 0 : bracket);
  if (colon != std::string::npos) {
    parsed.port = parsed.host.substr(colon + 1);
    parsed.host.resize(colon);
  }
  if (bracket != std::string::npos && parsed.host.starts_with('[')) {
    parsed.host = parsed.host.substr(1, bracket - 1);
  }
  const bool has_port = !parsed.port.empty() && parsed.port.size() <= 5 &&
                        parsed.port.find_first_not_of("0123456789") == std::string::npos;
  require(!parsed.host.empty() && has_port, form);
  return parsed;
}

struct WebSocketClient::State {
  State(WebSocketUrl to, std::string offered, Handlers told)
      : url(std::move(to)), subprotocols(std::move(offered)), handlers(std::move(told)) {}

  WebSocketUrl url;
  std::string subprotocols;
  Handlers handlers;
  asio::io_context io;
  asio::steady_timer retry{io};
  asio::posix::stream_descriptor other{io};
  bool waits_for_other = false;
  std::shared_ptr<Connection> connection;
};

/// One connection, from the name's look-up to its end.
class WebSocketClient::Connection : public std::enable_shared_from_this<Connection> {
 public:
  struct Outgoing {
    bool is_text;
    std::string bytes;
  };

  explicit Connection(WebSocketClient& client)
      : client_(client), resolver_(client.state_->io), stream_(client.state_->io) {}

  void start() {
    const WebSocketUrl& url = client_.state_->url;
    resolver_.async_resolve(
        url.host, url.port,
        [self = shared_from_this()](error_code error, const Tcp::resolver::results_type& found) {
          if (error) return self->end(error);
          beast::get_lowest_layer(self->stream_).expires_after(kConnectWithin);
          beast::get_lowest_layer(self->stream_)
              .async_connect(found, [self](error_code failed, const Tcp::endpoint&) {
                self->shake_hands(failed);
              });
        });
  }

  bool is_open() const { return is_open_; }
  std::size_t waiting() const { return waiting_; }

  void send(Outgoing message) {
    if (!is_open_) return;
    waiting_ += message.bytes.size();
    out_.push_back(std::move(message));
    if (out_.size() == 1) write();
  }

  /// Its further events are not reported.
  void abandon() {
    is_over_ = true;
    is_open_ = false;
    beast::get_lowest_layer(stream_).cancel();
  }

 private:
  void shake_hands(error_code error) {
    if (error) return end(error);
    beast::get_lowest_layer(stream_).expires_never();
    beast::get_lowest_layer(stream_).socket().set_option(Tcp::no_delay(true), error);
    // A peer that says nothing is asked with a ping, and given up when it does not answer.
    stream_.set_option(websocket::stream_base::timeout{kConnectWithin, kSilence, true});
    stream_.set_option(websocket::stream_base::decorator(
        [offered = client_.state_->subprotocols](websocket::request_type& request) {
          request.set(beast::http::field::sec_websocket_protocol, offered);
        }));
    stream_.read_message_max(kLargestIn);
    const WebSocketUrl& url = client_.state_->url;
    stream_.async_handshake(response_, url.host + ":" + url.port, url.path,
                            [self = shared_from_this()](error_code failed) {
                              if (failed) return self->end(failed);
                              self->opened();
                            });
  }

  void opened() {
    if (is_over_) return;
    is_open_ = true;
    const auto chosen = response_[beast::http::field::sec_websocket_protocol];
    client_.state_->handlers.opened(std::string(chosen.data(), chosen.size()));
    read();
  }

  void read() {
    stream_.async_read(in_, [self = shared_from_this()](error_code error, std::size_t) {
      if (error) return self->end(error);
      self->take();
    });
  }

  void take() {
    if (is_over_) return;
    const auto bytes = in_.data();
    const auto* data = static_cast<const uint8_t*>(bytes.data());
    const Handlers& handlers = client_.state_->handlers;
    if (stream_.got_text()) {
      handlers.text({reinterpret_cast<const char*>(data), bytes.size()});
    } else {
      handlers.binary({data, bytes.size()});
    }
    in_.consume(bytes.size());
    read();
  }

  void write() {
    const Outgoing& first = out_.front();
    stream_.text(first.is_text);
    stream_.async_write(asio::buffer(first.bytes),
                        [self = shared_from_this()](error_code error, std::size_t) {
                          if (error) return self->end(error);
                          self->waiting_ -= self->out_.front().bytes.size();
                          self->out_.pop_front();
                          if (!self->out_.empty()) self->write();
                        });
  }

  void end(error_code error) {
    if (std::exchange(is_over_, true)) return;
    is_open_ = false;
    std::string why = error.message();
    if (error == websocket::error::upgrade_declined) {
      why = "the server supports none of " + client_.state_->subprotocols;
    }
    State& state = *client_.state_;
    state.retry.expires_after(kRetryAfter);
    state.retry.async_wait([&client = client_](error_code cancelled) {
      if (!cancelled) client.connect();
    });
    state.handlers.closed(why);
  }

  WebSocketClient& client_;
  Tcp::resolver resolver_;
  websocket::stream<beast::tcp_stream> stream_;
  websocket::response_type response_;
  beast::flat_buffer in_;
  std::deque<Outgoing> out_;
  std::size_t waiting_ = 0;  // bytes in out_
  bool is_open_ = false, is_over_ = false;
};

WebSocketClient::WebSocketClient(WebSocketUrl url, std::string subprotocols, Handlers handlers)
    : state_(
          std::make_unique<State>(std::move(url), std::move(subprotocols), std::move(handlers))) {
  connect();
}

WebSocketClient::~WebSocketClient() {
  if (state_->connection) state_->connection->abandon();
  if (state_->other.is_open()) state_->other.release();
}

void WebSocketClient::connect() {
  state_->connection = std::make_shared<Connection>(*this);
  state_->connection->start();
}

void WebSocketClient::step(int other, int timeout_ms) {
  State& state = *state_;
  if (!state.other.is_open()) state.other.assign(other);
  if (!std::exchange(state.waits_for_other, true)) {
    state.other.async_wait(asio::posix::stream_descriptor::wait_read,
                           [&state](error_code) { state.waits_for_other = false; });
  }
  state.io.restart();
  if (state.io.run_one_for(std::chrono::milliseconds(timeout_ms)) > 0) state.io.poll();
}

void WebSocketClient::send_text(std::string text) {
  state_->connection->send({true, std::move(text)});
}

bool WebSocketClient::send_binary(std::vector<uint8_t> message) {
  if (state_->connection->waiting() > kMostWaiting) return false;
  state_->connection->send({false, std::string(message.begin(), message.end())});
  return true;
}

bool WebSocketClient::is_open() const { return state_->connection->is_open(); }

}  // namespace marco::bridge
