// A sink that remembers what the collector published, and a source made of a list.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <string>
#include <vector>

#include "onboard/publish/message_sink.h"
#include "onboard/source/frame_source.h"
#include "tests/support/analytic_scene.h"

namespace kt::test {

struct RecordingSink : MessageSink {
  std::vector<std::string> calls;  ///< in order, without the prefix "on_"
  std::vector<SessionHeader> sessions;
  std::vector<StampedPose> poses;
  std::vector<CloudSlice> slices;
  std::vector<MissionStatus> statuses;
  std::vector<RgbdFrame> raw_frames;
  std::vector<MotionSample> motion_samples;
  std::vector<LoadReport> loads;
  bool is_closed = false;

  void on_session(SessionHeader session) override { record("session", sessions, std::move(session)); }
  void on_pose(StampedPose pose) override { record("pose", poses, std::move(pose)); }
  void on_slice(CloudSlice slice) override { record("slice", slices, std::move(slice)); }
  void on_keyframe(Keyframe) override { calls.push_back("keyframe"); }
  void on_loop_closure(LoopClosure) override { calls.push_back("loop_closure"); }
  void on_status(MissionStatus status) override { record("status", statuses, std::move(status)); }
  void on_raw_frame(RgbdFrame frame) override { record("raw_frame", raw_frames, std::move(frame)); }
  void on_motion_sample(MotionSample sample) override {
    record("motion_sample", motion_samples, std::move(sample));
  }
  void on_load(LoadReport load) override { record("load", loads, load); }
  void close() override {
    calls.push_back("close");
    is_closed = true;
  }

 private:
  template <typename T>
  void record(const char* name, std::vector<T>& list, T message) {
    calls.push_back(name);
    list.push_back(std::move(message));
  }
};

inline SourceItem frame_item(RgbdFrame frame) {
  return {.kind = SourceItem::Kind::kFrame, .frame = std::move(frame)};
}
inline SourceItem skipped_item(const std::string& reason) {
  return {.kind = SourceItem::Kind::kSkipped, .reason = reason};
}
inline SourceItem motion_item(const MotionSample& sample) {
  return {.kind = SourceItem::Kind::kMotion, .motion = sample};
}

/// Hands out its items, then throws `failure` where there is one, else says kEnd for ever.
class ListSource final : public FrameSource {
 public:
  explicit ListSource(std::vector<SourceItem> items, std::string failure = "")
      : items_(std::move(items)), failure_(std::move(failure)) {}

  SourceItem next() override {
    const size_t i = delivered_++;
    if (i < items_.size()) return items_[i];
    if (!failure_.empty()) throw Error(failure_);
    return {};
  }
  int64_t frame_count() const override { return static_cast<int64_t>(items_.size()); }
  const Calibration& calibration() const override { return calibration_; }
  bool is_live() const override { return is_live_; }

  /// Before it is read.
  void make_live() { is_live_ = true; }
  size_t delivered() const { return delivered_; }

 private:
  std::vector<SourceItem> items_;
  std::string failure_;
  bool is_live_ = false;
  Calibration calibration_ = small_calibration();
  std::atomic<size_t> delivered_ = 0;
};

}  // namespace kt::test
