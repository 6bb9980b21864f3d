// Tells systemd how the collector is: ready, alive, stopping, and a line of status (sd_notify(3)).
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <string>

namespace kt {

/// Speaks the protocol to the socket that $NOTIFY_SOCKET names; without one, or where it cannot be reached,
/// every call does nothing. Not to be shared by threads.
class ServiceNotifier {
 public:
  /// Reads $NOTIFY_SOCKET, and $WATCHDOG_USEC and $WATCHDOG_PID where systemd watches this process.
  ServiceNotifier();
  ~ServiceNotifier();
  ServiceNotifier(const ServiceNotifier&) = delete;
  ServiceNotifier& operator=(const ServiceNotifier&) = delete;

  /// Whether anybody listens.
  bool is_connected() const { return socket_ >= 0; }

  /// The service works: READY=1 the first time, then WATCHDOG=1, four times as often as systemd wants it at
  /// most, however often this is called.
  void alive();
  /// One line for `systemctl status`; at most one a second is sent, and the same one not again.
  void status(const std::string& text);
  /// It has begun to end: what takes its time now is not watched any more.
  void stopping();

 private:
  using Clock = std::chrono::steady_clock;
  void send(const std::string& text);

  int socket_ = -1;
  bool is_ready_ = false;
  Clock::duration watchdog_interval_{};  ///< zero: nobody watches
  Clock::time_point next_watchdog_{}, next_status_{};
  std::string last_status_;
};

}  // namespace kt
