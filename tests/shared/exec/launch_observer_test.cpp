// Tests of what an observer is told, and that the search for a difference names the kernel which made it.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/exec/launch_observer.h"

#include <memory>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

#include "shared/core/digest.h"
#include "shared/exec/compact.h"
#include "shared/exec/for_each.h"
#include "shared/types/slice_vertex.h"
#include "tests/shared/exec/exec_test_kernels.h"
#include "tests/support/parity.h"

namespace kt::test {
namespace {

using exec::Buffer, exec::Device;
using testing::AllOf, testing::ElementsAre, testing::HasSubstr, testing::IsEmpty, testing::StartsWith;

struct Diary final : exec::LaunchObserver {
  std::vector<std::string> lines;
  void on_allocated(const void*, int64_t size, size_t element_bytes, const std::type_info& element) override {
    lines.push_back("allocated " + std::to_string(size) + " of " + readable_name(element.name()) + ", " +
                    std::to_string(element_bytes) + " bytes each");
  }
  void on_released(const void*) override { lines.push_back("released"); }
  void on_launched(const char* kernel, int64_t elements) override {
    lines.push_back(readable_name(kernel) + " over " + std::to_string(elements));
  }
};

TEST(LaunchObserver, IsToldOfBuffersAndOfEveryKindOfLaunch) {
  for (const Device& device : parity_devices()) {
    const auto diary = std::make_shared<Diary>();
    {
      const Device observed = device.observed_by(diary);
      Buffer<int64_t> slots(observed, 64);
      Buffer<float> empty(observed, 0);
      exec::for_each(observed, 5, AddIndex{slots.data()});
      exec::for_each_lane(observed, 16, AddLaneIndex{slots.data()});
      exec::for_each_pixel(observed, 3, 2, AddPixel{slots.data(), 3});
      Buffer<int32_t> numbers(observed, 8);
      numbers.upload(std::vector<int32_t>{1, 2, 3});
      exec::exclusive_scan(observed, numbers.data(), 3, numbers.data() + 4);
      Buffer<uint8_t> flags = Buffer<uint8_t>(observed, 7);
      exec::compact_flags(observed, flags.data(), 7, numbers.data());
      exec::ReductionWorkspace workspace(observed, 10);
      exec::reduce_normal_equations(observed, 10, RandomResidual{1, 2}, workspace);
    }
    EXPECT_THAT(diary->lines,
                ElementsAre("allocated 64 of long, 8 bytes each", "kt::test::AddIndex over 5",
                            "kt::test::AddLaneIndex over 16", "kt::test::AddPixel over 6",
                            "allocated 8 of int, 4 bytes each", "upload over 3", "exclusive_scan over 3",
                            "allocated 7 of unsigned char, 1 bytes each", "compact_flags over 7",
                            "allocated 47 of float, 4 bytes each", "kt::test::RandomResidualOf<6> over 10",
                            "released", "released", "released", "released"))
        << name_of(device);
  }
}

// Four frames of two launches; `wrong` says which element of AddIndexBut errs where.
template <typename Wrong>
ParityRun counting(const Wrong& wrong) {
  return [wrong](const Device& device, const FrameMark& frame_mark) {
    Buffer<int64_t> before(device, 10), slots(device, 100);
    for (int64_t frame = 0; frame < 4; ++frame) {
      frame_mark(frame);
      exec::for_each(device, 10, AddIndex{before.data()});
      exec::for_each(device, 100, AddIndexBut{slots.data(), wrong(device, frame)});
    }
    Digest digest;
    for (const int64_t value : slots.downloaded()) digest.add(value);
    return digest.value();
  };
}

TEST(Parity, NamesKernelFrameAndElement) {
  const ParityRun run = counting(
      [](const Device& device, int64_t frame) { return device.threads() == 3 && frame >= 2 ? 77 : -1; });
  // After three frames slot 77 holds 3 * 78 = 0xea; 256 more is 0x1ea.
  EXPECT_EQ(disagreement(run, {Device::cpu(1), Device::cpu(2), Device::cpu(3)}),
            "other results on cpu, 3 threads than on cpu, 1 threads: kt::test::AddIndexBut over 100 elements "
            "(frame 2, launch 6) left another element 77 in buffer 1, long[100]: bytes ea000000 00000000 on "
            "cpu, 1 threads, ea010000 00000000 on cpu, 3 threads; 0 more elements differ");
}

TEST(Parity, SaysNothingWhereNothingDiffers) {
  const ParityRun run = counting([](const Device&, int64_t) { return 5; });
  EXPECT_THAT(disagreement(run), IsEmpty());
  EXPECT_THAT(first_difference(Device::cpu(1), Device::cpu(2), run), IsEmpty());
  EXPECT_THAT(kernels_of(run), ElementsAre("kt::test::AddIndex", "kt::test::AddIndexBut"));
}

TEST(Parity, NamesTheLaunchThatOnlyOneDeviceMakes) {
  const ParityRun more_on_two = [](const Device& device, const FrameMark& frame_mark) {
    frame_mark(7);
    Buffer<int64_t> slots(device, 8);
    for (int i = 0; i < device.threads(); ++i) exec::for_each(device, 8, AddIndex{slots.data()});
    return static_cast<uint64_t>(slots.downloaded()[0]);
  };
  EXPECT_THAT(first_difference(Device::cpu(1), Device::cpu(2), more_on_two),
              AllOf(HasSubstr("the host"), HasSubstr("the end of the run after 1 launches on cpu, 1 threads"),
                    HasSubstr("AddIndex over 8 elements (frame 7, launch 2) on cpu, 2 threads")));
  const ParityRun longer_on_two = [](const Device& device, const FrameMark&) {
    Buffer<int64_t> slots(device, 8);
    exec::for_each(device, device.threads(), AddIndex{slots.data()});
    return uint64_t{0};
  };
  EXPECT_THAT(first_difference(Device::cpu(1), Device::cpu(2), longer_on_two),
              AllOf(HasSubstr("over 1 elements"), HasSubstr("over 2 elements")));
  const ParityRun larger_on_two = [](const Device& device, const FrameMark&) {
    Buffer<int64_t> slots(device, 8 * device.threads());
    exec::for_each(device, 8, AddIndex{slots.data()});
    return uint64_t{0};
  };
  EXPECT_THAT(first_difference(Device::cpu(1), Device::cpu(2), larger_on_two), HasSubstr("other buffers"));
}

TEST(Parity, SaysWhereTheBuffersAreInnocent) {
  const ParityRun run = [](const Device& device, const FrameMark&) {
    return static_cast<uint64_t>(device.threads());
  };
  EXPECT_THAT(disagreement(run),
              AllOf(StartsWith("other results on cpu, 2 threads"), HasSubstr("host code")));
}

TEST(Parity, PaddingIsNoDifference) {
  const ParityRun run = [](const Device& device, const FrameMark&) {
    std::vector<SliceVertex> vertices(3);
    auto* bytes = reinterpret_cast<uint8_t*>(&vertices[1]);
    bytes[offsetof(SliceVertex, colour) + 3] = static_cast<uint8_t>(device.threads());
    Buffer<SliceVertex> buffer(device, 3);
    buffer.upload(vertices);
    return uint64_t{0};
  };
  EXPECT_EQ(first_difference(Device::cpu(1), Device::cpu(2), run), "");
}

TEST(Parity, ARunThatThrowsEndsTheSearch) {
  const ParityRun run = [](const Device& device, const FrameMark&) -> uint64_t {
    Buffer<int64_t> slots(device, 8);
    exec::for_each(device, 8, AddIndex{slots.data()});
    if (device.threads() == 2) throw Error("stopped");
    exec::for_each(device, 8, AddIndex{slots.data()});
    return 0;
  };
  EXPECT_THROW(first_difference(Device::cpu(1), Device::cpu(2), run), Error);
}

}  // namespace
}  // namespace kt::test
