// Frames and motion samples recorded earlier: those messages of a log.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "onboard/source/bare_sources.h"
#include "shared/core/check.h"
#include "shared/core/recycling.h"
#include "shared/wire/frame_codec.h"
#include "shared/wire/message_reader.h"

namespace kt {
namespace {

constexpr int64_t kMaxLost = 100'000;  // an hour of frames: a longer gap is some other recording's numbering

class LogSource final : public FrameSource {
 public:
  explicit LogSource(const std::filesystem::path& path) : name_(path.string()), reader_(path) {
    reader_.skip<StampedPose>();
    reader_.skip<CloudSlice>();
    reader_.skip<Keyframe>();
    reader_.skip<LoopClosure>();
    if (!read_frame()) {
      throw Error(name_ + (frames().damaged > 0
                               ? ": all of its raw frames are damaged"
                               : ": holds no raw frames; record them with kintsugi-collect --record-raw"));
    }
  }

  SourceItem next() override {
    if (before_.empty() && !frame_ && !at_end_) read_frame();
    if (!before_.empty()) {
      SourceItem item = std::move(before_.front());
      before_.pop_front();
      return item;
    }
    if (lost_ > 0) {
      --lost_;
      return {SourceItem::Kind::kSkipped, {}, reason_};
    }
    if (!frame_) return {};
    const CompressedFrame frame = *std::exchange(frame_, std::nullopt);
    SourceItem item{SourceItem::Kind::kFrame, decompress(frame), {}};
    item.frame.effort = effort_;
    return item;
  }
  int64_t frame_count() const override { return -1; }
  const Calibration& calibration() const override {
    if (!calibration_) {
      throw Error(name_ + ": its session event is lost, and with it the calibration: name the camera with " +
                  "--calibration");
    }
    return *calibration_;
  }

 private:
  const MessageReader::ChannelCount& frames() const {
    return reader_.channels()[message_index<CompressedFrame>()];
  }

  void add_motion(const MotionSample& sample) {
    const int64_t missing = reader_.channels()[message_index<MotionSample>()].missing;
    for (int64_t lost = std::min(missing - std::exchange(missing_motion_, missing), kMaxLost); lost > 0;
         --lost) {
      before_.push_back({.kind = SourceItem::Kind::kSkippedMotion,
                         .reason = name_ + ": a motion sample before number " +
                                   std::to_string(sample.sequence) + " is damaged or missing"});
    }
    before_.push_back({.kind = SourceItem::Kind::kMotion, .motion = sample});
  }

  // Reads up to the next intact frame, keeps what else the mission must know on the way, and notes how many
  // frames were lost; false at the end.
  bool read_frame() {
    const int64_t missing = frames().missing, damaged = frames().damaged;
    const LogIntegrity before = reader_.integrity();
    while (const std::optional<Message> message = reader_.next()) {
      if (const auto* session = std::get_if<SessionHeader>(&*message)) {
        check_format_version(*session, name_);
        calibration_ = session->calibration;
      } else if (const auto* sample = std::get_if<MotionSample>(&*message)) {
        add_motion(*sample);
      } else if (const auto* status = std::get_if<MissionStatus>(&*message)) {
        // The camera was gone then: the mission that is played again must know it.
        if (status->cause == TrackingCause::kNoFrames)
          before_.push_back({.kind = SourceItem::Kind::kInterrupted, .reason = name_ + ": no frames"});
      } else if (const auto* load = std::get_if<LoadReport>(&*message)) {
        effort_ = load->effort;
      } else if (const auto* frame = std::get_if<CompressedFrame>(&*message)) {
        frame_ = *frame;
        // The gap in the sequence numbers holds the damaged ones too.
        lost_ = std::min(frames().missing - missing, kMaxLost);
        reason_ = name_ + ": a raw frame before number " + std::to_string(frame->sequence) +
                  " is damaged or missing";
        return true;
      }
    }
    at_end_ = true;
    const LogIntegrity after = reader_.integrity();
    lost_ = frames().damaged - damaged + (after.truncated || after.skipped_bytes > before.skipped_bytes);
    reason_ = name_ + ": its end is damaged or cut off, perhaps in a raw frame";
    return false;
  }

  std::string name_;
  MessageReader reader_;
  std::optional<CompressedFrame> frame_;  ///< read but not yet handed out
  RecycledQueue<SourceItem> before_;      ///< read before it, to be handed out first
  int64_t missing_motion_ = 0;            ///< as the reader counts them, so far
  int64_t lost_ = 0;                      ///< frames before it, or before the end, still to be reported
  std::string reason_;                    ///< of those
  Effort effort_ = Effort::kFull;         ///< of the frames from here on
  bool at_end_ = false;
  std::optional<Calibration> calibration_;
};

}  // namespace

std::unique_ptr<FrameSource> open_log_source(const std::filesystem::path& path) {
  return std::make_unique<LogSource>(path);
}

}  // namespace kt
