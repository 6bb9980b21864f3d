// Frames from a folder of images, and the odometry beside them.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <utility>
#include <vector>

#include "onboard/source/bare_sources.h"
#include "shared/io/dataset.h"
#include "shared/types/timestamp.h"

namespace kt {
namespace {

class DatasetSource final : public FrameSource {
 public:
  explicit DatasetSource(Dataset dataset) : dataset_(std::move(dataset)), odometry_(dataset_.odometry()) {
    // One stamp far ahead must not hold back the samples behind it.
    std::stable_sort(odometry_.begin(), odometry_.end(), [](const MotionSample& a, const MotionSample& b) {
      return a.timestamp_us < b.timestamp_us;
    });
  }

  SourceItem next() override {
    if (next_sample_ < odometry_.size() && odometry_[next_sample_].timestamp_us <= reached_us())
      return {.kind = SourceItem::Kind::kMotion, .motion = odometry_[next_sample_++]};
    if (next_ == dataset_.frame_count()) return {};
    const int64_t i = next_++;  // before loading, so that the call after a failure goes on
    return {SourceItem::Kind::kFrame, dataset_.load(i), {}};
  }
  int64_t frame_count() const override { return dataset_.frame_count(); }
  const Calibration& calibration() const override { return dataset_.default_calibration(); }

 private:
  // Up to where samples belong before the next frame. The frame behind it speaks too: one stamp far ahead
  // must not call all samples at once.
  int64_t reached_us() const {
    if (next_ == dataset_.frame_count()) return kMaxTimestamp_us;
    const int64_t stamp_us = dataset_.timestamp_us(next_);
    return next_ + 1 < dataset_.frame_count() ? std::min(stamp_us, dataset_.timestamp_us(next_ + 1))
                                              : stamp_us;
  }

  Dataset dataset_;
  std::vector<MotionSample> odometry_;
  int64_t next_ = 0;
  size_t next_sample_ = 0;
};

}  // namespace

std::unique_ptr<FrameSource> open_dataset_source(const std::string& format,
                                                 const std::filesystem::path& folder) {
  return std::make_unique<DatasetSource>(open_dataset(format, folder));
}

}  // namespace kt
