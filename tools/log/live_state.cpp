// Keeps the newest of everything, and words it.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/log/live_state.h"

#include <algorithm>

#include "yaml-cpp/yaml.h"

#include "shared/core/formatted.h"

namespace kt {
namespace {

constexpr std::chrono::seconds kRateWindow{5};

double seconds(std::chrono::steady_clock::duration time) {
  return std::chrono::duration<double>(time).count();
}

// A collector repeats its session for who listens late.
bool is_same(const SessionHeader& a, const SessionHeader& b) {
  return a.timestamp_us == b.timestamp_us && a.program_version == b.program_version &&
         a.configuration_yaml == b.configuration_yaml && a.calibration.name == b.calibration.name &&
         a.calibration.is_equal_to(b.calibration);
}

}  // namespace

void LiveState::Rate::add(int64_t count, Time now) {
  if (!samples_.empty() && count < samples_.back().count) samples_.clear();  // another mission
  // Dense counts replace each other: ten a second are enough.
  const size_t size = samples_.size();
  if (size >= 2 && samples_[size - 1].time - samples_[size - 2].time < std::chrono::milliseconds(100))
    samples_.pop_back();
  samples_.push_back({now, count});
  while (samples_.size() > 2 && now - samples_[1].time >= kRateWindow) samples_.pop_front();
}

double LiveState::Rate::per_second(Time now) const {
  if (samples_.size() < 2) return 0;
  const double span_s = seconds(now - samples_.front().time);
  return span_s > 0 ? static_cast<double>(samples_.back().count - samples_.front().count) / span_s : 0;
}

void LiveState::take(const SessionHeader& session) {
  if (session_ && is_same(*session_, session)) return;
  // What was heard before the first session is of its mission, unless it is older.
  if (session_ || (pose_ && pose_->timestamp_us < session.timestamp_us)) *this = LiveState();
  session_ = session;
  try {
    const YAML::Node volume = YAML::Load(session.configuration_yaml)["volume"];
    voxel_size_m_ = volume["voxel_size_m"].as<double>(0);
    resolution_ = volume["resolution"].as<int>(0);
  } catch (const YAML::Exception&) {
    // a session of some other program: the volume is told in voxels
  }
}

void LiveState::add(const Message& message, Time now) {
  if (const auto* session = std::get_if<SessionHeader>(&message)) {
    take(*session);
  } else if (const auto* pose = std::get_if<StampedPose>(&message)) {
    pose_ = *pose;
    is_camera_gone_ = false;
    frames_.add(pose->sequence + 1, now);
  } else if (const auto* status = std::get_if<MissionStatus>(&message)) {
    status_ = *status;
    is_camera_gone_ = status->cause == TrackingCause::kNoFrames;
    frames_.add(status->frames, now);
  } else {
    return;
  }
  heard_ = now;
}

void LiveState::set_disk(int64_t log_bytes, int64_t free_bytes, Time now) {
  log_bytes_ = log_bytes;
  free_bytes_ = free_bytes;
  log_bytes_per_.add(log_bytes, now);
}

double LiveState::silence_s(Time start, Time now) const { return seconds(now - heard_.value_or(start)); }

std::string LiveState::tracking_text() const {
  if (is_camera_gone_) return "no frames: the camera is gone";
  if (!pose_) return status_ ? to_string(status_->tracking) : "not told yet";
  std::string why = to_string(pose_->source);
  if (pose_->cause != TrackingCause::kNone) why += std::string(", ") + to_string(pose_->cause);
  return formatted("%s (%s, %.0f %%)", to_string(pose_->status), why.c_str(),
                   100 * pose_->quality.inlier_share);
}

std::string LiveState::rate_text(Time now) const { return formatted("%.1f Hz", frames_.per_second(now)); }

std::string LiveState::frames_text() const {
  const int64_t newest = std::max(pose_ ? pose_->sequence + 1 : 0, status_ ? status_->frames : 0);
  std::string text = formatted("%lld frames", static_cast<long long>(newest));
  if (status_) {
    text += formatted(
        ", %lld uncertain, %lld lost, %lld dropped", static_cast<long long>(status_->frames_uncertain),
        static_cast<long long>(status_->frames_lost), static_cast<long long>(status_->frames_skipped));
  }
  return text;
}

std::string LiveState::camera_text() const {
  if (!pose_) return "not told yet";
  const auto& p = pose_->T_odom_camera.translation();
  return formatted("at %.2f %.2f %.2f m, segment %d", p.x(), p.y(), p.z(), pose_->segment);
}

std::string LiveState::volume_text() const {
  if (!status_) return "not told yet";
  const Vec3i& low = status_->volume_origin_voxel;
  if (voxel_size_m_ <= 0) return formatted("from voxel %d %d %d", low.x, low.y, low.z);
  const auto middle_m = [&](int origin) { return (origin + 0.5 * resolution_) * voxel_size_m_; };
  return formatted("around %.2f %.2f %.2f m, %lld slices left it", middle_m(low.x), middle_m(low.y),
                   middle_m(low.z), static_cast<long long>(status_->slices));
}

std::string LiveState::gaps_text() const {
  if (!status_ || status_->not_stored + status_->not_published == 0) return {};
  return formatted("%lld messages not stored, %lld not published",
                   static_cast<long long>(status_->not_stored),
                   static_cast<long long>(status_->not_published));
}

std::string LiveState::disk_text(Time now) const {
  if (free_bytes_ < 0) return {};
  const double rate = log_bytes_per_.per_second(now), space = static_cast<double>(free_bytes_);
  std::string text = formatted("log %.1f MB, +%.1f MB/s, %.1f GB free", static_cast<double>(log_bytes_) / 1e6,
                               rate / 1e6, space / 1e9);
  if (rate > 0) text += formatted(" (%.1f h)", space / rate / 3600);
  return text;
}

std::string LiveState::temperature_text() const {
  const int told = status_ ? status_->temperature_c : 0;
  const int degrees = told != 0 ? told : temperature_here_c_.value_or(0);
  return degrees != 0 ? formatted("%d C", degrees) : std::string();
}

std::vector<std::string> LiveState::lines(Time now) const {
  std::vector<std::string> lines = {
      "tracking     " + tracking_text(), "rate         " + rate_text(now), "frames       " + frames_text(),
      "camera       " + camera_text() + (session_ ? " (" + session_->calibration.name + ")" : ""),
      "volume       " + volume_text()};
  if (const std::string gaps = gaps_text(); !gaps.empty()) lines.push_back("gaps         " + gaps);
  if (const std::string disk = disk_text(now); !disk.empty()) lines.push_back("disk         " + disk);
  if (const std::string heat = temperature_text(); !heat.empty()) lines.push_back("temperature  " + heat);
  return lines;
}

std::string LiveState::line(Time now) const {
  std::string text = tracking_text() + "; " + rate_text(now) + "; " + frames_text() + "; camera " +
                     camera_text() + "; volume " + volume_text();
  for (const std::string& more : {gaps_text(), disk_text(now), temperature_text()})
    if (!more.empty()) text += "; " + more;
  return text;
}

}  // namespace kt
