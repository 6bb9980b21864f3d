// The files of stages, each with the key of what it was made from.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "shared/core/digest.h"

namespace kt {

/// What stands beside a stage's files, in NAME.json.
struct StageRecord {
  struct File {
    std::string name;
    int64_t bytes = 0;
    std::string digest;  ///< of its content
  };
  std::string key;  ///< digest of all that the stage was made from
  std::vector<File> files;
  double seconds = 0;  ///< that the stage took
};

/// A folder with a file NAME for each stage, further ones NAME-... where it has parts, and a record of them.
/// Files count only with their record: it goes before they are touched and comes, by renaming, when they are
/// whole. So whatever interrupts the work, no file is taken for more than it is.
class StageStore {
 public:
  /// `folder` is made with the first file. Unless it is `kept`, what an earlier run has left there counts for
  /// nothing, and it is removed in the end. Throws kt::Error where another process has the folder.
  StageStore(std::filesystem::path folder, bool kept);
  ~StageStore();
  StageStore(const StageStore&) = delete;
  StageStore& operator=(const StageStore&) = delete;

  bool keeps() const { return kept_; }
  const std::filesystem::path& folder() const { return folder_; }
  std::filesystem::path file(const std::string& stage) const { return folder_ / stage; }
  /// "fuse-3"; whatever else begins with "fuse-" belongs to the stage too.
  std::filesystem::path part(const std::string& stage, int number) const {
    return folder_ / (stage + "-" + std::to_string(number));
  }

  enum class State {
    kWhole,     ///< files and record agree, and the key
    kMissing,   ///< there is no record
    kOtherKey,  ///< made from something else
    kDamaged,   ///< the record, or a file, is not what was written
  };
  /// Reads all of the files to tell.
  State state(const std::string& stage, const Digest& key) const;
  /// Of a stage that was found whole.
  StageRecord record(const std::string& stage) const;

  /// Removes all that stands there of the stage. Throws kt::Error where that fails.
  void clear(const std::string& stage);
  /// Makes the folder where it is missing; to be called before the first file is written. Throws kt::Error
  /// where that fails, or another process has the folder.
  void open();
  /// Says that the files of the stage are whole.
  void finish(const std::string& stage, const Digest& key, double seconds);

 private:
  std::filesystem::path record_path(const std::string& stage) const { return folder_ / (stage + ".json"); }
  std::optional<StageRecord> read_record(const std::string& stage) const;
  std::vector<std::filesystem::path> files_of(const std::string& stage) const;
  void lock();

  std::filesystem::path folder_;
  bool kept_;
  int lock_ = -1;  // the folder, open
};

}  // namespace kt
