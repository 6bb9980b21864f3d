// Items to events, as long as there is room.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/publish/log_store.h"

#include <cmath>
#include <limits>
#include <string>
#include <sys/statvfs.h>
#include <utility>

#include "shared/core/check.h"
#include "shared/wire/codec.h"

namespace kt {
namespace {

// Of the file system, for users other than root; where it does not tell there is room.
int64_t free_bytes_at(const std::filesystem::path& log) {
  struct statvfs status {};
  if (::statvfs(log.c_str(), &status) != 0) return std::numeric_limits<int64_t>::max();
  return static_cast<int64_t>(status.f_bavail) * static_cast<int64_t>(status.f_frsize);
}

// Behind the reach of EdgeKey two places would share a key, and their surfaces weld. The margin is more than
// any volume's half.
void check_reach(const CloudSlice& slice) {
  const double reach_m = (EdgeKey::kLimit - (1 << 15)) * slice.voxel_size_m;
  if (slice.T_odom_camera.translation().cwiseAbs().maxCoeff() <= reach_m) return;
  throw Error(
      "the camera is more than " + std::to_string(static_cast<int64_t>(reach_m)) +
      " m away from where the mission began, further than voxels of this size can be named: take larger "
      "voxels (volume.voxel_size_m), or begin a new mission");
}

bool is_file(const std::filesystem::path& path) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(path, ignored);
}

}  // namespace

LogStore::LogStore(const std::filesystem::path& path, const Options& options)
    : writer_(path, {.overwrite = options.overwrite, .max_file_bytes = options.max_file_bytes}),
      options_(options),
      watches_disk_(options.free_bytes != nullptr || is_file(path)),
      policy_(options.reserve_bytes) {}

void LogStore::store(const LogItem& item) {
  if (watches_disk_)
    policy_.see_free_bytes(options_.free_bytes ? options_.free_bytes(path()) : free_bytes_at(path()));
  std::visit(
      [this]<typename T>(const T& message) {
        if (!policy_.wants<T>()) return count_dropped<T>();
        if constexpr (std::is_same_v<T, RgbdFrame>) {
          store_message(compress(message, options_.frames));
        } else if constexpr (std::is_same_v<T, CloudSlice>) {
          store_slice(message);
        } else {
          store_message(message);
        }
      },
      item);
}

void LogStore::store_slice(const CloudSlice& slice) {
  check_reach(slice);
  const size_t most = options_.max_slice_triangles;
  if (slice.triangles.size() <= most && slice.vertices.size() <= 3 * most) return store_message(slice);
  for (const CloudSlice& part : split_slice(slice, most)) store_message(part);
}

template <typename T>
void LogStore::store_message(const T& message) {
  try {
    if constexpr (std::is_same_v<T, SessionHeader>) {
      writer_.begin(message);
      writer_.write_session();
    } else {
      writer_.write(channel_of<T>(), message.timestamp_us,
                    encode(message, next_sequence_[message_index<T>()]));
      ++next_sequence_[message_index<T>()];
    }
  } catch (const DiskFullError&) {
    policy_.see_refusal();
    return count_dropped<T>();
  }
  policy_.see_success();
  if (next_sync_ == Clock::time_point::max()) next_sync_ = Clock::now() + options_.sync_interval;
}

template <typename T>
void LogStore::count_dropped() {
  if constexpr (std::is_same_v<T, RgbdFrame> || std::is_same_v<T, CompressedFrame>) {
    ++counts_.raw_frames;
    ++next_sequence_[message_index<CompressedFrame>()];
  } else if constexpr (!std::is_same_v<T, SessionHeader>) {  // the session is tried again with each event
    constexpr bool kIsMotion = std::is_same_v<T, MotionSample>, kIsKeyframe = std::is_same_v<T, Keyframe>,
                   kIsSlice = std::is_same_v<T, CloudSlice>, kIsPose = std::is_same_v<T, StampedPose>;
    ++(kIsMotion     ? counts_.motion_samples
       : kIsKeyframe ? counts_.keyframes
       : kIsSlice    ? counts_.slices
       : kIsPose     ? counts_.poses
                     : counts_.others);
    ++next_sequence_[message_index<T>()];
  }
}

void LogStore::drop(const LogItem& item) {
  std::visit([this]<typename T>(const T&) { count_dropped<T>(); }, item);
}

void LogStore::sync_if_due() {
  if (Clock::now() < next_sync_) return;
  next_sync_ = Clock::time_point::max();
  try {
    writer_.sync();
  } catch (const DiskFullError&) {
    policy_.see_refusal();
  }
}

void LogStore::close() { writer_.close(); }

StorageState LogStore::state() const {
  StorageState state = counts_;
  state.level = policy_.level();
  return state;
}

}  // namespace kt
