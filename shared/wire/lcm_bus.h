// A connection to an LCM network, as messages of other processes come and ours go.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

struct _lcm_t;
struct _lcm_recv_buf_t;

namespace kt {

/// Messages arrive or they do not: LCM tells nobody of those that were lost. publish() may be called from any
/// thread, the rest from one.
class LcmBus {
 public:
  using Handler = std::function<void(std::span<const uint8_t> data)>;

  /// `url` as LCM takes it: udpm://, tcpq://, file://, memq://; empty means $LCM_DEFAULT_URL, or LCM's own
  /// default. Over UDP as much receive buffer as the system grants is asked for, up to 8 MiB, where the URL
  /// says nothing about it. Throws kt::Error where LCM refuses the URL or cannot reach its server.
  explicit LcmBus(const std::string& url = "");
  ~LcmBus();
  LcmBus(const LcmBus&) = delete;
  LcmBus& operator=(const LcmBus&) = delete;

  /// False where the system refused the message: no route, no network, too large.
  bool publish(std::string_view channel, std::span<const uint8_t> data);

  /// Hands every message on `channel` to `handler`, within receive(). Up to `queued` of them wait; newer ones
  /// are lost. Throws kt::Error where nothing can be received: no route for multicast.
  void subscribe(std::string_view channel, int queued, Handler handler);

  enum class Received { kMessage, kNothing, kEnd };
  /// Hands out one message, waiting for it as long as this; kEnd where none will ever come: a log played
  /// through `file://` has ended, a server has closed. What the handler throws comes out here.
  Received receive(std::chrono::milliseconds longest_wait);

  /// Whether messages wait until they are received, however long: those of a log played through `file://`.
  bool waits_for_receiver() const { return url_.starts_with("file"); }
  /// The URL in use.
  const std::string& url() const { return url_; }

 private:
  struct Subscription {
    LcmBus* bus;
    Handler handler;
  };
  static void on_message(const _lcm_recv_buf_t* message, const char* channel, void* subscription);

  struct Closer {
    void operator()(_lcm_t* lcm) const;
  };
  std::string url_;
  std::unique_ptr<_lcm_t, Closer> lcm_;
  std::vector<std::unique_ptr<Subscription>> subscriptions_;
  std::exception_ptr failure_;  ///< of a handler: LCM is C, nothing may be thrown through it
};

}  // namespace kt
