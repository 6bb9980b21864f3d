// The mission's options: file below command line, errors that say where, dated names, and the shipped
// configuration.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/app/collect_options.h"

#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <map>
#include <utility>

#include "onboard/app/dated_path.h"
#include "tests/support/test_files.h"

namespace kt {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

class ConfigurationFile : public testing::Test {
 protected:
  CommandLine with(const std::string& yaml) const {
    std::ofstream(folder_ / "robot.yaml") << yaml;
    return {.config_file = (folder_ / "robot.yaml").string(), .mission = {}, .settings = {}};
  }
  std::string error_with(const std::string& yaml) const {
    return error_of([&] { read_settings(with(yaml)); });
  }
  std::string at_line(int line) const {
    return (folder_ / "robot.yaml").string() + ":" + std::to_string(line) + ": ";
  }
  ScratchDir folder_;
};

TEST_F(ConfigurationFile, SetsEveryKindOfField) {
  const CollectSettings settings = read_settings(with(R"(
mission:
  input: "openni2:,size=320x240"
  log: /data/%Y.lcm
  record_raw: true
  threads: 3
  publish_rate: 0.5
  device: cpu
volume:
  voxel_size_m: 0.02
)"));
  EXPECT_EQ(settings.mission.input, "openni2:,size=320x240");
  EXPECT_EQ(settings.mission.log, "/data/%Y.lcm");
  EXPECT_TRUE(settings.mission.record_raw);
  EXPECT_EQ(settings.mission.threads, 3);
  EXPECT_EQ(settings.mission.publish_rate_mb_s, 0.5);
  EXPECT_EQ(settings.mission.device, "cpu");
  EXPECT_EQ(settings.config.volume.voxel_size_m, 0.02);
}

TEST_F(ConfigurationFile, CommandLineOverridesIt) {
  CommandLine command_line =
      with("mission: {threads: 3, record_raw: true, input: \"tum:a\"}\nvolume: {voxel_size_m: 0.02}");
  command_line.mission = {{"mission.threads", "1", "--threads"},
                          {"mission.record_raw", "false", "--record-raw"}};
  command_line.settings = {"volume.voxel_size_m=0.005"};
  const CollectSettings settings = read_settings(command_line);
  EXPECT_EQ(settings.mission.threads, 1);
  EXPECT_FALSE(settings.mission.record_raw);
  EXPECT_EQ(settings.mission.input, "tum:a");
  EXPECT_EQ(settings.config.volume.voxel_size_m, 0.005);
}

TEST_F(ConfigurationFile, ErrorsNameFileLineAndKey) {
  EXPECT_THAT(error_with("mission:\n  threads: 2\n  thread: 2\n"),
              AllOf(StartsWith(at_line(3)), HasSubstr("'mission.thread'"), HasSubstr("mission.threads")));
  EXPECT_THAT(error_with("volume:\n\n  voxel_size_m: 7\n"),
              AllOf(StartsWith(at_line(3)),
                    HasSubstr("volume.voxel_size_m must be a number in [0.001, 0.2], got '7'")));
  EXPECT_THAT(
      error_with("mission: {record_raw: yes}"),
      AllOf(StartsWith(at_line(1)), HasSubstr("mission.record_raw must be true or false, got 'yes'")));
  EXPECT_THAT(error_with("mission:\n  device: gpu\n"),
              AllOf(StartsWith(at_line(2)), HasSubstr("must be auto, cpu or cuda, got 'gpu'")));
  EXPECT_THAT(error_with("mission:\n  input:\n"),
              AllOf(StartsWith(at_line(2)), HasSubstr("mission.input must have")));
  EXPECT_THAT(error_with("mission:\n  log: a\n  log: b\n"),
              AllOf(StartsWith(at_line(3)), HasSubstr("mission.log is there twice")));
  EXPECT_THAT(error_with("mission: {log: a}\nmission: {log: b}\n"),
              AllOf(StartsWith(at_line(2)), HasSubstr("mission.log is there twice")));
  EXPECT_THAT(error_with("mission:\n  log: [a\n"), HasSubstr("not valid YAML"));
  EXPECT_THAT(error_with("missions:\n"), AllOf(StartsWith(at_line(1)), HasSubstr("'missions'")));
  EXPECT_THAT(error_with("volume: {resolution: 100}"),
              AllOf(HasSubstr("robot.yaml"), HasSubstr("volume.resolution must be a multiple of 32")));
  EXPECT_THAT(
      error_of([] { read_settings({.config_file = "/no/such.yaml", .mission = {}, .settings = {}}); }),
      HasSubstr("/no/such.yaml"));
}

TEST_F(ConfigurationFile, WrongOptionsAreNamedAsTyped) {
  CommandLine command_line;
  command_line.mission = {{"mission.threads", "-3", "--threads"}};
  EXPECT_THAT(error_of([&] { read_settings(command_line); }),
              StartsWith("--threads must be an integer in [0, 1024], got '-3'"));
}

TEST_F(ConfigurationFile, AllOfItIsReadBackAsPrinted) {
  CollectSettings settings;
  settings.mission.input = "lcm:udpm://239.255.76.67:7667?ttl=1";
  settings.mission.log = "a \"quoted\"\\ name: #1";
  settings.mission.record_raw = true;
  settings.mission.raw_colour = "png";
  settings.mission.idle_timeout_s = 0.125;
  settings.config.tracking.max_distance_m = 0.123456789012345;
  CollectSettings copy = read_settings(with(to_yaml(all_fields(settings), /*with_help=*/true)));
  EXPECT_EQ(to_yaml(all_fields(copy)), to_yaml(all_fields(settings)));
  EXPECT_EQ(copy.mission.log, settings.mission.log);
}

TEST(CollectOptions, PublishIsOffOrDefaultOrAUrl) {
  CollectOptions options;
  EXPECT_FALSE(options.publishes());
  options.publish = "default";
  EXPECT_TRUE(options.publishes());
  EXPECT_EQ(options.publish_url(), "");
  options.publish = "udpm://239.255.76.67:7667?ttl=1";
  EXPECT_EQ(options.publish_url(), options.publish);
}

// What tools/packaging/collector.yaml says of one field.
struct ShippedField {
  std::string value;
  bool is_active = false;
  std::string comment;  ///< the lines above it, joined
};

// "  # text" explains, "  #name: value" is a default that can be uncommented, "  name: value" is set.
std::map<std::string, ShippedField> shipped_fields(std::string& uncommented) {
  std::ifstream file(KT_REPOSITORY "/tools/packaging/collector.yaml");
  std::map<std::string, ShippedField> fields;
  std::string section, comment;
  for (std::string line; std::getline(file, line);) {
    const size_t start = line.find_first_not_of(' ');
    if (start == std::string::npos || line.compare(start, 2, "# ") == 0) {
      comment = start == std::string::npos ? "" : comment + line.substr(start + 1);
    } else if (start == 0) {
      section = line.substr(0, line.find(':'));
      uncommented += line + "\n";
    } else {
      ShippedField field{.value = "", .is_active = line[start] != '#', .comment = std::exchange(comment, "")};
      const std::string setting = line.substr(start + !field.is_active);
      const size_t colon = setting.find(": ");
      field.value = setting.substr(colon + 2);
      fields[section + "." + setting.substr(0, colon)] = field;
      uncommented += "  " + setting + "\n";
    }
  }
  return fields;
}

TEST(ShippedConfiguration, NamesAndExplainsEveryFieldWithItsDefault) {
  CollectSettings defaults;
  std::string uncommented;
  const auto shipped = shipped_fields(uncommented);
  const std::vector<ConfigField> fields = all_fields(defaults);
  EXPECT_EQ(shipped.size(), fields.size());
  for (const ConfigField& field : fields) {
    const auto found = shipped.find(field.name);
    ASSERT_NE(found, shipped.end()) << field.name << " is missing in tools/packaging/collector.yaml";
    EXPECT_THAT(found->second.comment, AllOf(HasSubstr(field.help), HasSubstr(field.range()))) << field.name;
    if (found->second.is_active) {
      EXPECT_TRUE(field.name.starts_with("mission."))
          << field.name << ": defaults of the pipeline stay the program's";
    }
  }
}

TEST(ShippedConfiguration, LoadsAndChangesOnlyWhatItSets) {
  const CommandLine shipped{
      .config_file = KT_REPOSITORY "/tools/packaging/collector.yaml", .mission = {}, .settings = {}};
  CollectSettings settings = read_settings(shipped), defaults;
  EXPECT_EQ(settings.mission.input, "openni2:");
  EXPECT_EQ(dated_path(settings.mission.log, 1'000'000'000), "/var/lib/kintsugi/mission-20010909-014640.lcm");
  EXPECT_EQ(dated_path(settings.mission.report, 1'000'000'000),
            "/var/lib/kintsugi/mission-20010909-014640.json");
  settings.mission.input = settings.mission.log = settings.mission.report = "";
  EXPECT_EQ(to_yaml(all_fields(settings)), to_yaml(all_fields(defaults)));
}

TEST(ShippedConfiguration, ItsCommentedDefaultsAreTheProgrammes) {
  std::string uncommented;
  const auto shipped = shipped_fields(uncommented);
  CollectSettings settings, defaults;
  apply_yaml(all_fields(settings), uncommented, "collector.yaml");
  for (const ConfigField& field : all_fields(defaults)) {
    const ShippedField& one = shipped.at(field.name);
    if (one.is_active) set_field(all_fields(settings), field.name, field.text(), "test");
  }
  EXPECT_EQ(to_yaml(all_fields(settings)), to_yaml(all_fields(defaults)));
}

TEST(DatedPath, TakesDateAndTimeInUtc) {
  EXPECT_EQ(dated_path("m-%Y%m%d-%H%M%S.lcm", 1'000'000'000), "m-20010909-014640.lcm");
  EXPECT_EQ(dated_path("100%%.lcm", 0), "100%.lcm");
  EXPECT_EQ(dated_path("", 0), "");
  for (const char* wrong : {"a%q", "a%", "%s"})
    EXPECT_THAT(error_of([&] { dated_path(wrong, 0); }), HasSubstr("% must be followed")) << wrong;
}

TEST(DatedPath, ATakenNameGetsANumber) {
  const ScratchDir folder;
  const std::string pattern = (folder / "m-%S.lcm").string();
  EXPECT_EQ(unused_dated_path(pattern, 7), folder / "m-07.lcm");
  write_bytes(folder / "m-07.lcm", {1});
  EXPECT_EQ(unused_dated_path(pattern, 7), folder / "m-07-2.lcm");
  write_bytes(folder / "m-07-2.lcm", {1});
  EXPECT_EQ(unused_dated_path(pattern, 7), folder / "m-07-3.lcm");
  EXPECT_EQ(unused_dated_path((folder / "m-07.lcm").string(), 7), folder / "m-07.lcm")
      << "without a date it is refused later";
}

}  // namespace
}  // namespace kt
