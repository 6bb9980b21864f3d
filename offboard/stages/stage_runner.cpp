// Times stages and tells of them.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/stages/stage_runner.h"

namespace kt {

TellShare StageRunner::begin(const std::string& name) {
  begun_s_ = now_s();
  time_to_go_.begin(name, begun_s_);
  tell(name, 0);
  return [this, name](double share) {
    if (share < 1) tell(name, share);  // the stage says itself when it ends
  };
}

bool StageRunner::find(const std::string& name, const Digest& key) {
  if (!may_take_) return false;
  const StageStore::State state = store_.state(name, key);
  if (state == StageStore::State::kDamaged)
    notes_.push_back(store_.file(name).string() + " was damaged: the stage " + name + " was made anew");
  return state == StageStore::State::kWhole;
}

void StageRunner::end(const std::string& name, bool is_from_file) {
  const double now = now_s(), seconds = now - begun_s_;
  time_to_go_.end(now, !is_from_file);
  done_.push_back({name, seconds, is_from_file, is_from_file ? store_.record(name).seconds : seconds});
  tell(name, 1);
}

// The room of files that did not become whole is given back.
void StageRunner::give_up(const std::string& name) noexcept {
  try {
    store_.clear(name);
  } catch (const std::exception&) {  // what stays has no record
  }
}

void StageRunner::tell(const std::string& name, double share) {
  if (progress_) progress_(name, share, time_to_go_.left(share, now_s()).value_or(-1));
}

}  // namespace kt
