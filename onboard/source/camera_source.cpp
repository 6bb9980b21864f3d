// The life of a camera in a mission.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/source/camera_source.h"

#include <algorithm>
#include <thread>
#include <utility>

#include "shared/core/check.h"

namespace kt {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kLongestSilence{2000}, kFirstPatience{500}, kMostPatience{8000}, kReport{1000};

// A gap in a counter that is longer is another numbering.
constexpr int64_t kMostDropped = 100'000;

template <typename Clock>
int64_t now_us() {
  return std::chrono::duration_cast<std::chrono::microseconds>(Clock::now().time_since_epoch()).count();
}

}  // namespace

CameraClock CameraClock::of_system() {
  return {now_us<std::chrono::system_clock>, now_us<std::chrono::steady_clock>,
          [](milliseconds time) { std::this_thread::sleep_for(time); }};
}

CameraSource::CameraSource(CameraOpener open, CameraClock clock)
    : open_(std::move(open)),
      clock_(std::move(clock)),
      camera_(open_()),
      info_(camera_->info()),
      pairing_(info_) {}

const Calibration& CameraSource::calibration() const {
  if (!info_.calibration) {
    throw Error(info_.name +
                ": the device does not tell its lenses, or how its two cameras stand to each other; name a "
                "calibration with --calibration " +
                "(docs/cameras.md says how to make one)");
  }
  return *info_.calibration;
}

SourceItem CameraSource::next() {
  while (ready_.empty()) {
    if (is_at_end_) return {};
    if (camera_) {
      read();
    } else {
      try_again();
    }
  }
  SourceItem item = std::move(ready_.front());
  ready_.pop_front();
  return item;
}

void CameraSource::read() {
  try {
    CameraEvent event = camera_->read(kLongestSilence);
    if (event.kind == CameraEvent::Kind::kEnd) {
      end({});
    } else if (event.kind != CameraEvent::Kind::kNothing) {
      take(std::move(event));
    } else {
      lose("no image for " + std::to_string(kLongestSilence.count() / 1000) + " s");
    }
  } catch (const Error& error) {
    lose(error.what());
  }
}

void CameraSource::take(CameraEvent event) {
  count_dropped(event);
  if (event.kind == CameraEvent::Kind::kDamaged) {
    if (event.is_depth) {
      skip(1, event.reason);
    } else {
      pairing_.add_damaged_colour(event.reason);
    }
    return;
  }
  if (!info_.is_recording) {
    const auto stamp =
        stamps_.stamp(event.is_depth ? 0 : 1, event.stamp_us, clock_.steady_us(), clock_.wall_us());
    // What waits for a partner by the old clock waits in vain.
    while (stamp.is_stepped) {
      auto item = pairing_.next_at_end();
      if (!item) break;
      ready_.push_back(std::move(*item));
    }
    event.stamp_us = stamp.us;
  }
  if (event.is_depth) {
    pairing_.add_depth(event.stamp_us, std::move(event.depth));
  } else {
    pairing_.add_colour(event.stamp_us, std::move(event.colour));
  }
  while (auto item = pairing_.next()) ready_.push_back(std::move(*item));
}

void CameraSource::count_dropped(const CameraEvent& event) {
  if (!event.is_depth) return;
  const int64_t dropped = last_counter_ ? event.counter - *last_counter_ - 1 : 0;
  if (dropped > 0 && dropped < kMostDropped) {
    skip(dropped, "dropped by the driver, or on its way from the camera");
    depth_images_ += dropped;
  }
  ++depth_images_;
  last_counter_ = event.counter;
}

void CameraSource::end(const std::string& why) {
  while (auto item = pairing_.next_at_end()) ready_.push_back(std::move(*item));
  const bool is_known = info_.frame_count >= 0;
  const int64_t missing = is_known ? info_.frame_count - depth_images_ : !why.empty();
  skip(std::min(missing, kMostDropped),
       "announced by the recording, which does not hold it" + (why.empty() ? "" : ": " + why));
  is_at_end_ = true;
}

void CameraSource::skip(int64_t count, const std::string& reason) {
  for (; count > 0; --count)
    ready_.push_back({.kind = SourceItem::Kind::kSkipped, .reason = info_.name + ": a frame was " + reason});
}

void CameraSource::lose(const std::string& reason) {
  while (auto item = pairing_.next_at_end()) ready_.push_back(std::move(*item));
  camera_.reset();
  if (info_.is_recording) return end(reason);
  pairing_ = FramePairing(info_);
  stamps_.interrupt();
  last_counter_.reset();
  gone_because_ = reason;
  patience_ = until_next_try_ = kFirstPatience;
  ready_.push_back({.kind = SourceItem::Kind::kInterrupted, .reason = info_.name + ": " + reason});
}

void CameraSource::try_again() {
  const milliseconds time = std::min(until_next_try_, kReport);
  clock_.wait(time);
  until_next_try_ -= time;
  if (until_next_try_.count() == 0) {
    try {
      camera_ = open_();
      return;
    } catch (const Error& error) {
      gone_because_ = error.what();
      until_next_try_ = patience_ = std::min(2 * patience_, kMostPatience);
    }
  }
  ready_.push_back({.kind = SourceItem::Kind::kInterrupted, .reason = info_.name + ": " + gone_because_});
}

}  // namespace kt
