// kintsugi-core-bench: times the kernels' stages over closed-form scenes; needs nothing beyond the core.
// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>

#include "shared/core/check.h"
#include "shared/core/version.h"
#include "tools/bench/device_bench.h"
#include "tools/bench/stage_run.h"
#include "tools/bench/suite.h"

namespace kt::bench {
namespace {

constexpr const char* kUsage =
    "kintsugi-core-bench [OPTIONS]: times preprocessing, tracking, integration and raycast, the device's "
    "memory\n"
    "bandwidth and the share of it that integration and raycast reach at least; prints JSON\n"
    "  --device D            where kernels run: cpu, cuda, or auto: cuda where there is a usable GPU, else "
    "cpu "
    "(auto)\n"
    "  --threads N           CPU threads, 0 = all cores (0)\n"
    "  --frames N            frames to time, after ten that are not (100; 20 of each run of the suite)\n"
    "  --resolution N        voxels per axis of the volume (512)\n"
    "  --voxel-size-m X      (0.01)\n"
    "  --image-width N       pixels; the height is 3/4 of it (640)\n"
    "  --suite               instead of one run: volumes of 256 and 512 voxels of 1 cm and 5 mm, growth with "
    "the\n"
    "                        sizes of image and volume, a long mission, and what equal bits cost in a sum\n"
    "  --mission-frames N    of the suite's long mission (2000)\n"
    "  --help, --version\n";

struct Options {
  std::string device = "auto";
  int threads = 0;
  RunSetup run;
  SuiteSetup suite;
  bool is_suite = false;
};

double number(const std::string& name, const char* text, double low, double high) {
  char* end = nullptr;
  const double value = text ? std::strtod(text, &end) : 0;
  if (!text || end == text || *end != '\0' || !(value >= low && value <= high))
    throw Error(name + " needs a number from " + std::to_string(low) + " to " + std::to_string(high));
  return value;
}

Options parse(int argc, char** argv) {
  Options options;
  std::string run_option, suite_option;  // one that only a single run, or only the suite has
  for (int i = 1; i < argc; ++i) {
    const std::string name = argv[i];
    if (name == "--suite") {
      options.is_suite = true;
      continue;
    }
    const char* value = ++i < argc ? argv[i] : nullptr;
    if (name == "--device") {
      if (!value) throw Error("--device needs auto, cpu or cuda");
      options.device = value;
    } else if (name == "--threads") {
      options.threads = static_cast<int>(number(name, value, 0, 1024));
    } else if (name == "--frames") {
      options.run.frames = options.suite.frames = static_cast<int>(number(name, value, 1, 100'000));
    } else if (name == "--resolution") {
      options.run.volume.resolution = static_cast<int>(number(run_option = name, value, 32, 2048));
    } else if (name == "--voxel-size-m") {
      options.run.volume.voxel_size_m = number(run_option = name, value, 1e-3, 1);
    } else if (name == "--image-width") {
      options.run.image_width = static_cast<int>(number(run_option = name, value, 64, 4096)) / 8 * 8;
    } else if (name == "--mission-frames") {
      options.suite.mission_frames = static_cast<int>(number(suite_option = name, value, 1, 100'000));
    } else {
      throw Error("there is no option " + name + "; --help explains");
    }
  }
  if (options.is_suite && !run_option.empty()) throw Error(run_option + " does not go with --suite");
  if (!options.is_suite && !suite_option.empty()) throw Error(suite_option + " needs --suite");
  return options;
}

void add_bandwidth(JsonText& json, const Bandwidth& bandwidth) {
  json.open("bandwidth");
  json.add("bytes_per_array", bandwidth.bytes_per_array);
  json.add("gb_per_s", bandwidth.gb_per_s, 2);
  json.close();
}

void add_reductions(JsonText& json, const ReductionCost& cost) {
  json.open("reductions");
  json.add("residuals", cost.residuals);
  json.add("fixed_order_ms", cost.fixed_order_ms, 4);
  json.add("unordered_ms", cost.unordered_ms, 4);
  json.add("fixed_to_unordered", cost.fixed_order_ms / cost.unordered_ms, 3);
  if (cost.contracted_ms) {
    json.add("contracted_ms", *cost.contracted_ms, 4);
    json.add("fixed_to_contracted", cost.fixed_order_ms / *cost.contracted_ms, 3);
  }
  json.close();
}

void run(const Options& options) {
  const exec::Device device = exec::Device::from_name(options.device, options.threads);
  const Bandwidth bandwidth = measure_bandwidth(device);
  JsonText json;
  json.add("program_version", kProgramVersion);
  json.add("device", device.name());
  json.add("threads", device.threads());
  add_bandwidth(json, bandwidth);
  if (options.is_suite) {
    add_reductions(json, measure_reductions(device));
    add_suite(json, device, options.suite, bandwidth.gb_per_s);
  } else {
    add_run(json, run_stages(device, options.run), bandwidth.gb_per_s);
  }
  std::fputs(json.finish().c_str(), stdout);
}

}  // namespace
}  // namespace kt::bench

int main(int argc, char** argv) {
  const std::string first = argc > 1 ? argv[1] : "";
  if (first == "--help" || first == "-h") return std::fputs(kt::bench::kUsage, stdout), 0;
  if (first == "--version") return std::printf("kintsugi-core-bench %s\n", kt::kProgramVersion), 0;
  try {
    kt::bench::run(kt::bench::parse(argc, argv));
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "kintsugi-core-bench: %s\n", error.what());
    return 1;
  }
}
