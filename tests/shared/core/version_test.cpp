// The version that programs, logs and reports name.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/core/version.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace kt {
namespace {

TEST(Version, IsAReleaseAndWhereThereIsOneACommit) {
  EXPECT_THAT(kProgramVersion,
              ::testing::MatchesRegex("[0-9]+\\.[0-9]+\\.[0-9]+( \\([0-9a-f]+(-dirty)?\\))?"));
}

}  // namespace
}  // namespace kt
