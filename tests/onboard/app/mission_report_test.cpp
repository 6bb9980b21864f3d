// Tests of the end report in both its forms.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/app/mission_report.h"

#include <filesystem>
#include <fstream>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nlohmann/json.hpp"

#include "shared/core/check.h"

namespace kt {
namespace {

using testing::HasSubstr;

MissionSummary summary() {
  MissionSummary s;
  s.status.frames = 200;
  s.status.frames_good = 150;
  s.status.frames_uncertain = 40;
  s.status.frames_lost = 10;
  s.status.frames_skipped = 3;
  s.status.slices = 7;
  s.status.slice_vertices = 5'000'000'000;
  s.status.slice_triangles = 123;
  s.skip_reasons = {"frame 5: truncated \"image\" 100 %"};
  s.stage_times["frame"] = {70, 80, 90, 200};
  s.stage_times["track"] = {20, 25, 30, 200};
  s.stage_times["frame_fallback"] = {110, 120, 130, 40};
  s.status.frames_by_source = {10, 2, 150, 30, 0, 8, 0};
  s.status.segments = 2;
  s.status.segment = 1;
  s.first_us = 50'000'000;
  TrackingStretch stretch;
  stretch.first_sequence = 370;
  stretch.last_sequence = 402;
  stretch.first_us = 62'333'000;
  stretch.last_us = 63'400'000;
  stretch.lost = 20;
  stretch.uncertain = 13;
  stretch.cause = TrackingCause::kFewInliers;
  stretch.lowest_inlier_share = 0.25;
  stretch.end = TrackingStretch::End::kFound;
  stretch.found_by = PoseSource::kFeatures;
  s.stretches.push_back(stretch);
  TrackingStretch gap;
  gap.first_sequence = 500;
  gap.last_sequence = 501;
  gap.first_us = 70'000'000;
  gap.last_us = gap.first_us + 2'000'000;
  gap.gap_us = 2'000'000;
  gap.is_gap = true;
  s.stretches.push_back(gap);
  s.stretch_count = 5;
  s.device = "cuda";
  s.seconds = 12.5;
  s.peak_memory_mib = 321;
  return s;
}

TEST(MissionReport, SaysWhatWasPublishedAndWhyItEnded) {
  MissionSummary live = summary();
  EXPECT_THAT(mission_report_text(live), testing::Not(HasSubstr("published")));
  live.publishing = LcmSink::Counts{.messages = 1234, .bytes = 5'600'000, .dropped = 7, .refused = 8};
  live.timed_out = true;
  const std::string text = mission_report_text(live);
  EXPECT_THAT(text, HasSubstr("published 1234 messages, 5.6 MB; 7 dropped, 8 refused by the network"));
  EXPECT_THAT(text, HasSubstr("no more frames came"));
}

TEST(MissionReport, TextNamesTheFigures) {
  const std::string text = mission_report_text(summary());
  for (const char* part : {"200 processed", "75.0 % tracked", "40 uncertain", "10 lost", "3 skipped",
                           "truncated \"image\" 100 %", "7 with 5000000000 vertices", "123 triangles",
                           "track", "25.00", "12.5 s", "321 MiB"}) {
    EXPECT_THAT(text, HasSubstr(part));
  }
  EXPECT_THAT(text, testing::Not(HasSubstr("stopped")));
}

TEST(MissionReport, TextSaysThatTheUserStoppedIt) {
  MissionSummary stopped = summary();
  stopped.interrupted = true;
  EXPECT_THAT(mission_report_text(stopped), HasSubstr("stopped by the user"));
}

TEST(MissionReport, MotionSamplesAreNamedWhereThereAreAny) {
  MissionSummary with = summary();
  with.motion_samples = 500;
  with.motion_samples_refused = 2;
  with.motion_refusals = {"its stamp is wrong"};
  EXPECT_THAT(mission_report_text(with),
              HasSubstr("500 samples of other sensors, 2 refused\n  refused: its stamp"));
  EXPECT_THAT(mission_report_text(summary()), testing::Not(HasSubstr("other sensors")));
  const std::filesystem::path path =
      std::filesystem::path(testing::TempDir()) / "kintsugi_motion_report.json";
  write_mission_report(with, path);
  const nlohmann::json report = nlohmann::json::parse(std::ifstream(path));
  EXPECT_EQ(report["motion_samples"], 500);
  EXPECT_EQ(report["motion_samples_refused"], 2);
  EXPECT_EQ(report["motion_refusals"][0], "its stamp is wrong");
  write_mission_report(summary(), path);
  EXPECT_FALSE(nlohmann::json::parse(std::ifstream(path)).contains("motion_samples"));
  std::filesystem::remove(path);
}

TEST(MissionReport, TextSaysWherePosesCameFrom) {
  EXPECT_THAT(mission_report_text(summary()),
              HasSubstr("poses     10 none, 2 start, 150 model, 30 features, 8 relocalised\n"));
}

TEST(MissionReport, TextNamesSegmentsWhereThereAreMoreThanOne) {
  EXPECT_THAT(mission_report_text(summary()),
              HasSubstr("segments  2, counted from 0; at the end in segment 1\n"));
  MissionSummary one = summary();
  one.status.segments = 1;
  EXPECT_THAT(mission_report_text(one), testing::Not(HasSubstr("segment")));
}

TEST(MissionReport, TextTellsTheWorstStretchesInPlainWords) {
  EXPECT_THAT(
      mission_report_text(summary()),
      HasSubstr("worst stretches of the tracking\n"
                "  12.3 s to 13.4 s (frames 370 to 402): 20 lost, 13 uncertain, few inliers; found again by "
                "features\n"
                "  20.0 s to 22.0 s (frames 500 to 501): no frames for 2.0 s; end of mission\n"
                "  and 3 more, none of them longer\n"));
  MissionSummary smooth = summary();
  smooth.stretches.clear();
  smooth.stretch_count = 0;
  EXPECT_THAT(mission_report_text(smooth), testing::Not(HasSubstr("stretch")));
}

TEST(MissionReport, TextGivesTheTimesOfFallbackFrames) {
  EXPECT_THAT(mission_report_text(summary()), HasSubstr("\nfallback      110.00    120.00    130.00\n"));
}

TEST(MissionReport, ProgressSaysWhatThePoseIsWorth) {
  MissionStatus status;
  status.frames = 11;
  status.frames_skipped = 1;
  status.slices = 2;
  status.tracking = TrackingStatus::kUncertain;
  status.source = PoseSource::kModel;
  status.cause = TrackingCause::kFewInliers;
  status.inlier_share = 0.434;
  EXPECT_EQ(mission_progress_text(status, 600, 0.5),
            "frame 12 of 600  22.0 Hz  uncertain (few inliers, 43 %)  2 slices  1 skipped");
  status.source = PoseSource::kPairwise;
  status.tracking = TrackingStatus::kGood;
  status.cause = TrackingCause::kNone;
  EXPECT_EQ(mission_progress_text(status, -1, 0.5),
            "frame 12  22.0 Hz  good (pairwise, 43 %)  2 slices  1 skipped");
  EXPECT_EQ(mission_progress_text({}, 3, 0), "frame 0 of 3  0.0 Hz  good  0 slices  0 skipped");
}

TEST(MissionReport, OfNothingIsFinite) { EXPECT_THAT(mission_report_text({}), HasSubstr("0.0 % tracked")); }

TEST(MissionReport, JsonHoldsTheSameFigures) {
  const std::filesystem::path path =
      std::filesystem::path(testing::TempDir()) / "kintsugi_mission_report.json";
  write_mission_report(summary(), path);
  const nlohmann::json report = nlohmann::json::parse(std::ifstream(path));
  EXPECT_EQ(report["frames"], 200);
  EXPECT_EQ(report["tracked_share"], 0.75);
  EXPECT_EQ(report["device"], "cuda");
  EXPECT_EQ(report["threads"], 1);
  EXPECT_EQ(report["vertices"], 5'000'000'000);
  EXPECT_EQ(report["skip_reasons"][0], "frame 5: truncated \"image\" 100 %");
  EXPECT_EQ(report["process"]["p50_ms"], 70);
  EXPECT_EQ(report["stages"]["track"]["p95_ms"], 25);
  EXPECT_FALSE(report["stages"].contains("frame"));
  EXPECT_FALSE(report["stages"].contains("frame_fallback"));
  EXPECT_EQ(report["fallback"]["p95_ms"], 120);
  EXPECT_EQ(report["fallback"]["count"], 40);
  EXPECT_EQ(report["poses_by_source"]["model"], 150);
  EXPECT_EQ(report["poses_by_source"]["prior"], 0);
  EXPECT_EQ(report["segments"], 2);
  EXPECT_EQ(report["segment"], 1);
  EXPECT_EQ(report["stretch_count"], 5);
  ASSERT_EQ(report["stretches"].size(), 2u);
  EXPECT_EQ(report["stretches"][0],
            nlohmann::json::parse(R"({"first_frame": 370, "last_frame": 402, "first_timestamp_us": 62333000,
                "last_timestamp_us": 63400000, "lost": 20, "uncertain": 13, "gap_us": 0, "cause": "few inliers",
                "lowest_inlier_share": 0.25, "end": "found again", "found_by": "features"})"));
  EXPECT_EQ(report["stretches"][1]["cause"], "gap");
  EXPECT_EQ(report["stretches"][1]["found_by"], nullptr);
  EXPECT_EQ(report["interrupted"], false);
  std::filesystem::remove(path);
}

TEST(MissionReport, JsonOfASmoothMissionHasEveryField) {
  const std::filesystem::path path =
      std::filesystem::path(testing::TempDir()) / "kintsugi_smooth_mission_report.json";
  write_mission_report({}, path);
  const nlohmann::json report = nlohmann::json::parse(std::ifstream(path));
  EXPECT_EQ(report["stretches"], nlohmann::json::array());
  EXPECT_EQ(report["fallback"]["count"], 0);
  EXPECT_EQ(report["process"]["count"], 0);
  EXPECT_EQ(report["poses_by_source"].size(), static_cast<size_t>(kPoseSources));
  std::filesystem::remove(path);
}

TEST(MissionReport, SaysWhereItCannotWrite) {
  try {
    write_mission_report(summary(), "/nowhere/at/all/report.json");
    FAIL() << "must throw";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("/nowhere/at/all/report.json"));
  }
}

}  // namespace
}  // namespace kt
