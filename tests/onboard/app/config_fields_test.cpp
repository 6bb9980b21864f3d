// Tests of the configuration: its text forms, its ranges, its error messages.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/app/config_fields.h"

#include <set>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

#include "shared/core/check.h"

namespace kt {
namespace {

using testing::AllOf;
using testing::HasSubstr;

std::string error_of_set(const std::string& assignment) {
  CollectorConfig config;
  try {
    set_config_field(config, assignment);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

std::string error_of_yaml(const std::string& yaml) {
  CollectorConfig config;
  try {
    apply_config_yaml(config, yaml, "robot.yaml");
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(ConfigFields, HaveNamesHelpAndDefaultsInTheirRange) {
  CollectorConfig config;
  std::set<std::string> names, sections;
  std::string section;
  for (const ConfigField& field : config_fields(config)) {
    EXPECT_TRUE(names.insert(field.name).second) << field.name << " twice";
    EXPECT_FALSE(field.help.empty()) << field.name;
    EXPECT_LT(field.low, field.high) << field.name;
    const double value = std::holds_alternative<int*>(field.value) ? *std::get<int*>(field.value)
                                                                   : *std::get<double*>(field.value);
    EXPECT_GE(value, field.low) << field.name;
    EXPECT_LE(value, field.high) << field.name;
    const std::string field_section = field.name.substr(0, field.name.find('.'));
    if (field_section != section) {
      EXPECT_TRUE(sections.insert(field_section).second)
          << "the section '" << field_section << "' must not come twice in YAML";
    }
    section = field_section;
  }
  EXPECT_GE(names.size(), 20u);
}

TEST(ConfigFields, ReadBackFromTheirYaml) {
  for (const bool with_help : {false, true}) {
    CollectorConfig config;
    double share = 0.1;
    for (const ConfigField& field : config_fields(config)) {
      share = share > 0.8 ? 0.13 : share + 0.07;
      const double value = field.low + share * (field.high - field.low);  // with all its digits
      if (const auto* integer = std::get_if<int*>(&field.value)) {
        **integer = static_cast<int>(value);
      } else {
        *std::get<double*>(field.value) = value;
      }
    }
    CollectorConfig copy;
    apply_config_yaml(copy, to_yaml(config_fields(config), with_help), "copy");
    EXPECT_EQ(config_to_yaml(copy), config_to_yaml(config));
    EXPECT_NE(config_to_yaml(copy), config_to_yaml(CollectorConfig{}));
    EXPECT_EQ(copy.volume.voxel_size_m, config.volume.voxel_size_m) << "bit for bit";
    EXPECT_EQ(copy.tracking.iterations, config.tracking.iterations);
  }
}

TEST(ConfigFields, HelpIsAComment) {
  CollectorConfig config;
  const std::string yaml = to_yaml(config_fields(config), /*with_help=*/true);
  for (const ConfigField& field : config_fields(config))
    EXPECT_THAT(yaml, HasSubstr("# " + field.help)) << field.name;
}

TEST(ConfigFields, TakeBothEndsOfTheirRangeAndNothingBeyond) {
  CollectorConfig config;
  for (const ConfigField& field : config_fields(config)) {
    const auto text = [](double value) {
      std::ostringstream stream;
      stream.precision(17);
      stream << value;
      return stream.str();
    };
    EXPECT_EQ(error_of_set(field.name + "=" + text(field.low)), "no error");
    EXPECT_EQ(error_of_set(field.name + "=" + text(field.high)), "no error");
    const double step = std::holds_alternative<int*>(field.value) ? 1 : 1e-3;
    for (const double value : {field.low - step, field.high + step}) {
      EXPECT_THAT(error_of_set(field.name + "=" + text(value)),
                  AllOf(HasSubstr(field.name), HasSubstr("must be"), HasSubstr("[")))
          << value;
    }
  }
}

TEST(ConfigFields, RefuseWhatIsNoNumber) {
  for (const char* text : {"", "abc", "1x", "nan", "inf", "-inf", "0x10", "1,5", "true", "1e999"}) {
    EXPECT_THAT(
        error_of_set(std::string("volume.voxel_size_m=") + text),
        AllOf(HasSubstr("volume.voxel_size_m must be a number"), HasSubstr("got '" + std::string(text))));
  }
}

TEST(ConfigFields, IntegersRefuseFractions) {
  EXPECT_THAT(error_of_set("volume.resolution=256.5"),
              HasSubstr("must be an integer in [32, 2048], got '256.5'"));
  EXPECT_THAT(error_of_set("tracking.iterations_full=1e9"), HasSubstr("must be an integer"));
  EXPECT_EQ(error_of_set("volume.resolution=256"), "no error");
}

TEST(ConfigFields, ListTheNamesForAnUnknownOne) {
  CollectorConfig config;
  for (const std::string& error :
       {error_of_set("volume.voxelsize=0.01"), error_of_yaml("volume: {voxelsize: 0.01}"),
        error_of_yaml("volum: {voxel_size_m: 0.01}")}) {
    EXPECT_THAT(error, HasSubstr("unknown field"));
    for (const ConfigField& field : config_fields(config)) EXPECT_THAT(error, HasSubstr(field.name));
  }
}

TEST(ConfigFields, SetChangesTheOneField) {
  CollectorConfig config;
  set_config_field(config, "volume.voxel_size_m=0.005");
  EXPECT_EQ(config.volume.voxel_size_m, 0.005);
  config.volume.voxel_size_m = CollectorConfig{}.volume.voxel_size_m;
  EXPECT_EQ(config_to_yaml(config), config_to_yaml(CollectorConfig{}));
}

TEST(ConfigFields, SetAsksForAnEqualsSign) {
  EXPECT_THAT(error_of_set("volume.voxel_size_m"), HasSubstr("NAME=VALUE"));
}

TEST(ConfigFields, YamlErrorsNameTheFile) {
  for (const char* yaml :
       {"volume: {voxel_size_m: 7}", "volume: {voxel_size_m: [1, 2]}", "volume: [0.01]", "volume: 3", "- 1",
        "just text", "a: [", "volum:", "{: }", "volume: {voxel_size_m: }", "? [a]\n: {b: 1}"}) {
    EXPECT_THAT(error_of_yaml(yaml), HasSubstr("robot.yaml")) << yaml;
  }
}

TEST(ConfigFields, EmptyYamlKeepsTheDefaults) {
  CollectorConfig config;
  for (const char* yaml : {"", "\n", "# nothing\n", "---\n", "volume:\n"})
    apply_config_yaml(config, yaml, "empty.yaml");
  EXPECT_EQ(config_to_yaml(config), config_to_yaml(CollectorConfig{}));
}

TEST(Config, FieldsMustFitTogether) {
  EXPECT_NO_THROW(check_config({}));
  const auto refused = [](const char* first, const char* second) {
    CollectorConfig config;
    set_config_field(config, first);
    set_config_field(config, second);
    try {
      check_config(config);
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(refused("preprocess.depth_min_m=2", "preprocess.depth_max_m=1").find("depth_min_m"),
            std::string::npos);
  EXPECT_NE(refused("volume.resolution=100", "volume.voxel_size_m=0.1").find("multiple of 32"),
            std::string::npos);
  EXPECT_NE(refused("volume.max_weight=2", "volume.min_slice_weight=3").find("exported"), std::string::npos);
}

}  // namespace
}  // namespace kt
