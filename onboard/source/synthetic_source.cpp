// Frames rendered on the spot.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/source/bare_sources.h"
#include "shared/synth/mission.h"

namespace kt {
namespace {

class SyntheticSource final : public FrameSource {
 public:
  // On the reading thread alone, as images are decoded: the other cores are the collector's.
  explicit SyntheticSource(const std::string& name) : mission_(name, {.threads = 1}) {}

  SourceItem next() override {
    if (next_ == mission_.frame_count()) return {};
    return {SourceItem::Kind::kFrame, mission_.render(next_++), {}};
  }
  int64_t frame_count() const override { return mission_.frame_count(); }
  const Calibration& calibration() const override { return mission_.calibration(); }

 private:
  SyntheticMission mission_;
  int64_t next_ = 0;
};

}  // namespace

std::unique_ptr<FrameSource> open_synthetic_source(const std::string& name) {
  return std::make_unique<SyntheticSource>(name);
}

}  // namespace kt
