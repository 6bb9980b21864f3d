// What a mission under way looks like from its messages, as text for whoever watches it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "shared/wire/channels.h"

namespace kt {

class LiveState {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// Takes a message that came at `now`. Counts only session, poses and status; another session than the one
  /// known begins another mission.
  void add(const Message& message, Time now);
  /// Where the mission is watched through its log: bytes of the log so far, and free on its disk.
  void set_disk(int64_t log_bytes, int64_t free_bytes, Time now);
  /// Of the computer that watches, where that is the collector's too.
  void set_temperature_here(int degrees_c) { temperature_here_c_ = degrees_c; }

  bool has_heard() const { return heard_.has_value(); }
  /// Since the last message that counts, or since `start` where there was none.
  double silence_s(Time start, Time now) const;

  /// A few lines, for a terminal.
  std::vector<std::string> lines(Time now) const;
  /// The same in one, for a file.
  std::string line(Time now) const;

 private:
  /// A count that rises, and when it was what: its rate is that of the last five seconds.
  class Rate {
   public:
    void add(int64_t count, Time now);
    double per_second(Time now) const;

   private:
    struct Sample {
      Time time;
      int64_t count;
    };
    std::deque<Sample> samples_;
  };

  void take(const SessionHeader& session);
  std::string tracking_text() const;
  std::string rate_text(Time now) const;
  std::string frames_text() const;
  std::string camera_text() const;
  std::string volume_text() const;
  std::string gaps_text() const;
  std::string disk_text(Time now) const;
  std::string temperature_text() const;

  std::optional<Time> heard_;
  std::optional<SessionHeader> session_;
  double voxel_size_m_ = 0;  ///< 0: no session was heard
  int resolution_ = 0;
  std::optional<StampedPose> pose_;
  std::optional<MissionStatus> status_;
  bool is_camera_gone_ = false;
  Rate frames_, log_bytes_per_;
  int64_t log_bytes_ = 0, free_bytes_ = -1;
  std::optional<int> temperature_here_c_;
};

}  // namespace kt
