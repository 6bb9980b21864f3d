// Plays frames to the recorder of OpenNI2.
// SPDX-License-Identifier: BSD-3-Clause
#include "tests/onboard/source/recorded_oni.h"

#include <OpenNI.h>
#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <thread>

#include "tests/onboard/source/simulated_openni2.h"

namespace kt::test {
namespace {

void must(openni::Status status) {
  if (status != openni::STATUS_OK) throw std::runtime_error(openni::OpenNI::getExtendedError());
}

// The recorder starts on a thread of its own and does not tell when: `patience` is how long it gets.
void record_once(const std::filesystem::path& path, const std::vector<RgbdFrame>& frames,
                 const std::vector<size_t>& without_colour, std::chrono::milliseconds patience) {
  openni::Device device;
  must(device.open("simulated/recorder"));
  openni::VideoStream depth, colour;
  must(depth.create(device, openni::SENSOR_DEPTH));
  must(colour.create(device, openni::SENSOR_COLOR));
  depth.setMirroringEnabled(false);
  colour.setMirroringEnabled(false);
  openni::Recorder recorder;
  must(recorder.create(path.c_str()));
  must(recorder.attach(depth, false));
  must(recorder.attach(colour, false));
  must(recorder.start());
  std::this_thread::sleep_for(patience);
  must(depth.start());
  must(colour.start());
  for (size_t i = 0; i < frames.size(); ++i) {
    const bool is_alone = std::find(without_colour.begin(), without_colour.end(), i) != without_colour.end();
    is_alone ? simulated_openni2().show_depth(frames[i]) : simulated_openni2().show(frames[i]);
  }
  openni::VideoStream* streams[] = {&depth, &colour};
  int ready = -1;
  while (openni::OpenNI::waitForAnyStream(streams, 2, &ready, 50) == openni::STATUS_OK) {
    openni::VideoFrameRef frame;
    must(streams[ready]->readFrame(&frame));
  }
  recorder.stop();
  recorder.destroy();
}

int64_t recorded_frames(const std::filesystem::path& path) {
  openni::Device device;
  must(device.open(path.c_str()));
  openni::VideoStream depth;
  must(depth.create(device, openni::SENSOR_DEPTH));
  return device.getPlaybackControl()->getNumberOfFrames(depth);
}

}  // namespace

void record_oni(const std::filesystem::path& path, const Calibration& calibration,
                const std::vector<RgbdFrame>& frames, const std::vector<size_t>& without_colour) {
  simulated_openni2().look_like(calibration);
  simulated_openni2().plug("simulated/recorder");
  must(openni::OpenNI::initialize());  // and never shut down: see openni2_camera.cpp
  for (int ms = 100; ms < 5000; ms *= 2) {
    record_once(path, frames, without_colour, std::chrono::milliseconds(ms));
    if (recorded_frames(path) == static_cast<int64_t>(frames.size())) break;
  }
  if (recorded_frames(path) != static_cast<int64_t>(frames.size()))
    throw std::runtime_error("the recorder lost frames");
  simulated_openni2().unplug();
}

}  // namespace kt::test
