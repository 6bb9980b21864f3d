// Feeds the live state from a bus or a log, and draws it.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/log/watch.h"

#include <chrono>
#include <functional>
#include <memory>
#include <sys/ioctl.h>
#include <thread>
#include <unistd.h>

#include "shared/core/check.h"
#include "shared/core/formatted.h"
#include "shared/core/temperature.h"
#include "shared/wire/codec.h"
#include "shared/wire/lcm_bus.h"
#include "tools/log/live_state.h"
#include "tools/log/log_tail.h"

namespace kt {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr double kLongSilence_s = 3;
constexpr milliseconds kLongestWait{100};  // until a signal is seen

/// Where the state comes from.
struct Feed {
  std::function<void(LiveState&)> wait;  ///< for what comes, at most kLongestWait
  std::function<std::string()> name;
  std::string remedy;  ///< where nothing comes
};

template <typename T>
void listen(LcmBus& bus, LiveState*& state, int queued) {
  bus.subscribe(channel_of<T>(), queued, [&state](std::span<const uint8_t> bytes) {
    T message;
    if (decode(bytes, message) == DecodeStatus::kOk) state->add(std::move(message), Clock::now());
  });
}

Feed bus_feed(const std::string& url) {
  struct Listener {
    explicit Listener(const std::string& address) : bus(address) {}
    LcmBus bus;
    LiveState* state = nullptr;
  };
  const auto listener = std::make_shared<Listener>(url);
  listen<SessionHeader>(listener->bus, listener->state, 4);
  listen<StampedPose>(listener->bus, listener->state, 300);
  listen<MissionStatus>(listener->bus, listener->state, 300);
  const auto wait = [listener](LiveState& state) {
    listener->state = &state;
    const Clock::time_point end = Clock::now() + kLongestWait;
    while (Clock::now() < end) {
      const auto received = listener->bus.receive(kLongestWait);
      if (received == LcmBus::Received::kNothing) return;
      if (received == LcmBus::Received::kEnd) return std::this_thread::sleep_for(kLongestWait);
    }
  };
  return {
      wait, [listener] { return listener->bus.url(); },
      "does the collector run with --publish, is its URL this one, and does multicast have a route (ip route "
      "add 224.0.0.0/4 dev lo; from another machine ttl=1)?"};
}

Feed log_feed(const std::string& path) {
  const auto tail = std::make_shared<LogTail>(path);
  const auto wait = [tail](LiveState& state) {
    const Clock::time_point now = Clock::now();
    tail->read_new([&](const Message& message) { state.add(message, now); });
    state.set_disk(tail->log_bytes(), tail->free_bytes(), now);
    if (const auto degrees = hottest_temperature_c()) state.set_temperature_here(*degrees);
    std::this_thread::sleep_for(kLongestWait);
  };
  return {wait, [tail, path] { return tail->log().empty() ? path : tail->log().string(); },
          "the log does not grow: does the collector run, and is this its log?"};
}

/// Draws over what it drew before.
class Screen {
 public:
  explicit Screen(std::FILE* out) : out_(out), is_terminal_(::isatty(::fileno(out)) != 0) {}
  bool is_terminal() const { return is_terminal_; }

  void draw(const std::vector<std::string>& lines) {
    if (drawn_ > 0) std::fprintf(out_, "\x1b[%zuA", drawn_);
    const int columns = width();
    for (const std::string& line : lines) std::fprintf(out_, "\r%.*s\x1b[K\n", columns, line.c_str());
    std::fputs("\x1b[J", out_);
    std::fflush(out_);
    drawn_ = lines.size();
  }
  void print(const std::string& line) {
    std::fprintf(out_, "%s\n", line.c_str());
    std::fflush(out_);
  }

 private:
  int width() const {
    winsize size{};
    constexpr int kUsual = 80;
    const bool is_told = ::ioctl(::fileno(out_), TIOCGWINSZ, &size) == 0 && size.ws_col > 1;
    return (is_told ? size.ws_col : kUsual) - 1;  // a line that wraps cannot be drawn over
  }

  std::FILE* out_;
  bool is_terminal_;
  size_t drawn_ = 0;  ///< lines
};

std::string silence_text(const Feed& feed, double silence_s) {
  return formatted("nothing for %.0f s from ", silence_s) + feed.name() + ": " + feed.remedy;
}

void show(Screen& screen, const LiveState& state, const Feed& feed, Clock::time_point start) {
  const Clock::time_point now = Clock::now();
  const double silence_s = state.silence_s(start, now);
  const bool is_silent = silence_s >= kLongSilence_s;
  if (screen.is_terminal()) {
    std::vector<std::string> lines = {feed.name()};
    if (state.has_heard())
      for (std::string& line : state.lines(now)) lines.push_back(std::move(line));
    if (is_silent) lines.push_back(silence_text(feed, silence_s));
    if (!is_silent && !state.has_heard()) lines.push_back("listening");
    screen.draw(lines);
  } else if (is_silent || !state.has_heard()) {
    screen.print(is_silent ? silence_text(feed, silence_s) : "listening to " + feed.name());
  } else {
    screen.print(state.line(now));
  }
}

}  // namespace

void watch(const WatchOptions& options, const std::atomic<bool>& stop, std::FILE* out) {
  const Feed feed = options.log.empty() ? bus_feed(options.url) : log_feed(options.log);
  Screen screen(out);
  LiveState state;
  const milliseconds interval(screen.is_terminal() ? 250 : 1000);
  const Clock::time_point start = Clock::now();
  Clock::time_point next_show = start;
  const auto is_over = [&] {
    const std::chrono::duration<double> time = Clock::now() - start;
    return stop || (options.seconds > 0 && time.count() >= options.seconds);
  };
  while (!is_over()) {
    feed.wait(state);
    if (std::ferror(out) != 0) return;  // nobody reads any more; whoever called says so
    if (Clock::now() < next_show) continue;
    show(screen, state, feed, start);
    next_show += interval;
  }
  if (!stop && !state.has_heard()) throw Error("nothing came from " + feed.name() + ": " + feed.remedy);
}

}  // namespace kt
