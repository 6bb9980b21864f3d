// The checks every frame and motion sample passes before it reaches the collector.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/source/checked_source.h"

#include <algorithm>
#include <cstdlib>
#include <iterator>
#include <utility>

#include "shared/core/check.h"
#include "shared/core/recycling.h"
#include "shared/types/timestamp.h"
#include "shared/wire/validity.h"

namespace kt {
namespace {

// A pause longer than this is not believed before the next frame: a wrong stamp costs itself and no more.
constexpr int64_t kMaxJump_us = 10'000'000;

// Frames that lie less far back are late, or stamped by chance; a clock that is set back is set back by more.
constexpr int64_t kLeastSetBack_us = 1'000'000;

// From the last frame before a clock was set back to the first one after it, for want of knowledge.
constexpr int64_t kUnknownPause_us = 1'000'000;

// While a live source has no frames: minutes of an inertial unit's samples, more than the tracking keeps.
constexpr size_t kMaxWaitingSamples = 50'000;

std::string seconds(int64_t stamp_us) { return std::to_string(static_cast<double>(stamp_us) * 1e-6) + " s"; }

SourceItem skipped(const RgbdFrame& frame, const std::string& problem) {
  return {SourceItem::Kind::kSkipped, {}, "frame at " + seconds(frame.timestamp_us) + ": " + problem};
}

template <typename T>
std::string size_problem(const char* what, const Image<T>& image, const Camera& camera) {
  if (image.width() == camera.width && image.height() == camera.height) return {};
  const auto text = [](int width, int height) {
    return std::to_string(width) + " x " + std::to_string(height);
  };
  return std::string(what) + " image of " + text(image.width(), image.height()) + " pixels, calibrated for " +
         text(camera.width, camera.height) + "; name the right calibration with --calibration";
}

}  // namespace

CheckedSource::CheckedSource(std::unique_ptr<FrameSource> source,
                             const std::optional<Calibration>& calibration)
    : source_(std::move(source)), calibration_(calibration ? *calibration : source_->calibration()) {
  if (const std::string problem = calibration_.problem(); !problem.empty()) {
    throw Error("calibration '" + calibration_.name + "': " + problem);
  }
}

SourceItem CheckedSource::next() {
  while (ready_.empty()) {
    SourceItem item = read();
    switch (item.kind) {
      case SourceItem::Kind::kSkipped:
      case SourceItem::Kind::kSkippedMotion:
      case SourceItem::Kind::kNothingYet:
        return item;
      case SourceItem::Kind::kFrame:
        judge_clock(std::move(item.frame));
        break;
      case SourceItem::Kind::kMotion:
        item.motion.timestamp_us += clock_offset_us_;
        keep_sample(item.motion);
        break;
      case SourceItem::Kind::kInterrupted:
        release_last();
        ready_.push_back(std::move(item));
        break;
      case SourceItem::Kind::kEnd:
        release_last();
        if (ready_.empty()) return item;
        break;
    }
  }
  SourceItem item = std::move(ready_.front());
  ready_.pop_front();
  return item;
}

void CheckedSource::keep_sample(const MotionSample& sample) {
  RecycledQueue<MotionSample>& samples = held_ || set_back_ ? samples_behind_held_ : samples_;
  samples.push_back(sample);
  if (samples.size() <= kMaxWaitingSamples) return;
  ready_.push_back({.kind = SourceItem::Kind::kSkippedMotion,
                    .reason = "motion sample at " + seconds(samples.front().timestamp_us) +
                              ": no frame came for too long"});
  samples.pop_front();
}

SourceItem CheckedSource::read() {
  SourceItem item;
  try {
    item = source_->next();
  } catch (const Error& error) {
    return {SourceItem::Kind::kSkipped, {}, error.what()};
  }
  if (item.kind != SourceItem::Kind::kFrame) return item;
  if (const std::string problem = image_problem(item.frame); !problem.empty())
    return skipped(item.frame, problem);
  return item;
}

void CheckedSource::judge_clock(RgbdFrame frame) {
  if (std::max(frame.timestamp_us, frame.colour_timestamp_us) > kMaxTimestamp_us - clock_offset_us_) {
    ready_.push_back(skipped(frame, "its stamp is beyond all time"));
    return;
  }
  frame.timestamp_us += clock_offset_us_;
  frame.colour_timestamp_us += clock_offset_us_;
  if (!judge_set_back(frame)) judge_stamp(std::move(frame));
}

void CheckedSource::judge_stamp(RgbdFrame frame) {
  const int64_t stamp_us = frame.timestamp_us;
  if (held_ && !(last_us_ && stamp_us <= *last_us_)) {
    // The frame says whether the one before it was right: later, or the same stretch of time.
    RgbdFrame held = *std::exchange(held_, std::nullopt);
    if (stamp_us >= held.timestamp_us - kMaxJump_us) {
      accept(std::move(held));
    } else {
      ready_.push_back(skipped(held, "its stamp is wrong: the next frame's is " + seconds(stamp_us)));
    }
    std::move(samples_behind_held_.begin(), samples_behind_held_.end(), std::back_inserter(samples_));
    samples_behind_held_.clear();
  }
  if (last_us_ && stamp_us <= *last_us_) {
    ready_.push_back(skipped(frame, "its stamp is not after the last frame's, " + seconds(*last_us_)));
  } else if (!last_us_ || stamp_us - *last_us_ > kMaxJump_us) {
    held_ = std::move(frame);
  } else {
    accept(std::move(frame));
  }
}

// Whether a frame that lies far back, or the one behind it, is dealt with.
bool CheckedSource::judge_set_back(RgbdFrame& frame) {
  const int64_t stamp_us = frame.timestamp_us;
  if (set_back_ && stamp_us > set_back_->timestamp_us && stamp_us <= set_back_->timestamp_us + kMaxJump_us &&
      stamp_us <= *last_us_ && *last_us_ <= kMaxTimestamp_us - kMaxJump_us - kUnknownPause_us) {
    const int64_t before_us = clock_offset_us_;
    set_back_clock();
    frame.timestamp_us += clock_offset_us_ - before_us;
    frame.colour_timestamp_us += clock_offset_us_ - before_us;
    return false;
  }
  skip_set_back();
  if (!last_us_ || stamp_us >= *last_us_ - kLeastSetBack_us) return false;
  set_back_ = std::move(frame);
  return true;
}

// The frame that waits is right: what follows is of another clock.
void CheckedSource::set_back_clock() {
  RgbdFrame first = *std::exchange(set_back_, std::nullopt);
  if (held_) ready_.push_back(skipped(*std::exchange(held_, std::nullopt), "its stamp is wrong"));
  const int64_t last_us = *last_us_, first_us = first.timestamp_us;
  const int64_t step_us = last_us + kUnknownPause_us - first_us;
  clock_offset_us_ += step_us;
  RecycledQueue<MotionSample> waiting = std::exchange(samples_, {}),
                              behind = std::exchange(samples_behind_held_, {});
  std::move(behind.begin(), behind.end(), std::back_inserter(waiting));
  RecycledQueue<MotionSample> before_first, after_first;  // and in samples_ those of the old clock
  for (MotionSample& sample : waiting) {
    const bool is_old = std::abs(sample.timestamp_us - last_us) < std::abs(sample.timestamp_us - first_us);
    const bool is_after = sample.timestamp_us > first_us;
    if (!is_old) sample.timestamp_us += step_us;
    (is_old ? samples_ : is_after ? after_first : before_first).push_back(sample);
  }
  release_samples(last_us + kUnknownPause_us);
  ready_.push_back({.kind = SourceItem::Kind::kInterrupted,
                    .reason = "the clock of the frames was set back, from " + seconds(last_us) + " to " +
                              seconds(first_us)});
  samples_ = std::move(before_first);
  first.timestamp_us += step_us;
  first.colour_timestamp_us += step_us;
  accept(std::move(first));
  samples_ = std::move(after_first);
}

void CheckedSource::skip_set_back() {
  if (!set_back_) return;
  ready_.push_back(skipped(*std::exchange(set_back_, std::nullopt),
                           "its stamp is not after the last frame's, " + seconds(*last_us_)));
  if (held_) return;
  std::move(samples_behind_held_.begin(), samples_behind_held_.end(), std::back_inserter(samples_));
  samples_behind_held_.clear();
}

void CheckedSource::release_last() {
  skip_set_back();
  if (held_ && last_us_) {
    ready_.push_back(skipped(
        *held_, "no frame behind it confirms its stamp, far from the last frame's, " + seconds(*last_us_)));
  } else if (held_) {
    accept(*std::move(held_));  // the only frame
  }
  held_.reset();
  release_samples(kMaxTimestamp_us);
  samples_ = std::exchange(samples_behind_held_, {});
  release_samples(kMaxTimestamp_us);
}

void CheckedSource::release_samples(int64_t frame_us) {
  for (MotionSample& sample : samples_) {
    if (std::string problem = motion_problem(sample, frame_us); !problem.empty()) {
      ready_.push_back({.kind = SourceItem::Kind::kSkippedMotion,
                        .reason = "motion sample at " + seconds(sample.timestamp_us) + ": " + problem});
      continue;
    }
    sample.sequence = delivered_samples_++;
    last_sample_ = sample;
    ready_.push_back({.kind = SourceItem::Kind::kMotion, .motion = sample});
  }
  samples_.clear();
}

std::string CheckedSource::motion_problem(const MotionSample& sample, int64_t frame_us) const {
  // The mission goes on with it as one of the camera.
  for (const MotionSample& form : {sample, of_camera(sample, calibration_.T_body_camera)}) {
    if (const DecodeStatus status = validity(form); status != DecodeStatus::kOk)
      return std::string("its values are ") + to_string(status);
  }
  if (!sample.measures_motion()) return "it measures no motion";
  if (sample.timestamp_us > frame_us + kMaxJump_us)
    return "its stamp is wrong: the next frame's is " + seconds(frame_us);
  if (!last_sample_) return {};
  if (sample.kind != last_sample_->kind) return "its kind is not that of the samples before it";
  if (sample.kind == MotionSample::Kind::kPose && sample.of != last_sample_->of)
    return "it is not of the same, camera or body, as the poses before it, whose frame is another";
  if (sample.timestamp_us <= last_sample_->timestamp_us)
    return "its stamp is not after the last sample's, " + seconds(last_sample_->timestamp_us);
  return {};
}

void CheckedSource::accept(RgbdFrame frame) {
  release_samples(frame.timestamp_us);
  last_us_ = frame.timestamp_us;
  frame.sequence = delivered_++;
  ready_.push_back({SourceItem::Kind::kFrame, std::move(frame), {}});
}

std::string CheckedSource::image_problem(const RgbdFrame& frame) const {
  if (auto problem = size_problem("depth", frame.depth, calibration_.depth); !problem.empty()) return problem;
  if (!frame.colour.empty()) {
    if (auto problem = size_problem("colour", frame.colour, calibration_.colour); !problem.empty())
      return problem;
  }
  const auto depths = frame.depth.pixels();
  const bool sees_something = std::any_of(depths.begin(), depths.end(), [&](uint16_t depth) {
    return depth != 0 && depth != calibration_.invalid_depth;
  });
  return sees_something ? std::string() : "no valid depth";
}

}  // namespace kt
