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
#include <span>
#include <string>
#include <utility>

#include "web/connection.hpp"

namespace marco::web {

namespace http = beast::http;
namespace websocket = beast::websocket;
inline constexpr std::chrono::seconds kShakeHandsWithin{5}, kSilence{20}, kSendWithin{30};
inline constexpr std::size_t kLargestFrame = 32 << 10;  // a thousand subscriptions
inline constexpr double kBytesPerS = 200'000.0;         // of a client, pings among them
inline constexpr int kSendBuffer = 256 << 10;
inline constexpr int kUnsent = 32 << 10;  // of it; what lies there is old when it arrives

/// A client of the hub.
class WebSocketConnection : public std::enable_shared_from_this<WebSocketConnection> {
 public:
  WebSocketConnection(ByteStream stream, Shared& shared, Hub::Who who)
      : stream_(std::move(stream)),
        shared_(shared),
        who_(std::move(who)),
        watch_(stream_.get_executor()) {}

  void start(http::request<http::empty_body> request, const std::string& subprotocol) {
    request_ = std::move(request);
    auto& tcp = stream_.next_layer().tcp();
    tcp.expires_never();
    stream_.next_layer().limit(RateLimit(kBytesPerS, 2 * kBytesPerS));
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
      if (error) return;
      self->in_turn([](auto& opened) { opened.open(); });
    });
  }

 private:
  template <class Act>
  void in_turn(Act act) {
    shared_.hub.turns().add(who_.may_steer ? Turns::Rank::steers : Turns::Rank::watches,
                            [self = shared_from_this(), act] { act(*self); });
  }

  void open() {
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
         [later](const std::string& why) { later([why](auto& self) { self.close(why); }); },
         [later] { later([](auto& self) { self.ping(); }); }},
        who_);
    if (client_ == 0) return close("too many clients");
    stream_.control_callback([weak](websocket::frame_type kind, beast::string_view) {
      const auto self = weak.lock();
      if (self && kind == websocket::frame_type::pong) self->shared_.hub.on_pong(self->client_);
      if (self && kind == websocket::frame_type::ping) self->shared_.hub.on_ping(self->client_);
    });
    read();
  }

  void read() {
    stream_.async_read(in_, [self = shared_from_this()](error_code error, std::size_t) {
      if (error == websocket::error::message_too_big ||
          error == websocket::error::buffer_overflow) {
        self->shared_.drops.count("refused: a message above 32 kB");
      }
      if (error == asio::error::no_buffer_space) {
        self->shared_.drops.count("disconnected: client sends too much");
      }
      if (error) return self->end();
      if (!self->stream_.got_text() && self->shared_.hub.is_stop(self->message())) {
        return self->take();
      }
      self->in_turn([](auto& reads) { reads.take(); });
    });
  }

  std::span<const uint8_t> message() const {
    return {static_cast<const uint8_t*>(in_.cdata().data()), in_.size()};
  }

  void take() {
    const auto data = message();
    if (stream_.got_text()) {
      shared_.hub.take_text(client_, {reinterpret_cast<const char*>(data.data()), data.size()});
    } else {
      shared_.hub.take_binary(client_, data);
    }
    in_.consume(in_.size());
    if (!is_over_) read();
  }

  void write() {
    is_woken_ = false;
    if (is_writing_ || is_over_) return;
    auto next = shared_.hub.next_outgoing(client_);
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
    shared_.drops.count("disconnected: client too slow");
    end();
  }

  void ping() {
    if (is_over_ || std::exchange(is_pinging_, true)) return;
    stream_.async_ping({}, [self = shared_from_this()](error_code) { self->is_pinging_ = false; });
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
  Hub::Who who_;
  asio::steady_timer watch_;
  http::request<http::empty_body> request_;
  beast::flat_buffer in_;
  Outgoing out_;
  Hub::ClientId client_ = 0;
  bool is_writing_ = false, is_woken_ = false, is_over_ = false, is_pinging_ = false;
};

}  // namespace marco::web
