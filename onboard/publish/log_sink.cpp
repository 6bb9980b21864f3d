// The writer thread of a log.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/publish/log_sink.h"

#include <utility>

#include "shared/core/check.h"
#include "shared/wire/codec.h"

namespace kt {
namespace {

// A few frames with everything that belongs to them: enough to ride out a slow write, little memory.
constexpr size_t kQueueCapacity = 32;

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

}  // namespace

LogSink::LogSink(const std::filesystem::path& path, const Options& options)
    : writer_(path, options.overwrite),
      compression_(options.frames),
      max_slice_triangles_(options.max_slice_triangles),
      thread_([this] { run(); }) {}

LogSink::~LogSink() { stop(); }

void LogSink::close() {
  stop();
  if (failure_) std::rethrow_exception(failure_);
  writer_.close();
}

void LogSink::stop() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void LogSink::put(Item item) {
  std::unique_lock lock(mutex_);
  KT_CHECK(!stopping_, "the log is closed");
  changed_.wait(lock, [this] { return queue_.size() < kQueueCapacity || failure_; });
  if (failure_) std::rethrow_exception(failure_);
  queue_.push_back(std::move(item));
  changed_.notify_all();
}

void LogSink::run() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return !queue_.empty() || stopping_; });
    if (queue_.empty()) return;
    const Item item = std::move(queue_.front());
    queue_.pop_front();
    changed_.notify_all();
    lock.unlock();
    try {
      store(item);
      lock.lock();
    } catch (...) {
      lock.lock();
      failure_ = std::current_exception();
      queue_.clear();
      changed_.notify_all();
      return;
    }
  }
}

void LogSink::store(const Item& item) {
  const auto write = [this]<typename T>(const T& message) {
    int64_t& sequence = next_sequence_[message_index<T>()];
    writer_.write(channel_of<T>(), message.timestamp_us, encode(message, sequence));
    ++sequence;
  };
  std::visit(
      [&]<typename T>(const T& message) {
        if constexpr (std::is_same_v<T, RgbdFrame>) {
          write(compress(message, compression_));
        } else if constexpr (std::is_same_v<T, CloudSlice>) {
          check_reach(message);
          if (message.triangles.size() <= max_slice_triangles_ &&
              message.vertices.size() <= 3 * max_slice_triangles_) {
            return write(message);
          }
          for (const CloudSlice& part : split_slice(message, max_slice_triangles_)) write(part);
        } else {
          write(message);
        }
      },
      item);
}

}  // namespace kt
