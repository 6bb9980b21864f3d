// Frames from a folder of images.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/source/bare_sources.h"
#include "shared/io/dataset.h"

namespace kt {
namespace {

class DatasetSource final : public FrameSource {
 public:
  explicit DatasetSource(Dataset dataset) : dataset_(std::move(dataset)) {}

  SourceItem next() override {
    if (next_ == dataset_.frame_count()) return {};
    const int64_t i = next_++;  // before loading, so that the call after a failure goes on
    return {SourceItem::Kind::kFrame, dataset_.load(i), {}};
  }
  int64_t frame_count() const override { return dataset_.frame_count(); }
  const Calibration& calibration() const override { return dataset_.default_calibration(); }

 private:
  Dataset dataset_;
  int64_t next_ = 0;
};

}  // namespace

std::unique_ptr<FrameSource> open_dataset_source(const std::string& format,
                                                 const std::filesystem::path& folder) {
  return std::make_unique<DatasetSource>(open_dataset(format, folder));
}

}  // namespace kt
