// Every way in which a program can end: its exit code and what it says.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/cli/program.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <vector>

#include "shared/core/check.h"

namespace kt {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

struct Outcome {
  int exit_code;
  std::string out, err;
};

Outcome run(std::vector<std::string> arguments, const std::function<void()>& work) {
  CLI::App app("A program of the test.", "kintsugi-test");
  int number = 0;
  std::string kind;
  app.add_option("--number", number, "a number")->check(CLI::Range(1, 3))->required();
  app.add_option("--kind", kind, "a kind")->check(CLI::IsMember({"a", "b"}));
  std::vector<char*> argv{const_cast<char*>("kintsugi-test")};
  for (std::string& argument : arguments) argv.push_back(argument.data());
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  const int code = run_program(app, static_cast<int>(argv.size()), argv.data(), work);
  std::fflush(stdout);
  return {code, testing::internal::GetCapturedStdout(), testing::internal::GetCapturedStderr()};
}

void expect_one_line_that_says(const Outcome& outcome, const std::string& what) {
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, StartsWith("kintsugi-test: "));
  EXPECT_THAT(outcome.err, HasSubstr(what));
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  EXPECT_EQ(outcome.out, "");
}

TEST(Program, DoesItsWork) {
  const Outcome outcome = run({"--number", "2"}, [] { std::printf("done\n"); });
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(outcome.out, "done\n");
  EXPECT_EQ(outcome.err, "");
}

TEST(Program, WrongUseIsOneLineAndCode1) {
  const auto never = [] { FAIL() << "wrong use must not reach the work"; };
  expect_one_line_that_says(run({}, never), "--number is required");
  expect_one_line_that_says(run({"--number", "2", "--colour"}, never), "--colour");
  expect_one_line_that_says(run({"--number", "7"}, never), "--number");
  expect_one_line_that_says(run({"--number", "x"}, never), "--number");
  expect_one_line_that_says(run({"--number", "2", "--kind", "c"}, never), "--kind");
  expect_one_line_that_says(run({"--number"}, never), "--number");
}

TEST(Program, ErrorsOfTheWorkAreOneLineAndCode1) {
  const std::vector<std::string> good{"--number", "2"};
  expect_one_line_that_says(run(good, [] { throw Error("no such file"); }), "no such file");
  expect_one_line_that_says(run(good, [] { throw std::runtime_error("first\nsecond"); }), "first second");
}

TEST(Program, HelpIsAnAnswerNotAnError) {
  const Outcome outcome = run({"--help"}, [] { FAIL(); });
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_THAT(outcome.out, HasSubstr("A program of the test."));
}

}  // namespace
}  // namespace kt
