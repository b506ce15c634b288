#pragma once

#include <netinet/tcp.h>

#include <array>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "web/connection.hpp"

namespace marco::web {

namespace http = beast::http;
namespace websocket = beast::websocket;
inline constexpr std::chrono::seconds kShakeHandsWithin{5}, kSilence{20}, kSendWithin{30};
inline constexpr std::size_t kLargestFrame = 1 << 20;
inline constexpr int kSendBuffer = 256 << 10;
inline constexpr int kUnsent = 32 << 10;  // of it; what lies there is old when it arrives

/// A client of the hub.
class WebSocketConnection : public std::enable_shared_from_this<WebSocketConnection> {
 public:
  template <class Count>
  WebSocketConnection(ByteStream stream, Shared& shared, Count counted)
      : stream_(std::move(stream)),
        shared_(shared),
        counted_(std::make_shared<Count>(std::move(counted))),
        watch_(stream_.get_executor()) {}

  void start(http::request<http::empty_body> request,
             const std::string& subprotocol,
             bool may_steer) {
    request_ = std::move(request);
    may_steer_ = may_steer;
    auto& tcp = stream_.next_layer().tcp();
    tcp.expires_never();
    error_code ignored;
    tcp.socket().set_option(Tcp::no_delay(true), ignored);
    tcp.socket().set_option(asio::socket_base::send_buffer_size(kSendBuffer), ignored);
    tcp.socket().set_option(
        asio::detail::socket_option::integer<IPPROTO_TCP, TCP_NOTSENT_LOWAT>(kUnsent), ignored);
    // A peer that says nothing is asked with a ping, and given up when it does not answer.
    stream_.set_option(websocket::stream_base::timeout{kShakeHandsWithin, kSilence, true});
    stream_.set_option(
        websocket::stream_base::decorator([subprotocol](websocket::response_type& response) {
          response.set(http::field::sec_websocket_protocol, subprotocol);
        }));
    stream_.read_message_max(kLargestFrame);
    stream_.async_accept(request_, [self = shared_from_this()](error_code error) {
      if (!error) self->opened();
    });
  }

 private:
  void opened() {
    const std::weak_ptr<WebSocketConnection> weak = weak_from_this();
    // Not at once: the hub is in the middle of telling its clients.
    const auto later = [weak, executor = stream_.get_executor()](auto act) {
      asio::post(executor, [weak, act = std::move(act)] {
        if (const auto self = weak.lock()) act(*self);
      });
    };
    client_ = shared_.hub.open(
        {[this, later] {
           if (is_writing_ || std::exchange(is_woken_, true)) return;
           later([](auto& self) { self.write(); });
         },
         [later](const std::string& why) { later([why](auto& self) { self.close(why); }); }},
        may_steer_);
    if (client_ == 0) return close("too many clients");
    read();
  }

  void read() {
    stream_.async_read(in_, [self = shared_from_this()](error_code error, std::size_t) {
      if (error == websocket::error::message_too_big ||
          error == websocket::error::buffer_overflow) {
        self->shared_.drops.count("refused: a message above 1 MB");
      }
      if (error) return self->end();
      self->take();
    });
  }

  void take() {
    const auto bytes = in_.data();
    const auto* data = static_cast<const uint8_t*>(bytes.data());
    if (stream_.got_text()) {
      shared_.hub.take_text(client_, {reinterpret_cast<const char*>(data), bytes.size()});
    } else {
      shared_.hub.take_binary(client_, {data, bytes.size()});
    }
    in_.consume(in_.size());
    if (!is_over_) read();
  }

  void write() {
    is_woken_ = false;
    Outbox* outbox = shared_.hub.outbox(client_);
    if (is_writing_ || is_over_ || outbox == nullptr) return;
    auto next = outbox->take();
    if (!next) return;
    out_ = std::move(*next);
    is_writing_ = true;
    stream_.text(out_.is_text);
    const std::array<asio::const_buffer, 2> parts = {asio::buffer(out_.head),
                                                     asio::buffer(*out_.body)};
    watch_.expires_after(kSendWithin);
    watch_.async_wait([weak = weak_from_this()](error_code cancelled) {
      const auto self = weak.lock();
      if (!cancelled && self) self->give_up();
    });
    stream_.async_write(parts, [self = shared_from_this()](error_code error, std::size_t) {
      self->watch_.cancel();
      self->is_writing_ = false;
      if (error) return self->end();
      self->write();
    });
  }

  // It has not taken a message within kSendWithin.
  void give_up() {
    if (!is_writing_ || is_over_) return;
    shared_.drops.count("let go: a client that does not read");
    end();
  }

  void close(const std::string& why) {
    if (is_over_) return;
    if (is_writing_) return end();
    forget();
    stream_.async_close({websocket::close_code::policy_error, why.substr(0, 120)},
                        [self = shared_from_this()](error_code) { self->end(); });
  }

  void forget() {
    is_over_ = true;
    if (client_ != 0) shared_.hub.close(std::exchange(client_, 0));
  }

  void end() {
    forget();
    watch_.cancel();
    error_code ignored;
    stream_.next_layer().tcp().socket().close(ignored);
  }

  websocket::stream<ByteStream> stream_;
  Shared& shared_;
  std::shared_ptr<void> counted_;
  asio::steady_timer watch_;
  http::request<http::empty_body> request_;
  beast::flat_buffer in_;
  Outgoing out_;
  Hub::ClientId client_ = 0;
  bool may_steer_ = false, is_writing_ = false, is_woken_ = false, is_over_ = false;
};

}  // namespace marco::web
