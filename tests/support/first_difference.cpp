// Two runs on two threads that meet after every launch; whoever comes last compares what both have in memory.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <atomic>
#include <barrier>
#include <cstddef>
#include <cstring>
#include <exception>
#include <memory>
#include <optional>
#include <span>
#include <thread>

#include "shared/exec/buffer.h"
#include "shared/exec/launch_observer.h"
#include "shared/types/slice_vertex.h"
#include "tests/support/parity.h"

namespace kt::test {
namespace {

struct LiveBuffer {
  int64_t number = 0;  // in the order of allocation
  const void* data = nullptr;
  int64_t size = 0;
  size_t element_bytes = 0;
  const std::type_info* element = nullptr;

  bool has_shape_of(const LiveBuffer& other) const {
    return number == other.number && size == other.size && *element == *other.element;
  }
  std::string name() const {
    return "buffer " + std::to_string(number) + ", " + readable_name(element->name()) + "[" +
           std::to_string(size) + "]";
  }
};

// Where one of the runs stands; read by the other's thread only while both wait.
struct Side {
  exec::Device device;
  int64_t allocations = 0, frame = -1, launches = 0, elements = 0;
  const char* kernel = "";
  std::vector<LiveBuffer> buffers{};
  bool has_ended = false;

  std::string launch() const {
    if (has_ended) return "the end of the run after " + std::to_string(launches) + " launches";
    return readable_name(kernel) + " over " + std::to_string(elements) + " elements (" +
           (frame < 0 ? "before the first frame" : "frame " + std::to_string(frame)) + ", launch " +
           std::to_string(launches) + ")";
  }
};

// A buffer's bytes where the host can read them: in place, or in `copy`. What has no meaning in them is
// zeroed: SliceVertex alone has padding, a byte after its colour.
std::span<const uint8_t> bytes_of(const exec::Device& device, const LiveBuffer& buffer,
                                  std::vector<uint8_t>& copy) {
  const size_t size = static_cast<size_t>(buffer.size) * buffer.element_bytes;
  const bool has_padding = *buffer.element == typeid(SliceVertex);
  if (!device.is_cuda() && !has_padding) return {static_cast<const uint8_t*>(buffer.data), size};
  copy.resize(size);
  exec::copy_to_host(device, copy.data(), buffer.data, size);
  if (has_padding) {
    constexpr size_t kPadding = offsetof(SliceVertex, colour) + sizeof(Rgb8);
    static_assert(kPadding + 1 == offsetof(SliceVertex, weight));
    for (size_t i = kPadding; i < size; i += sizeof(SliceVertex)) copy[i] = 0;
  }
  return copy;
}

std::string hex(const uint8_t* bytes, size_t count) {
  static constexpr char kDigits[] = "0123456789abcdef";
  std::string text;
  for (size_t i = 0; i < count; ++i) {
    if (i > 0 && i % 4 == 0) text += ' ';
    text += {kDigits[bytes[i] >> 4], kDigits[bytes[i] & 15]};
  }
  return text;
}

class Lockstep {
 public:
  Lockstep(const exec::Device& reference, const exec::Device& other)
      : sides_{Side{.device = reference}, Side{.device = other}}, meeting_(2, Compare{this}) {}

  Side& side(size_t which) { return sides_[which]; }
  /// Waits for the other side, unless they have parted already.
  void meet() {
    if (!has_parted_) meeting_.arrive_and_wait();
  }
  void end(size_t which) {
    sides_[which].has_ended = true;
    meeting_.arrive_and_drop();
  }
  const std::string& difference() const { return difference_; }

 private:
  struct Compare {
    Lockstep* lockstep;
    void operator()() const noexcept { lockstep->compare(); }
  };

  void compare() {
    if (has_parted_ || (sides_[0].has_ended && sides_[1].has_ended)) return;
    try {
      difference_ = found_difference();
    } catch (const std::exception& failure) {  // of a GPU that has failed
      difference_ = "buffers cannot be read after " + sides_[0].launch() + ": " + failure.what();
    }
    has_parted_ = !difference_.empty();
  }

  std::string found_difference() {
    const auto& [a, b] = sides_;
    const bool same_launch = !a.has_ended && !b.has_ended && std::strcmp(a.kernel, b.kernel) == 0 &&
                             a.elements == b.elements && a.frame == b.frame;
    if (!same_launch || !std::equal(a.buffers.begin(), a.buffers.end(), b.buffers.begin(), b.buffers.end(),
                                    [](const auto& x, const auto& y) { return x.has_shape_of(y); })) {
      return "after equal bytes the host does not go on alike: " + a.launch() + " on " + name_of(a.device) +
             ", " + b.launch() + " on " + name_of(b.device) + (same_launch ? ", and other buffers" : "");
    }
    for (size_t i = 0; i < a.buffers.size(); ++i) {
      const std::span<const uint8_t> in_a = bytes_of(a.device, a.buffers[i], copies_[0]),
                                     in_b = bytes_of(b.device, b.buffers[i], copies_[1]);
      if (std::memcmp(in_a.data(), in_b.data(), in_a.size()) != 0)
        return a.launch() + " left " + difference_in(a.buffers[i], in_a, in_b);
    }
    return "";
  }

  std::string difference_in(const LiveBuffer& buffer, std::span<const uint8_t> in_a,
                            std::span<const uint8_t> in_b) const {
    const size_t step = buffer.element_bytes;
    std::optional<size_t> first;
    int64_t others = -1;
    for (size_t i = 0; i < in_a.size(); i += step) {
      if (std::memcmp(&in_a[i], &in_b[i], step) == 0) continue;
      if (!first) first = i;
      ++others;
    }
    return "another element " + std::to_string(*first / step) + " in " + buffer.name() + ": bytes " +
           hex(&in_a[*first], step) + " on " + name_of(sides_[0].device) + ", " + hex(&in_b[*first], step) +
           " on " + name_of(sides_[1].device) + "; " + std::to_string(others) + " more elements differ";
  }

  std::array<Side, 2> sides_;
  std::array<std::vector<uint8_t>, 2> copies_;
  std::string difference_;
  std::atomic<bool> has_parted_ = false;  // a difference was found: both go on alone
  std::barrier<Compare> meeting_;
};

class OneSide final : public exec::LaunchObserver {
 public:
  OneSide(Lockstep& lockstep, size_t which) : lockstep_(lockstep), side_(lockstep.side(which)) {}

  void on_allocated(const void* data, int64_t size, size_t element_bytes,
                    const std::type_info& element) override {
    side_.buffers.push_back({side_.allocations++, data, size, element_bytes, &element});
  }
  void on_released(const void* data) override {
    std::erase_if(side_.buffers, [data](const LiveBuffer& buffer) { return buffer.data == data; });
  }
  void on_launched(const char* kernel, int64_t elements) override {
    side_.kernel = kernel;
    side_.elements = elements;
    ++side_.launches;
    lockstep_.meet();
  }

 private:
  Lockstep& lockstep_;
  Side& side_;
};

}  // namespace

std::string first_difference(const exec::Device& reference, const exec::Device& other, const ParityRun& run) {
  Lockstep lockstep(reference, other);
  std::array<std::exception_ptr, 2> failures;
  const auto drive = [&](size_t which) {
    Side& side = lockstep.side(which);
    try {
      run(side.device.observed_by(std::make_shared<OneSide>(lockstep, which)),
          [&side](int64_t frame) { side.frame = frame; });
    } catch (...) {
      failures[which] = std::current_exception();
    }
    lockstep.end(which);
  };
  std::thread second(drive, 1);
  drive(0);
  second.join();
  for (const std::exception_ptr& failure : failures) {
    if (failure) std::rethrow_exception(failure);
  }
  return lockstep.difference();
}

}  // namespace kt::test
