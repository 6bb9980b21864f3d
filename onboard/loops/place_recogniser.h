// Finds places seen before: keyframes, their words, candidates and the proof of each.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "onboard/loops/keyframe_index.h"
#include "onboard/loops/keyframe_maker.h"
#include "onboard/loops/loop_verifier.h"
#include "onboard/loops/vocabulary.h"
#include "shared/types/stamped_pose.h"

namespace kt {

struct LoopConfig {
  int enabled = 1;  ///< 0: no keyframes
  int feature = 0;  ///< PlaceFeature
  double keyframe_distance =
      0.3;             ///< m_p of the paper: metres of motion plus radians of turn since the last keyframe
  int candidates = 3;  ///< places that look alike, at most, that are compared in full
  double min_similarity = 0.3;  ///< of the words, in units of that with the keyframe before
  /// Remembered at most; beyond, old ones become sparser (make_room). 100 kB each at 640 x 480.
  int max_keyframes = 2000;
  VerificationConfig verification;
};

class PlaceRecogniser {
 public:
  PlaceRecogniser(const Calibration& calibration, const LoopConfig& config);
  ~PlaceRecogniser();

  struct Findings {
    Keyframe keyframe;
    std::vector<LoopClosure> candidates;
  };

  /// Hands over the next frame of a camera in `motion`, `colour` as recorded; a good one whose camera moved
  /// far enough becomes a keyframe, which is worked on by a thread of its own. Returns what became of earlier
  /// keyframes: always the same so many frames later, however fast the thread is, and waits for it where it
  /// is late. Throws what went wrong in it.
  std::vector<Findings> next(const FrameMaps& maps, const Image<Rgb8>& colour, const StampedPose& pose,
                             const FrameMotion& motion = {});

  /// What is left; waits for it.
  std::vector<Findings> finish();

  /// Where a camera is that sees this frame, by the keyframe that most proves it; waits for those that are
  /// worked on. Nothing where none does. The frame is not remembered.
  std::optional<SegmentPose> find(const FrameMaps& maps);

 private:
  /// A keyframe in the making, and what odometry knew of it.
  struct Job {
    int64_t due_frame = 0;
    KeyframeImages images;
    double way_m = 0;                        // of the camera in the segment so far
    Matrix6d covariance = Matrix6d::Zero();  // of the pose in the segment, in the odom frame
  };
  struct Known {
    Place place;
    BagOfWords bag;
    double way_m = 0;
    Matrix6d covariance = Matrix6d::Zero();
  };

  void follow(const StampedPose& pose);
  void work();
  void wait_until_idle();
  Findings study(Job job);
  Known known_as(Keyframe keyframe) const;
  void remember(Known known);
  std::vector<KeyframeIndex::Match> proposals(const Known& known) const;
  bool is_excluded_by_odometry(const Known& from, const Known& to, const Pose& T_from_to) const;
  std::vector<Findings> take(int64_t due_frame);

  LoopConfig config_;
  KeyframeMaker maker_;
  const Vocabulary& vocabulary_;
  LoopVerifier verifier_;

  // Of the caller.
  int64_t frame_ = 0;
  std::optional<StampedPose> last_keyframe_, last_good_;
  double way_m_ = 0;
  Matrix6d covariance_ = Matrix6d::Zero();

  // Of the thread, and of the caller while it is idle.
  KeyframeIndex index_;
  std::vector<Known> known_;
  int64_t candidates_ = 0;

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Job> jobs_;                              // the first is being worked on
  std::deque<std::pair<int64_t, Findings>> results_;  // by due frame
  std::exception_ptr failure_;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace kt
