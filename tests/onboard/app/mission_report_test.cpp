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
  s.seconds = 12.5;
  s.peak_memory_mib = 321;
  return s;
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

TEST(MissionReport, OfNothingIsFinite) { EXPECT_THAT(mission_report_text({}), HasSubstr("0.0 % tracked")); }

TEST(MissionReport, JsonHoldsTheSameFigures) {
  const std::filesystem::path path =
      std::filesystem::path(testing::TempDir()) / "kintsugi_mission_report.json";
  write_mission_report(summary(), path);
  const nlohmann::json report = nlohmann::json::parse(std::ifstream(path));
  EXPECT_EQ(report["frames"], 200);
  EXPECT_EQ(report["tracked_share"], 0.75);
  EXPECT_EQ(report["vertices"], 5'000'000'000);
  EXPECT_EQ(report["skip_reasons"][0], "frame 5: truncated \"image\" 100 %");
  EXPECT_EQ(report["process"]["p50_ms"], 70);
  EXPECT_EQ(report["stages"]["track"]["p95_ms"], 25);
  EXPECT_FALSE(report["stages"].contains("frame"));
  EXPECT_EQ(report["interrupted"], false);
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
