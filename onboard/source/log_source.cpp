// Frames recorded earlier: the raw-frame messages of a log.
// SPDX-License-Identifier: BSD-3-Clause
#include <optional>
#include <utility>
#include <variant>

#include "onboard/source/bare_sources.h"
#include "shared/core/check.h"
#include "shared/wire/frame_codec.h"
#include "shared/wire/message_reader.h"

namespace kt {
namespace {

class LogSource final : public FrameSource {
 public:
  explicit LogSource(const std::filesystem::path& path) : reader_(path) {
    reader_.skip<StampedPose>();
    reader_.skip<CloudSlice>();
    reader_.skip<Keyframe>();
    reader_.skip<LoopClosure>();
    reader_.skip<MissionStatus>();
    bool has_session = false;
    while (!pending_) {
      std::optional<Message> message = reader_.next();
      if (!message)
        throw Error(path.string() + ": holds no raw frames; record them with kintsugi-collect --record-raw");
      if (auto* session = std::get_if<SessionHeader>(&*message)) {
        calibration_ = session->calibration;
        has_session = true;
      } else if (auto* frame = std::get_if<CompressedFrame>(&*message)) {
        pending_ = std::move(*frame);
      }
    }
    if (!has_session)
      throw Error(path.string() + ": its session message is lost, and with it the calibration");
  }

  SourceItem next() override {
    while (!pending_) {
      std::optional<Message> message = reader_.next();
      if (!message) return {};
      if (auto* frame = std::get_if<CompressedFrame>(&*message)) pending_ = std::move(*frame);
    }
    const CompressedFrame frame = *std::exchange(pending_, std::nullopt);
    return {SourceItem::Kind::kFrame, decompress(frame), {}};
  }
  int64_t frame_count() const override { return -1; }
  const Calibration& calibration() const override { return calibration_; }

 private:
  MessageReader reader_;
  std::optional<CompressedFrame> pending_;  ///< read but not yet handed out
  Calibration calibration_;
};

}  // namespace

std::unique_ptr<FrameSource> open_log_source(const std::filesystem::path& path) {
  return std::make_unique<LogSource>(path);
}

}  // namespace kt
