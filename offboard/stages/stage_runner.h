// Runs the stages of a program, or takes their results from files of an earlier run.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "offboard/stages/stage_archive.h"
#include "offboard/stages/stage_store.h"
#include "offboard/stages/time_to_go.h"

namespace kt {

/// What happens: of a stage the share done in [0, 1], and of the whole run the seconds left, below 0 where
/// nobody knows yet.
using StageProgress = std::function<void(const std::string& stage, double share, double seconds_to_go)>;

/// Told the share of a stage that is done, in [0, 1].
using TellShare = std::function<void(double share)>;

struct StageDone {
  std::string name;
  double seconds = 0;          ///< in this run
  bool is_from_file = false;   ///< taken, not made
  double seconds_to_make = 0;  ///< in the run that made it
};

class StageRunner {
 public:
  /// Both must outlive the runner; `progress` may be empty.
  StageRunner(StageStore& store, const StageProgress& progress)
      : store_(store), progress_(progress), start_(Clock::now()) {}

  /// Nothing is taken from files any more.
  void make_all() { may_take_ = false; }

  /// The result of a stage: from its file where that is whole and was made from the same, which `key` says;
  /// else what `make(tell)` returns, which is kept with the parts (StageStore::part) that it may have
  /// written.
  template <typename Make>
  auto run(const std::string& name, const Digest& key, const Make& make) {
    return run(name, key, make, [](const auto&, const TellShare&) {});
  }

  /// The same; a result from a file is first given to `restore(result, tell)`.
  template <typename Make, typename Restore>
  auto run(const std::string& name, const Digest& key, const Make& make, const Restore& restore) {
    const TellShare tell = begin(name);
    decltype(make(tell)) result;
    if (find(name, key)) {
      StageReader reader(store_.file(name));
      reader(result);
      reader.close();
      restore(result, tell);
      end(name, true);
      return result;
    }
    store_.clear(name);
    try {
      result = make(tell);
      store_.open();
      StageWriter writer(store_.file(name));
      writer(result);
      writer.close();
      store_.finish(name, key, seconds());
    } catch (...) {
      give_up(name);
      throw;
    }
    end(name, false);
    return result;
  }

  /// A stage whose result is not kept; it may have parts for as long as the runner lives.
  template <typename Action>
  auto run_always(const std::string& name, const Action& action) {
    store_.clear(name);
    auto result = action(begin(name));
    end(name, false);
    return result;
  }

  /// Of the stages to come, in their order.
  TimeToGo& time_to_go() { return time_to_go_; }
  const std::vector<StageDone>& done() const { return done_; }
  /// Lines on files that could not serve.
  const std::vector<std::string>& notes() const { return notes_; }

 private:
  using Clock = std::chrono::steady_clock;

  double now_s() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }
  double seconds() const { return now_s() - begun_s_; }
  TellShare begin(const std::string& name);
  bool find(const std::string& name, const Digest& key);
  void end(const std::string& name, bool is_from_file);
  void give_up(const std::string& name) noexcept;
  void tell(const std::string& name, double share);

  StageStore& store_;
  const StageProgress& progress_;
  Clock::time_point start_;
  double begun_s_ = 0;
  bool may_take_ = true;
  TimeToGo time_to_go_;
  std::vector<StageDone> done_;
  std::vector<std::string> notes_;
};

}  // namespace kt
