// The files of stages, each with the key of what it was made from.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "shared/core/digest.h"

namespace kt {

/// What stands beside a stage's file, in NAME.json.
struct StageRecord {
  std::string key;     ///< digest of all that the stage was made from
  int64_t bytes = 0;   ///< of its file
  std::string digest;  ///< of its content
  double seconds = 0;  ///< that it took
};

/// A folder with a file NAME and a record NAME.json for each stage. A file counts only with its record: that
/// one goes before the file is touched and comes when it is whole, each under a name of its own first and
/// then renamed. So whatever interrupts the work, a file is taken for what it is.
class StageStore {
 public:
  /// `folder` is made with the first file; empty: nothing is kept and nothing found. Throws kt::Error where
  /// another process has the folder.
  explicit StageStore(std::filesystem::path folder);
  ~StageStore();
  StageStore(const StageStore&) = delete;
  StageStore& operator=(const StageStore&) = delete;

  bool keeps() const { return !folder_.empty(); }
  const std::filesystem::path& folder() const { return folder_; }

  enum class State {
    kWhole,     ///< file and record agree, and the key
    kMissing,   ///< there is no record
    kOtherKey,  ///< made from something else
    kDamaged,   ///< record, or file, are not what was written
  };
  /// Reads the whole file to tell.
  State state(const std::string& stage, const Digest& key) const;
  /// Of a stage that was found whole.
  StageRecord record(const std::string& stage) const;
  std::filesystem::path file(const std::string& stage) const { return folder_ / stage; }

  /// Has `write` write the file to the path that it is given, and keeps it. Where `write` throws, what it
  /// wrote is removed. Throws kt::Error where the folder or the record cannot be written.
  void keep(const std::string& stage, const Digest& key, double seconds,
            const std::function<void(const std::filesystem::path&)>& write);

 private:
  std::filesystem::path record_path(const std::string& stage) const { return folder_ / (stage + ".json"); }
  std::optional<StageRecord> read_record(const std::string& stage) const;
  void lock();

  std::filesystem::path folder_;
  int lock_ = -1;  // the folder, open
};

}  // namespace kt
