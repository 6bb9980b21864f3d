// What a service manager hears of a mission: a socket as systemd's, and missions that live, wait and hang.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/app/service_notifier.h"

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdlib>
#include <future>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mutex>
#include <sys/socket.h>
#include <sys/un.h>
#include <thread>
#include <unistd.h>

#include "onboard/app/mission.h"
#include "tests/onboard/app/recording_sink.h"
#include "tests/onboard/app/small_mission.h"
#include "tests/support/test_files.h"

namespace kt::test {
namespace {

using std::chrono::milliseconds;
using testing::ElementsAre;

/// systemd's end of the socket.
class Manager {
 public:
  explicit Manager(const std::string& name) : socket_(::socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    name.copy(address.sun_path, sizeof(address.sun_path) - 1);
    if (name[0] == '@') address.sun_path[0] = '\0';
    const auto length = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + name.size());
    EXPECT_EQ(::bind(socket_, reinterpret_cast<sockaddr*>(&address), length), 0);
    ::setenv("NOTIFY_SOCKET", name.c_str(), 1);
  }
  ~Manager() {
    ::close(socket_);
    for (const char* name : {"NOTIFY_SOCKET", "WATCHDOG_USEC", "WATCHDOG_PID"}) ::unsetenv(name);
  }
  std::vector<std::string> heard() const {
    std::vector<std::string> messages;
    char text[512];
    for (ssize_t size; (size = ::recv(socket_, text, sizeof(text), 0)) >= 0;)
      messages.emplace_back(text, static_cast<size_t>(size));
    return messages;
  }

 private:
  int socket_;
};

TEST(ServiceNotifier, SaysReadyOnceAndFeedsTheWatchdog) {
  const ScratchDir folder;
  const Manager manager((folder / "notify").string());
  ::setenv("WATCHDOG_USEC", "4000000000", 1);
  ServiceNotifier service;
  service.alive();
  service.alive();  // not yet due again
  EXPECT_THAT(manager.heard(), ElementsAre("READY=1", "WATCHDOG=1"));
  service.stopping();
  EXPECT_THAT(manager.heard(), ElementsAre("STOPPING=1"));
}

TEST(ServiceNotifier, FeedsTheWatchdogAgainWhenItIsDue) {
  const ScratchDir folder;
  const Manager manager((folder / "notify").string());
  ::setenv("WATCHDOG_USEC", "4000", 1);
  ServiceNotifier service;
  service.alive();
  std::this_thread::sleep_for(milliseconds(5));
  service.alive();
  EXPECT_THAT(manager.heard(), ElementsAre("READY=1", "WATCHDOG=1", "WATCHDOG=1"));
}

TEST(ServiceNotifier, TheWatchdogOfAnotherProcessIsNotFed) {
  const Manager manager("@kintsugi-test-" + std::to_string(::getpid()));  // of the abstract namespace
  ::setenv("WATCHDOG_USEC", "40000", 1);
  ::setenv("WATCHDOG_PID", "1", 1);
  ServiceNotifier service;
  service.alive();
  EXPECT_THAT(manager.heard(), ElementsAre("READY=1"));
}

TEST(ServiceNotifier, StatusIsOneLineAndNotAFlood) {
  const ScratchDir folder;
  const Manager manager((folder / "notify").string());
  ServiceNotifier service;
  service.status("frame 1\nREADY=1");
  for (int i = 0; i < 1000; ++i) service.status("frame " + std::to_string(i));
  const std::vector<std::string> heard = manager.heard();
  EXPECT_EQ(heard.front(), "STATUS=frame 1 READY=1");
  EXPECT_LT(heard.size(), 10u);
}

TEST(ServiceNotifier, WithoutAManagerItIsSilent) {
  ::unsetenv("NOTIFY_SOCKET");
  ServiceNotifier nobody;
  EXPECT_FALSE(nobody.is_connected());
  nobody.alive();
  ::setenv("NOTIFY_SOCKET", "/no/such/socket", 1);
  ServiceNotifier gone;
  gone.alive();
  gone.status("fine");
  ::setenv("NOTIFY_SOCKET", "vsock:2:1234", 1);  // a kind that we do not speak
  EXPECT_FALSE(ServiceNotifier().is_connected());
  ::unsetenv("NOTIFY_SOCKET");
}

RgbdFrame sliding_frame(int i) {
  return render(furnished_room(), small_calibration(), pose_of({0, 0, 0}, {0.01 * i, 0, 0}), {.sequence = i});
}

// Without frames as with them: a missing camera is no reason to restart.
TEST(MissionLife, GoesOnWhileTheCameraIsGone) {
  std::vector<SourceItem> items = {frame_item(sliding_frame(0))};
  for (int i = 0; i < 20; ++i)
    items.push_back(
        {.kind = i % 2 ? SourceItem::Kind::kInterrupted : SourceItem::Kind::kNothingYet, .reason = "gone"});
  ListSource source(items);
  RecordingSink sink;
  MissionOptions options = small_mission();
  int alive = 0, ending = 0;
  options.on_alive = [&] { ++alive; };
  options.on_ending = [&] {
    ++ending;
    EXPECT_FALSE(sink.is_closed) << "what is left is logged after it";
  };
  run_mission(source, sink, options);
  // The frame, ten interruptions and the end; kNothingYet may be passed over where something else waits.
  EXPECT_GE(alive, 12);
  EXPECT_EQ(ending, 1);
}

/// A disk that has stopped to answer.
struct HungSink final : MessageSink {
  std::mutex mutex;
  std::condition_variable changed;
  bool is_reached = false, is_released = false;

  void on_session(SessionHeader) override {}
  void on_pose(StampedPose) override {
    std::unique_lock lock(mutex);
    is_reached = true;
    changed.notify_all();
    changed.wait(lock, [this] { return is_released; });
  }
  void on_slice(CloudSlice) override {}
  void on_keyframe(Keyframe) override {}
  void on_loop_closure(LoopClosure) override {}
  void on_status(MissionStatus) override {}
  void on_raw_frame(RgbdFrame) override {}
  void on_motion_sample(MotionSample) override {}
  void on_load(LoadReport) override {}
  void close() override {}
};

TEST(MissionLife, EndsWhereThePipelineHangs) {
  ListSource source(
      {frame_item(sliding_frame(0)), frame_item(sliding_frame(1)), frame_item(sliding_frame(2))});
  HungSink sink;
  MissionOptions options = small_mission();
  std::atomic<int> alive = 0;
  options.on_alive = [&] { ++alive; };
  auto mission = std::async(std::launch::async, [&] { run_mission(source, sink, options); });
  {
    std::unique_lock lock(sink.mutex);
    sink.changed.wait(lock, [&] { return sink.is_reached; });
  }
  std::this_thread::sleep_for(milliseconds(50));
  EXPECT_EQ(alive.load(), 1) << "only before the first frame";
  {
    const std::lock_guard lock(sink.mutex);
    sink.is_released = true;
  }
  sink.changed.notify_all();
  mission.get();
  EXPECT_EQ(alive.load(), 4);
}

}  // namespace
}  // namespace kt::test
