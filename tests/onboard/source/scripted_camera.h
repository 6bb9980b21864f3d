// A camera that does what a test says, and clocks that stand until it waits.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <utility>

#include "onboard/source/camera_source.h"
#include "shared/core/check.h"

namespace kt::test {

/// What happens at the place where a camera is plugged in: events, and the words "gone" (unplugged) and
/// "away" (an attempt to open it that fails).
struct Script {
  struct Step {
    CameraEvent event{};
    std::string gone{}, away{};
  };
  std::deque<Step> steps;
  CameraInfo info{.name = "scripted"};
  int64_t wall_us = 1'000'000'000'000, steady_us = 0;
  int opened = 0;
  std::vector<int64_t> waits_ms;

  Script& depth(int64_t us, int64_t counter,
                const Image<uint16_t>& image = Image<uint16_t>(4, 4, uint16_t{1000})) {
    steps.push_back({.event = {.kind = CameraEvent::Kind::kDepth,
                               .is_depth = true,
                               .stamp_us = us,
                               .counter = counter,
                               .depth = image}});
    return *this;
  }
  Script& colour(int64_t us, const Image<Rgb8>& image = Image<Rgb8>(4, 4)) {
    steps.push_back({.event = {.kind = CameraEvent::Kind::kColour, .stamp_us = us, .colour = image}});
    return *this;
  }
  Script& frame(int64_t us, int64_t counter) { return depth(us, counter).colour(us); }
  Script& event(CameraEvent event) {
    steps.push_back({.event = std::move(event)});
    return *this;
  }
  Script& gone(const std::string& why = "unplugged") {
    steps.push_back({.gone = why});
    return *this;
  }
  Script& away(int times) {
    for (int i = 0; i < times; ++i) steps.push_back({.away = "not plugged in"});
    return *this;
  }

  CameraClock clock() {
    return {[this] { return wall_us; }, [this] { return steady_us; },
            [this](std::chrono::milliseconds time) {
              waits_ms.push_back(time.count());
              steady_us += 1000 * time.count();
            }};
  }
  CameraOpener opener();
};

class ScriptedCamera final : public CameraDevice {
 public:
  explicit ScriptedCamera(Script& script) : script_(script) {}
  CameraEvent read(std::chrono::milliseconds timeout) override {
    if (script_.steps.empty()) return {.kind = CameraEvent::Kind::kEnd};
    Script::Step step = std::move(script_.steps.front());
    script_.steps.pop_front();
    if (!step.gone.empty()) throw Error(step.gone);
    KT_CHECK(step.away.empty(), "the script says away while the camera is there");
    script_.steady_us += step.event.kind == CameraEvent::Kind::kNothing ? 1000 * timeout.count()
                         : step.event.is_depth                          ? 33'000
                                                                        : 0;
    return std::move(step.event);
  }
  const CameraInfo& info() const override { return script_.info; }

 private:
  Script& script_;
};

inline CameraOpener Script::opener() {
  return [this]() -> std::unique_ptr<CameraDevice> {
    if (!steps.empty() && !steps.front().away.empty()) {
      const std::string why = steps.front().away;
      steps.pop_front();
      throw Error(why);
    }
    ++opened;
    return std::make_unique<ScriptedCamera>(*this);
  };
}

}  // namespace kt::test
