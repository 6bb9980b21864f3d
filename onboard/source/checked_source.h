// Turns what is wrong with a frame or a motion sample into a skipped one with a reason: the one place where
// input is judged.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>

#include "onboard/source/frame_source.h"
#include "shared/core/recycling.h"

namespace kt {

/// Wraps a bare source. Skipped are frames that cannot be read, whose stamp is not after that of the frame
/// before, whose images differ in size from the calibration, or whose depth has no valid pixel. Frames that
/// pass are numbered from 0 without gaps.
///
/// The first frame, and one that comes more than 10 s after the frame before, waits for the next: where that
/// one's stamp lies more than 10 s before it, the waiting frame is skipped. So one wrong stamp costs one
/// frame, not all that follow; a real pause costs none but where the recording ends with it. What is skipped
/// meanwhile is told before the waiting frame.
///
/// Where the clock of the frames is set back by more than 1 s, the time goes on all the same: a frame that
/// lies so far back waits for the next too, and where that one goes on from it, both pass, in a time that
/// goes on 1 s behind the last frame's, behind the word kInterrupted: nobody knows how long it was. Else the
/// waiting frame is skipped.
///
/// Where the camera is gone, what waits is decided on as at the end, and told before the word of it.
///
/// Motion samples keep their place among the frames, so they wait for the next frame that passes. Skipped are
/// those with values that no message can hold (as a sample of the camera neither), that measure no motion, of
/// another kind than the first that passed or poses of another thing, with a stamp not after that of the
/// sample before, or more than 10 s after the frame that they wait for; behind the last frame the latter are
/// believed. They are no frames: the word is kSkippedMotion. Samples that pass are numbered from 0 without
/// gaps. Where no frame comes for minutes the oldest waiting samples are skipped.
class CheckedSource final : public FrameSource {
 public:
  /// `calibration`, where given, replaces the source's own. Throws kt::Error where the one used makes no
  /// sense.
  explicit CheckedSource(std::unique_ptr<FrameSource> source,
                         const std::optional<Calibration>& calibration = std::nullopt);

  SourceItem next() override;
  bool is_live() const override { return source_->is_live(); }
  int64_t frame_count() const override { return source_->frame_count(); }
  const Calibration& calibration() const override { return calibration_; }

 private:
  /// The source's next item with its images checked.
  SourceItem read();
  std::string image_problem(const RgbdFrame& frame) const;
  void judge_clock(RgbdFrame frame);
  void judge_stamp(RgbdFrame frame);
  bool judge_set_back(RgbdFrame& frame);
  void set_back_clock();
  void skip_set_back();
  void keep_sample(const MotionSample& sample);
  /// Decides on what waits at the end.
  void release_last();
  void accept(RgbdFrame frame);
  /// Hands out the samples that waited for a frame at this stamp.
  void release_samples(int64_t frame_us);
  std::string motion_problem(const MotionSample& sample, int64_t frame_us) const;

  std::unique_ptr<FrameSource> source_;
  Calibration calibration_;
  int64_t delivered_ = 0;
  std::optional<int64_t> last_us_;     ///< stamp of the last frame that passed
  std::optional<RgbdFrame> held_;      ///< waits for the next frame to confirm its stamp
  std::optional<RgbdFrame> set_back_;  ///< the same, of one that lies before the last
  int64_t clock_offset_us_ = 0;        ///< of the mission's time to the frames' clock
  RecycledQueue<MotionSample>
      samples_;  ///< read since the last frame that passed, before held_ and set_back_
  RecycledQueue<MotionSample> samples_behind_held_;
  int64_t delivered_samples_ = 0;
  std::optional<MotionSample> last_sample_;  ///< that passed
  RecycledQueue<SourceItem> ready_;  ///< judged but not yet handed out: three frames at most, and samples
};

}  // namespace kt
