// One datagram for each word to systemd.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/app/service_notifier.h"

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <string_view>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

namespace kt {
namespace {

// 0 where the variable holds no number above 0.
int64_t number_from_environment(const char* name) {
  const char* text = std::getenv(name);
  int64_t value = 0;
  if (text) std::from_chars(text, text + std::strlen(text), value);
  return std::max<int64_t>(value, 0);
}

int connected_socket(std::string_view path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() < 2 || path.size() >= sizeof(address.sun_path)) return -1;
  if (path.front() != '/' && path.front() != '@') return -1;
  path.copy(address.sun_path, path.size());
  if (path.front() == '@') address.sun_path[0] = '\0';  // of the abstract namespace
  const auto length = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + path.size());
  const int result = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (result >= 0 && ::connect(result, reinterpret_cast<const sockaddr*>(&address), length) != 0) {
    ::close(result);
    return -1;
  }
  constexpr timeval kLongestWait{.tv_sec = 1, .tv_usec = 0};
  ::setsockopt(result, SOL_SOCKET, SO_SNDTIMEO, &kLongestWait, sizeof(kLongestWait));
  return result;
}

}  // namespace

ServiceNotifier::ServiceNotifier() {
  if (const char* path = std::getenv("NOTIFY_SOCKET")) socket_ = connected_socket(path);
  const int64_t watched_process = number_from_environment("WATCHDOG_PID");
  if (watched_process != 0 && watched_process != ::getpid()) return;
  constexpr int kTimesAsOften = 4;
  watchdog_interval_ = std::chrono::microseconds(number_from_environment("WATCHDOG_USEC") / kTimesAsOften);
}

ServiceNotifier::~ServiceNotifier() {
  if (socket_ >= 0) ::close(socket_);
}

void ServiceNotifier::send(const std::string& text) {
  // A service manager that is gone or busy is not this program's trouble, and not much to wait for.
  if (socket_ >= 0) [[maybe_unused]]
    const ssize_t ignored = ::send(socket_, text.data(), text.size(), MSG_NOSIGNAL);
}

void ServiceNotifier::alive() {
  if (!is_ready_) {
    send("READY=1");
    next_status_ = {};  // what was said of the start is old now
  }
  is_ready_ = true;
  if (watchdog_interval_ == Clock::duration::zero()) return;
  const Clock::time_point now = Clock::now();
  if (now < next_watchdog_) return;
  send("WATCHDOG=1");
  next_watchdog_ = now + watchdog_interval_;
}

void ServiceNotifier::status(const std::string& text) {
  const Clock::time_point now = Clock::now();
  if (socket_ < 0 || now < next_status_ || text == last_status_) return;
  std::string line = text;
  std::replace(line.begin(), line.end(), '\n', ' ');
  send("STATUS=" + line);
  last_status_ = text;
  next_status_ = now + std::chrono::seconds(1);
}

void ServiceNotifier::stopping() { send("STOPPING=1"); }

}  // namespace kt
