// What a source tells, in one line.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <gtest/gtest.h>
#include <sstream>
#include <string>

#include "onboard/source/frame_source.h"

namespace kt {

inline MotionSample sample_at(double stamp_s) {
  MotionSample sample;
  sample.timestamp_us = std::llround(stamp_s * 1e6);
  sample.rotation_sigma = sample.translation_sigma = 0.02;
  return sample;
}

/// Reads `source` to its end: "f100 m100.5 -m M ..." for frames and samples that pass, and -f, -m for skipped
/// ones.
inline std::string story_of(FrameSource& source) {
  using Kind = SourceItem::Kind;
  std::string story;
  int64_t samples = 0;
  for (SourceItem item = source.next(); item.kind != Kind::kEnd; item = source.next()) {
    std::ostringstream text;
    if (item.kind == Kind::kFrame) text << "f" << static_cast<double>(item.frame.timestamp_us) * 1e-6;
    if (item.kind == Kind::kSkipped) text << "-f";
    if (item.kind == Kind::kSkippedMotion) text << "-m";
    if (item.kind == Kind::kInterrupted) text << "!";
    if (item.kind == Kind::kMotion) {
      text << "m" << static_cast<double>(item.motion.timestamp_us) * 1e-6;
      EXPECT_EQ(item.motion.sequence, samples++);
    }
    EXPECT_EQ(item.reason.empty(), item.kind == Kind::kFrame || item.kind == Kind::kMotion);
    story += (story.empty() ? "" : " ") + text.str();
  }
  EXPECT_EQ(source.next().kind, Kind::kEnd);
  return story;
}

}  // namespace kt
