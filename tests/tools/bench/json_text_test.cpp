// Tests of the benches' JSON: layout, quoting and numbers.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/bench/json_text.h"

#include <limits>

#include "gtest/gtest.h"

#include "shared/core/check.h"

namespace kt::bench {
namespace {

TEST(JsonText, NestsObjectsAndArrays) {
  JsonText json;
  json.add("name", "a");
  json.open("inner");
  json.add("n", 3);
  json.add("x", 0.125, 2);
  json.close();
  json.open_array("list");
  for (int i = 0; i < 2; ++i) {
    json.open();
    json.add("i", i);
    json.close();
  }
  json.close();
  json.open("empty");
  json.close();
  EXPECT_EQ(json.finish(),
            "{\n  \"name\": \"a\",\n  \"inner\": {\n    \"n\": 3,\n    \"x\": 0.12\n  },\n  \"list\": [\n"
            "    {\n      \"i\": 0\n    },\n    {\n      \"i\": 1\n    }\n  ],\n  \"empty\": {}\n}\n");
}

TEST(JsonText, QuotesWhatWouldEndAString) {
  JsonText json;
  json.add("text", "a \"b\" c\\d\ne");
  EXPECT_EQ(json.finish(), "{\n  \"text\": \"a \\\"b\\\" c\\\\d e\"\n}\n");
}

TEST(JsonText, HasNoNumberForWhatIsNone) {
  JsonText json;
  json.add("a", std::numeric_limits<double>::quiet_NaN(), 3);
  json.add("b", std::numeric_limits<double>::infinity(), 3);
  EXPECT_EQ(json.finish(), "{\n  \"a\": null,\n  \"b\": null\n}\n");
}

TEST(JsonText, WantsEveryOpenClosed) {
  JsonText json;
  json.open("a");
  EXPECT_THROW(json.finish(), LogicError);
}

}  // namespace
}  // namespace kt::bench
