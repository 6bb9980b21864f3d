// What --check finds: cameras that give frames, little depth or none, disks and networks.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/app/preflight.h"

#include <algorithm>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/onboard/app/recording_sink.h"
#include "tests/support/test_files.h"

namespace kt::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;
using Verdict = Finding::Verdict;

std::vector<SourceItem> sliding_items(int count) {
  std::vector<SourceItem> items;
  for (int i = 0; i < count; ++i)
    items.push_back(frame_item(render(furnished_room(), small_calibration(),
                                      pose_of({0, 0, 0}, {0.01 * i, 0, 0}), {.sequence = i})));
  return items;
}

SourceItem item_of(SourceItem::Kind kind, const std::string& reason) {
  return {.kind = kind, .reason = reason};
}

TEST(CheckSource, TellsSizeRateAndDepth) {
  ListSource source(sliding_items(30));
  InputSample sample;
  const Finding finding = check_source(source, sample);
  EXPECT_EQ(finding.verdict, Verdict::kFine) << finding.text;
  const Camera& camera = small_calibration().depth;
  EXPECT_THAT(finding.text,
              HasSubstr(std::to_string(camera.width) + " x " + std::to_string(camera.height) + ", 30.0 Hz"));
  EXPECT_EQ(sample.frames.size(), 30u);
  EXPECT_NEAR(sample.rate_hz, 30, 0.1);
  EXPECT_GT(sample.valid_share, 0.5);
}

TEST(CheckSource, CountsValidDepthOnly) {
  std::vector<SourceItem> items = sliding_items(30);
  for (SourceItem& item : items) {
    auto pixels = item.frame.depth.pixels();
    std::fill(pixels.begin(), pixels.end(), uint16_t{0});
    pixels[0] = 1000;
  }
  ListSource source(items);
  InputSample sample;
  const Finding finding = check_source(source, sample);
  EXPECT_EQ(finding.verdict, Verdict::kBroken);
  EXPECT_THAT(finding.text, AllOf(HasSubstr("depth on 0 %"), HasSubstr("uncover the lens")));
}

TEST(CheckSource, SaysWhyNoFrameCame) {
  InputSample sample;
  ListSource empty({});
  EXPECT_THAT(check_source(empty, sample).text, HasSubstr("no usable frame: it holds none"));
  ListSource gone({item_of(SourceItem::Kind::kInterrupted, "camera: no image for 2 s")});
  EXPECT_THAT(check_source(gone, sample).text, HasSubstr("no usable frame: camera: no image for 2 s"));
  ListSource bad({item_of(SourceItem::Kind::kSkipped, "wrong size")});
  EXPECT_THAT(check_source(bad, sample).text, HasSubstr("no usable frame: wrong size"));
  EXPECT_EQ(sample.skipped, 1);
}

TEST(CheckSource, ACameraThatEndsEarlyIsDoubtful) {
  std::vector<SourceItem> items = sliding_items(5);
  items.push_back(item_of(SourceItem::Kind::kInterrupted, "unplugged"));
  ListSource source(items);
  InputSample sample;
  const Finding finding = check_source(source, sample);
  EXPECT_EQ(finding.verdict, Verdict::kDoubtful);
  EXPECT_THAT(finding.text, HasSubstr("then: unplugged"));
}

TEST(CheckDisk, MeasuresAndCompares) {
  const ScratchDir folder;
  CollectOptions options;
  options.log = (folder / "m-%Y.lcm").string();
  EXPECT_NE(check_disk(options, 1).verdict, Verdict::kBroken);
  EXPECT_THAT(check_disk(options, 1).text, AllOf(StartsWith(folder.path().string()), HasSubstr("GB free")));
  EXPECT_TRUE(std::filesystem::is_empty(folder.path())) << "it leaves nothing behind";
  const Finding slow = check_disk(options, 1e15);
  EXPECT_EQ(slow.verdict, Verdict::kBroken);
  EXPECT_THAT(slow.text, HasSubstr("too slow"));
}

TEST(CheckDisk, NamesAFolderThatCannotBeWritten) {
  CollectOptions options;
  options.log = "/no/such/folder/a.lcm";
  EXPECT_THAT(error_of([&] { check_disk(options, 1); }),
              AllOf(HasSubstr("/no/such/folder"), HasSubstr("must exist")));
}

TEST(LogBytes, RawFramesCountByTheirCompressedSize) {
  ListSource source(sliding_items(30));
  InputSample sample;
  check_source(source, sample);
  CollectOptions options;
  const double without = log_bytes_per_second(options, sample);
  options.record_raw = true;
  const double jpeg = log_bytes_per_second(options, sample);
  options.raw_colour = "png";
  EXPECT_GT(jpeg, without);
  EXPECT_GT(log_bytes_per_second(options, sample), without);
}

TEST(CheckBus, HearsItself) {
  EXPECT_EQ(check_bus("memq://", true).verdict, Verdict::kFine);
  EXPECT_THAT(error_of([] { check_bus("nonsense://", false); }), HasSubstr("nonsense://"));
}

TEST(CheckPipeline, RunsTheSample) {
  ListSource source(sliding_items(4));
  InputSample sample;
  check_source(source, sample);
  CollectSettings settings;
  settings.mission.device = "cpu";
  settings.mission.threads = 1;
  settings.config.volume.resolution = 64;
  settings.config.volume.voxel_size_m = 0.08;
  EXPECT_THAT(check_pipeline(settings, sample).text,
              AllOf(StartsWith("cpu with 1 threads"), HasSubstr("ms a frame")));
  sample.rate_hz = 1e6;  // no computer is that fast
  EXPECT_THAT(check_pipeline(settings, sample).text, HasSubstr("larger voxels"));
  EXPECT_EQ(check_pipeline(settings, sample).verdict, Verdict::kDoubtful);
}

std::vector<std::string> items_of(const CommandLine& command_line, bool& is_fine) {
  std::vector<std::string> items;
  is_fine =
      run_preflight(command_line, [&](const Finding& finding) { items.push_back(finding_text(finding)); });
  return items;
}

TEST(Preflight, SaysOneLineForEachItem) {
  const ScratchDir folder;
  CommandLine command_line;
  command_line.mission = {{"mission.input", "tum:/no/such/recording", "--input"},
                          {"mission.log", (folder / "m.lcm").string(), "--log"},
                          {"mission.publish", "memq://", "--publish"}};
  bool is_fine = true;
  const std::vector<std::string> items = items_of(command_line, is_fine);
  EXPECT_FALSE(is_fine);
  ASSERT_EQ(items.size(), 4u) << "the processor is left out: there are no frames for it";
  EXPECT_THAT(items[0], StartsWith("ok    configuration  "));
  EXPECT_THAT(items[1], AllOf(StartsWith("FAIL  camera         "), HasSubstr("/no/such/recording")));
  EXPECT_THAT(items[2], HasSubstr("  disk           "));
  EXPECT_THAT(items[3], StartsWith("ok    network        memq://"));
}

TEST(Preflight, AWrongConfigurationIsAllThatIsSaid) {
  CommandLine command_line;
  command_line.settings = {"volume.voxel_size_m=9"};
  bool is_fine = true;
  std::vector<std::string> items = items_of(command_line, is_fine);
  EXPECT_FALSE(is_fine);
  ASSERT_EQ(items.size(), 1u);
  EXPECT_THAT(items[0], AllOf(StartsWith("FAIL  configuration  "), HasSubstr("volume.voxel_size_m")));
  items = items_of({}, is_fine);
  ASSERT_EQ(items.size(), 1u);
  EXPECT_THAT(items[0], HasSubstr("name --input, or mission.input in the file"));
}

}  // namespace
}  // namespace kt::test
