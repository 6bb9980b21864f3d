// Frames and motion samples of other processes, live from an LCM network.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <chrono>
#include <optional>
#include <string>
#include <utility>

#include "onboard/source/bare_sources.h"
#include "shared/core/check.h"
#include "shared/core/recycling.h"
#include "shared/wire/codec.h"
#include "shared/wire/frame_codec.h"
#include "shared/wire/lcm_bus.h"
#include "shared/wire/message_reader.h"

namespace kt {
namespace {

using std::chrono::milliseconds;

constexpr std::chrono::seconds kLongestWaitForSession{30};
constexpr int64_t kMaxGap =
    10'000;  // five minutes of frames: a longer gap is some other publisher's numbering
constexpr int kQueuedFrames = 30, kQueuedSamples = 1024, kQueuedSessions = 4;
constexpr size_t kMostArrivals = 4096;  // a flood of samples is left to LCM's own limits

/// Follows the sequence numbers of one channel. Each lost message is told once: as damaged when it came so,
/// else with the next intact one.
class Gaps {
 public:
  /// The numbering begins at 0: what comes with a later number has losses before it.
  void begin() { expected_ = expected_.value_or(0); }
  void count_damaged() { ++damaged_; }
  /// How many messages were lost between the last one and this. A number below the expected one begins anew.
  int64_t before(int64_t sequence) {
    const int64_t gap = expected_ && sequence > *expected_ ? sequence - *expected_ : 0;
    const int64_t damaged = std::exchange(damaged_, 0);
    expected_ = sequence == INT64_MAX ? sequence : sequence + 1;
    return gap > kMaxGap ? 0 : std::max<int64_t>(0, gap - damaged);
  }

 private:
  std::optional<int64_t> expected_;
  int64_t damaged_ = 0;
};

/// Turns what arrives into items, in the order of arrival; trusts nothing. Where frames come faster
/// than they can be decompressed the oldest is dropped, as FrameQueue does behind, and told as skipped.
class Intake {
 public:
  Intake(std::shared_ptr<LcmBus> bus, std::string name, milliseconds longest_wait)
      : bus_(std::move(bus)), name_(std::move(name)), longest_wait_(longest_wait) {
    listen<SessionHeader>(kQueuedSessions, [](DecodeStatus) {});  // one that counts will come whole
    listen<MotionSample>(kQueuedSamples, [this](DecodeStatus problem) {
      samples_.count_damaged();
      add(SourceItem::Kind::kSkippedMotion, damage_text("motion sample", problem));
    });
    listen<CompressedFrame>(kQueuedFrames, [this](DecodeStatus problem) {
      frames_.count_damaged();
      add(SourceItem::Kind::kSkipped, damage_text("raw frame", problem));
    });
  }

  SourceItem next() {
    take_what_came();
    if (arrivals_.empty())
      return {.kind = has_ended_ ? SourceItem::Kind::kEnd : SourceItem::Kind::kNothingYet};
    if (--arrivals_.front().times > 0) return arrivals_.front().item;
    Arrival arrival = std::move(arrivals_.front());
    arrivals_.pop_front();
    if (arrival.item.kind == SourceItem::Kind::kFrame) {
      --waiting_frames_;
      arrival.item.frame = decompress(arrival.frame);
    }
    return std::move(arrival).item;
  }

  bool is_live() const { return !bus_->waits_for_receiver(); }

  /// Waits for it. What arrives before it belongs to nothing.
  const Calibration& calibration() {
    const auto until = std::chrono::steady_clock::now() + kLongestWaitForSession;
    while (!calibration_ && !has_ended_ && std::chrono::steady_clock::now() < until) {
      has_ended_ = bus_->receive(longest_wait_) == LcmBus::Received::kEnd;
      if (calibration_) break;
      arrivals_.clear();
      waiting_frames_ = 0;
    }
    if (!calibration_) {
      throw Error(
          name_ + ": no " + std::string(channel_of<SessionHeader>()) +
          " came within 30 s, and with it no calibration: is the publisher of the frames running, at " +
          bus_->url() + "? Else name the camera with --calibration");
    }
    heeds_sessions_ = true;
    return *calibration_;
  }

 private:
  /// Something that arrived, or is known not to have; frames are decompressed when they are handed out.
  struct Arrival {
    SourceItem item;
    int64_t times = 1;
    CompressedFrame frame{};
  };

  // All that LCM holds: its own queue keeps the oldest messages and loses the newest.
  void take_what_came() {
    for (size_t i = 0; i < kMostArrivals && arrivals_.size() < kMostArrivals && !has_ended_; ++i) {
      if (!arrivals_.empty() && bus_->waits_for_receiver()) return;
      const auto received = bus_->receive(arrivals_.empty() ? longest_wait_ : milliseconds(0));
      if (received == LcmBus::Received::kNothing) return;
      has_ended_ = received == LcmBus::Received::kEnd;
    }
  }

  template <typename T, typename OnDamage>
  void listen(int queued, OnDamage on_damage) {
    bus_->subscribe(channel_of<T>(), queued, [this, on_damage](std::span<const uint8_t> bytes) {
      T message;
      const DecodeStatus problem = decode(bytes, message);
      if (problem != DecodeStatus::kOk) return on_damage(problem);
      take(std::move(message), stamp_of(bytes).sequence);
    });
  }

  void take(SessionHeader session, int64_t sequence) {
    check_format_version(session, name_);
    if (sequence == 0) frames_.begin(), samples_.begin();  // we hear it from its beginning
    if (!heeds_sessions_) {
      calibration_ = session.calibration;
    } else {
      is_foreign_ = !calibration_->is_equal_to(session.calibration);
    }
  }
  void take(MotionSample sample, int64_t sequence) {
    add_lost(SourceItem::Kind::kSkippedMotion, samples_.before(sequence), "motion sample", sequence);
    arrivals_.push_back({.item = {.kind = SourceItem::Kind::kMotion, .motion = std::move(sample)}});
  }
  void take(CompressedFrame frame, int64_t sequence) {
    add_lost(SourceItem::Kind::kSkipped, frames_.before(sequence), "raw frame", sequence);
    if (is_foreign_) {
      return add(SourceItem::Kind::kSkipped,
                 name_ + ": raw frame number " + std::to_string(sequence) +
                     " is of another calibration than the first, as the session before it says");
    }
    arrivals_.push_back({.item = {.kind = SourceItem::Kind::kFrame}, .frame = std::move(frame)});
    if (++waiting_frames_ > kQueuedFrames) drop_oldest_frame();
  }
  void drop_oldest_frame() {
    const auto oldest = std::find_if(arrivals_.begin(), arrivals_.end(), [](const Arrival& arrival) {
      return arrival.item.kind == SourceItem::Kind::kFrame;
    });
    *oldest = {.item = {.kind = SourceItem::Kind::kSkipped,
                        .reason = name_ + ": the mission is late, a raw frame was dropped"}};
    --waiting_frames_;
  }

  void add(SourceItem::Kind kind, const std::string& reason, int64_t times = 1) {
    if (times > 0) arrivals_.push_back({.item = {.kind = kind, .reason = reason}, .times = times});
  }
  void add_lost(SourceItem::Kind kind, int64_t count, const char* what, int64_t sequence) {
    add(kind, name_ + ": a " + what + " before number " + std::to_string(sequence) + " did not arrive",
        count);
  }
  std::string damage_text(const char* what, DecodeStatus problem) const {
    return name_ + ": a " + what + " is not what it should be (" + to_string(problem) + ")";
  }

  std::shared_ptr<LcmBus> bus_;
  std::string name_;
  milliseconds longest_wait_;
  RecycledQueue<Arrival> arrivals_;  ///< not yet handed out
  int waiting_frames_ = 0;           ///< among them
  Gaps frames_, samples_;
  std::optional<Calibration> calibration_;
  bool heeds_sessions_ = false;  ///< the calibration in use is the one of the bus
  bool is_foreign_ = false;      ///< the last session was of another calibration
  bool has_ended_ = false;
};

class LcmSource final : public FrameSource {
 public:
  LcmSource(std::shared_ptr<LcmBus> bus, std::string name, milliseconds longest_wait)
      : intake_(std::make_unique<Intake>(std::move(bus), std::move(name), longest_wait)) {}

  SourceItem next() override { return intake_->next(); }
  bool is_live() const override { return intake_->is_live(); }
  int64_t frame_count() const override { return -1; }
  const Calibration& calibration() const override { return intake_->calibration(); }

 private:
  std::unique_ptr<Intake> intake_;
};

}  // namespace

std::unique_ptr<FrameSource> open_lcm_source(std::shared_ptr<LcmBus> bus, const std::string& name,
                                             milliseconds longest_wait) {
  return std::make_unique<LcmSource>(std::move(bus), name, longest_wait);
}

std::unique_ptr<FrameSource> open_lcm_source(const std::string& url) {
  return open_lcm_source(std::make_shared<LcmBus>(url), "lcm:" + url);
}

}  // namespace kt
