// The one caller of the LCM library.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/wire/lcm_bus.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <lcm/lcm.h>
#include <poll.h>
#include <utility>

#include "shared/core/check.h"

namespace kt {
namespace {

constexpr std::string_view kDefaultUrl = "udpm://239.255.76.67:7667?ttl=0";
constexpr int64_t kReceiveBuffer = 8 << 20;  // ten raw frames: a busy moment of the reader

bool is_udp(const std::string& url) { return url.starts_with("udpm"); }

// LCM prints a warning where it gets less than it asks for.
int64_t granted_receive_buffer() {
  int64_t most = 0;
  std::ifstream("/proc/sys/net/core/rmem_max") >> most;
  return std::min(most, kReceiveBuffer);
}

std::string completed(std::string url) {
  if (url.empty()) {
    const char* from_environment = std::getenv("LCM_DEFAULT_URL");
    url = from_environment && *from_environment ? from_environment : std::string(kDefaultUrl);
  }
  const int64_t bytes = granted_receive_buffer();
  if (is_udp(url) && bytes > 0 && url.find("recv_buf_size") == std::string::npos)
    url += (url.find('?') == std::string::npos ? "?" : "&") + std::string("recv_buf_size=") +
           std::to_string(bytes);
  return url;
}

}  // namespace

void LcmBus::Closer::operator()(_lcm_t* lcm) const { lcm_destroy(lcm); }

LcmBus::LcmBus(const std::string& url) : url_(completed(url)), lcm_(lcm_create(url_.c_str())) {
  if (lcm_) return;
  throw Error("LCM cannot use the URL '" + url_ +
              "': is it written as udpm://239.255.76.67:7667?ttl=1, tcpq://HOST:PORT or file://PATH, and "
              "does the server run or the file exist?");
}

LcmBus::~LcmBus() = default;

bool LcmBus::publish(std::string_view channel, std::span<const uint8_t> data) {
  return lcm_publish(lcm_.get(), std::string(channel).c_str(), data.data(),
                     static_cast<unsigned>(data.size())) == 0;
}

void LcmBus::subscribe(std::string_view channel, int queued, Handler handler) {
  subscriptions_.push_back(std::make_unique<Subscription>(Subscription{this, std::move(handler)}));
  lcm_subscription_t* subscription = lcm_subscribe(lcm_.get(), std::string(channel).c_str(),
                                                   &LcmBus::on_message, subscriptions_.back().get());
  if (!subscription) {
    throw Error("LCM can receive nothing at '" + url_ +
                "': is there a route for multicast (ip route add 224.0.0.0/4 dev lo), and does the firewall "
                "let it through?");
  }
  lcm_subscription_set_queue_capacity(subscription, queued);
}

void LcmBus::on_message(const lcm_recv_buf_t* message, const char*, void* subscription) {
  const auto& [bus, handler] = *static_cast<Subscription*>(subscription);
  try {
    handler({static_cast<const uint8_t*>(message->data), message->data_size});
  } catch (...) {
    bus->failure_ = std::current_exception();
  }
}

LcmBus::Received LcmBus::receive(std::chrono::milliseconds longest_wait) {
  // Not lcm_handle_timeout: it would select() on a descriptor that a closed connection no longer has.
  pollfd ready{lcm_get_fileno(lcm_.get()), POLLIN, 0};
  if (ready.fd < 0) return Received::kEnd;
  if (poll(&ready, 1, static_cast<int>(longest_wait.count())) <= 0) return Received::kNothing;
  const bool handled = lcm_handle(lcm_.get()) == 0;
  if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
  if (handled) return Received::kMessage;
  return is_udp(url_) ? Received::kNothing : Received::kEnd;
}

}  // namespace kt
