// Digests first, which cost nothing; the search for the culprit only where they differ.
// SPDX-License-Identifier: BSD-3-Clause
#include "tests/support/parity.h"

#include <cstdlib>
#include <cxxabi.h>
#include <fstream>
#include <iterator>
#include <memory>
#include <regex>

#include "shared/core/check.h"
#include "shared/exec/launch_observer.h"

namespace kt::test {
namespace {

const FrameMark kNoMark = [](int64_t) {};

class KernelNames final : public exec::LaunchObserver {
 public:
  void on_allocated(const void*, int64_t, size_t, const std::type_info&) override {}
  void on_released(const void*) override {}
  void on_launched(const char* kernel, int64_t elements) override {
    if (elements > 0) names.insert(readable_name(kernel));
  }

  std::set<std::string> names;
};

}  // namespace

std::string disagreement(const ParityRun& run, const std::vector<exec::Device>& devices) {
  const exec::Device& reference = devices.front();
  const uint64_t expected = run(reference, kNoMark);
  for (size_t i = 1; i < devices.size(); ++i) {
    if (run(devices[i], kNoMark) == expected) continue;
    const std::string difference = first_difference(reference, devices[i], run);
    return "other results on " + name_of(devices[i]) + " than on " + name_of(reference) + ": " +
           (difference.empty()
                ? "yet in a second run, in step, every buffer was the same after every launch; "
                  "so either host code differs, or it does not happen every time"
                : difference);
  }
  return "";
}

std::set<std::string> kernels_of(const ParityRun& run) {
  const auto observer = std::make_shared<KernelNames>();
  run(exec::Device::cpu(1).observed_by(observer), kNoMark);
  return observer->names;
}

std::set<std::string> kernels_listed_in(const std::filesystem::path& cu_file) {
  const std::regex instance(R"(KT_INSTANTIATE_\w+\(([^()]+)\))");
  std::ifstream file(cu_file);
  if (!file) throw Error("no file " + cu_file.string());
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  std::set<std::string> kernels;
  for (std::sregex_iterator i(text.begin(), text.end(), instance), end; i != end; ++i)
    kernels.insert((*i)[1]);
  return kernels;
}

std::string readable_name(const char* mangled) {
  int status = 0;
  const std::unique_ptr<char, decltype(&std::free)> name(
      abi::__cxa_demangle(mangled, nullptr, nullptr, &status), &std::free);
  return status == 0 ? name.get() : mangled;
}

}  // namespace kt::test
