// Publishes the collector's results on an LCM network, from a thread of its own, without ever waiting for it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <variant>
#include <vector>

#include "onboard/publish/message_sink.h"
#include "shared/core/recycling.h"
#include "shared/wire/channels.h"
#include "shared/wire/lcm_bus.h"

namespace kt {

/// Who listens gets what the network carries; the log is what counts. Poses, status, load, closures and the
/// session go out at once, the session every few seconds again for who listens late. Slices and keyframes
/// wait in a queue and go out at a steady rate, a slice in parts of one datagram each, because receivers with
/// default buffers lose the rest of a burst (docs/lcm.md). Where the queue is full its oldest message is
/// dropped; its number stays free on the channel, so that receivers see the gap.
class LcmSink final : public MessageSink {
 public:
  struct Options {
    double bytes_per_second = 4e6;        ///< of slices and keyframes
    size_t max_queued_bytes = 64u << 20;  ///< of slices and keyframes that wait; the oldest go beyond it
    size_t max_queued_messages = 1024;    ///< of all others that wait; as above
    size_t max_part_vertices = 800;       ///< of a part of a slice: 43 bytes each
    size_t max_part_triangles = 1800;     ///< 12 bytes each
    std::chrono::milliseconds session_interval{5000};  ///< between repetitions of the session
    std::chrono::milliseconds longest_close{2000};     ///< what still waits then is dropped
  };
  struct Counts {
    int64_t messages = 0, bytes = 0;  ///< handed to the network
    int64_t dropped = 0;              ///< never sent: the queue was full or the mission over
    int64_t refused = 0;              ///< by the system: no route, no network
  };

  explicit LcmSink(std::shared_ptr<LcmBus> bus) : LcmSink(std::move(bus), Options{}) {}
  LcmSink(std::shared_ptr<LcmBus> bus, const Options& options);
  ~LcmSink() override;

  void on_session(SessionHeader session) override;
  /// With the BodyPose that follows from it.
  void on_pose(StampedPose pose) override;
  void on_slice(CloudSlice slice) override { put_large(std::move(slice)); }
  void on_keyframe(Keyframe keyframe) override { put_large(std::move(keyframe)); }
  void on_loop_closure(LoopClosure loop) override { put_small(std::move(loop)); }
  /// With the computer's temperature, read at most once a second, and what did not go out so far.
  void on_status(MissionStatus status) override;
  void on_load(LoadReport load) override { put_small(load); }
  /// The mission's input is not published: it would come back as input where that is the same network.
  void on_raw_frame(RgbdFrame) override {}
  void on_motion_sample(MotionSample) override {}
  /// Sends what waits, for longest_close at most.
  void close() override;

  /// So far; from any thread.
  Counts counts() const;

 private:
  using Small = std::variant<SessionHeader, StampedPose, LoopClosure, MissionStatus, LoadReport, BodyPose>;
  using Large = std::variant<CloudSlice, Keyframe>;
  using Clock = std::chrono::steady_clock;

  void put_small(Small message);
  void put_large(Large message);
  template <typename T>
  void drop();
  void run();
  template <typename IsDue>
  void wait(std::unique_lock<std::mutex>& lock, Clock::time_point until, const IsDue& is_due);
  void repeat_session();
  void send_small(std::unique_lock<std::mutex>& lock);
  void send_large(std::unique_lock<std::mutex>& lock);
  template <typename T>
  void send(const T& message, std::unique_lock<std::mutex>& lock);
  bool has_large() const { return !parts_.empty() || !large_.empty(); }

  std::shared_ptr<LcmBus> bus_;
  const Options options_;

  // Used by the caller's thread alone.
  int temperature_c_ = 0;  ///< as MissionStatus
  Clock::time_point next_temperature_{};
  std::optional<StampedPose> last_pose_;

  mutable std::mutex mutex_;  ///< guards all of the following
  std::condition_variable changed_;
  RecycledQueue<Small> small_;
  RecycledQueue<Large> large_;
  size_t large_bytes_ = 0;           ///< of large_
  RecycledQueue<CloudSlice> parts_;  ///< of the slice that is being sent
  Clock::time_point next_large_{};
  SessionHeader session_;  ///< changed by the caller's thread alone, which may read it without the lock
  Clock::time_point next_session_ = Clock::time_point::max();  ///< when it goes out again
  std::array<int64_t, kChannels.size()> next_sequence_{};
  Counts counts_;
  bool stopping_ = false;
  Clock::time_point stop_by_{};
  std::thread thread_;
};

}  // namespace kt
