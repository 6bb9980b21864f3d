// The publishing thread.
// SPDX-License-Identifier: BSD-3-Clause
#include "onboard/publish/lcm_sink.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "shared/core/check.h"
#include "shared/core/temperature.h"
#include "shared/wire/codec.h"

namespace kt {
namespace {

// Memory that a message takes while it waits.
size_t bytes_of(const CloudSlice& slice) {
  return slice.vertices.size() * sizeof(SliceVertex) + slice.triangles.size() * sizeof(slice.triangles[0]);
}
size_t bytes_of(const Keyframe& keyframe) {
  constexpr size_t kPerFeature = 3 * sizeof(float) + sizeof(Vec3f);
  return keyframe.u_px.size() * kPerFeature + keyframe.descriptors.size() +
         keyframe.depth.pixels().size_bytes() + keyframe.thumbnail.pixels().size_bytes();
}

}  // namespace

LcmSink::LcmSink(std::shared_ptr<LcmBus> bus, const Options& options)
    : bus_(std::move(bus)), options_(options), thread_([this] { run(); }) {}

LcmSink::~LcmSink() { close(); }

void LcmSink::close() {
  {
    const std::lock_guard lock(mutex_);
    if (!stopping_) stop_by_ = Clock::now() + options_.longest_close;
    stopping_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

LcmSink::Counts LcmSink::counts() const {
  const std::lock_guard lock(mutex_);
  return counts_;
}

void LcmSink::on_session(SessionHeader session) {
  {
    const std::lock_guard lock(mutex_);
    session_ = session;
    next_session_ = Clock::now() + options_.session_interval;
  }
  put_small(std::move(session));
}

void LcmSink::on_pose(StampedPose pose) {
  put_small(body_pose(pose, last_pose_ ? &*last_pose_ : nullptr, session_.calibration));
  last_pose_ = pose;
  put_small(std::move(pose));
}

void LcmSink::on_status(MissionStatus status) {
  if (const Clock::time_point now = Clock::now(); now >= next_temperature_) {
    temperature_c_ = hottest_temperature_c().value_or(0);
    next_temperature_ = now + std::chrono::seconds(1);
  }
  status.temperature_c = temperature_c_;
  const Counts so_far = counts();
  status.not_published = so_far.dropped + so_far.refused;
  put_small(std::move(status));
}

void LcmSink::put_small(Small message) {
  {
    const std::lock_guard lock(mutex_);
    small_.push_back(std::move(message));
    if (small_.size() > options_.max_queued_messages) {
      std::visit([this]<typename T>(const T&) { drop<T>(); }, small_.front());
      small_.pop_front();
    }
  }
  changed_.notify_all();
}

void LcmSink::put_large(Large message) {
  const auto size = [](const Large& any) {
    return std::visit([](const auto& m) { return bytes_of(m); }, any);
  };
  {
    const std::lock_guard lock(mutex_);
    large_bytes_ += size(message);
    large_.push_back(std::move(message));
    while (large_bytes_ > options_.max_queued_bytes) {
      large_bytes_ -= size(large_.front());
      std::visit([this]<typename T>(const T&) { drop<T>(); }, large_.front());
      large_.pop_front();
    }
  }
  changed_.notify_all();
}

// Its number is taken: what waited before it on its channel is gone already, what waits behind it comes
// later.
template <typename T>
void LcmSink::drop() {
  ++next_sequence_[message_index<T>()];
  ++counts_.dropped;
}

void LcmSink::run() {
  std::unique_lock lock(mutex_);
  while (true) {
    repeat_session();
    const bool is_paced = has_large();
    wait(lock, is_paced ? std::min(next_large_, next_session_) : next_session_,
         [&] { return !small_.empty() || stopping_ || (!is_paced && has_large()); });
    if (stopping_ && Clock::now() >= stop_by_) break;
    if (!small_.empty()) {
      send_small(lock);
    } else if (has_large() && Clock::now() >= next_large_) {
      send_large(lock);
    } else if (stopping_ && has_large()) {
      changed_.wait_until(lock, std::min(next_large_, stop_by_), [] { return false; });
    } else if (stopping_) {
      break;
    }
  }
  counts_.dropped += static_cast<int64_t>(small_.size() + large_.size() + parts_.size());
}

// Until there is something to do, or so long.
template <typename IsDue>
void LcmSink::wait(std::unique_lock<std::mutex>& lock, Clock::time_point until, const IsDue& is_due) {
  if (until == Clock::time_point::max()) {
    changed_.wait(lock, is_due);
  } else {
    changed_.wait_until(lock, until, is_due);
  }
}

// It waits in line like the others, but drops none of them.
void LcmSink::repeat_session() {
  const Clock::time_point now = Clock::now();
  if (stopping_ || now < next_session_) return;
  next_session_ = now + options_.session_interval;
  if (small_.size() < options_.max_queued_messages) small_.emplace_back(session_);
}

void LcmSink::send_small(std::unique_lock<std::mutex>& lock) {
  const Small message = std::move(small_.front());
  small_.pop_front();
  std::visit([&](const auto& m) { send(m, lock); }, message);
}

// The next part of the slice under way, else the next message.
void LcmSink::send_large(std::unique_lock<std::mutex>& lock) {
  if (parts_.empty()) {
    const Large message = std::move(large_.front());
    large_.pop_front();
    large_bytes_ -= std::visit([](const auto& m) { return bytes_of(m); }, message);
    if (const auto* keyframe = std::get_if<Keyframe>(&message)) return send(*keyframe, lock);
    lock.unlock();
    std::vector<CloudSlice> parts =
        split_slice(std::get<CloudSlice>(message), options_.max_part_triangles, options_.max_part_vertices);
    lock.lock();
    std::move(parts.begin(), parts.end(), std::back_inserter(parts_));
  }
  const CloudSlice part = std::move(parts_.front());
  parts_.pop_front();
  send(part, lock);
}

template <typename T>
void LcmSink::send(const T& message, std::unique_lock<std::mutex>& lock) {
  const int64_t sequence = next_sequence_[message_index<T>()]++;
  lock.unlock();
  size_t bytes = 0;
  bool sent = false;
  try {
    const MessageBytes data = encode(message, sequence);
    bytes = data.size();
    sent = bus_->publish(channel_of<T>(), data);
  } catch (const std::exception&) {
    // no message may hold its values: the log's sink says so aloud
  }
  lock.lock();
  if (sent) {
    ++counts_.messages;
    counts_.bytes += static_cast<int64_t>(bytes);
  } else {
    ++counts_.refused;
  }
  if constexpr (std::is_constructible_v<Large, T>) {
    const std::chrono::duration<double> pause(static_cast<double>(bytes) / options_.bytes_per_second);
    next_large_ = Clock::now() + std::chrono::duration_cast<Clock::duration>(pause);
  }
}

}  // namespace kt
