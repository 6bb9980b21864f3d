// The same work on every device, compared bit for bit; on a difference, the first kernel, frame and element
// of it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "tests/support/devices.h"

namespace kt::test {

/// Says that the next frame of a run begins.
using FrameMark = std::function<void(int64_t frame)>;
/// Drives kernels on `device` and digests what comes of them. It does the same every time, and is called from
/// two threads at once.
using ParityRun = std::function<uint64_t(const exec::Device& device, const FrameMark& frame_mark)>;

/// Runs on each of `devices` and compares the digests with that of the first. "" where all are equal, else
/// which device disagrees, and the first_difference between the two.
std::string disagreement(const ParityRun& run, const std::vector<exec::Device>& devices = parity_devices());

/// Runs on both devices in step: after every launch each waits for the other, and all their buffers are
/// compared byte by byte. Says after which launch of which kernel in which frame they first differ, in which
/// element of which buffer, and both values; "" where they never do. Slow: for small images and volumes.
std::string first_difference(const exec::Device& reference, const exec::Device& other, const ParityRun& run);

/// What a run launches on one CPU thread, over at least one element: functors as in "kt::FuseColumns", and
/// the others of LaunchObserver.
std::set<std::string> kernels_of(const ParityRun& run);

/// The functors that a .cu file lists.
std::set<std::string> kernels_listed_in(const std::filesystem::path& cu_file);

/// A type's name as in the source.
std::string readable_name(const char* mangled);

}  // namespace kt::test
