// Keeps and finds the files of stages.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/stages/stage_store.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <sys/file.h>
#include <system_error>
#include <unistd.h>
#include <utility>

#include "nlohmann/json.hpp"

#include "offboard/stages/file_identity.h"
#include "shared/core/check.h"
#include "shared/io/file.h"

namespace kt {
namespace fs = std::filesystem;

StageStore::StageStore(fs::path folder, bool kept) : folder_(std::move(folder)), kept_(kept) {
  std::error_code ignored;
  if (fs::is_directory(folder_, ignored)) lock();
}

StageStore::~StageStore() {
  if (lock_ < 0) return;  // nothing was there, nothing was made
  std::error_code ignored;
  if (!kept_) fs::remove_all(folder_, ignored);
  close(lock_);
}

void StageStore::lock() {
  lock_ = ::open(folder_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (lock_ < 0) throw Error(folder_.string() + ": cannot be read: " + std::strerror(errno));
  // Some file systems know no locks; there whoever runs two at a time must name two folders.
  if (flock(lock_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
    throw Error(folder_.string() + ": another process works there: wait for its end, or name another folder");
}

std::optional<StageRecord> StageStore::read_record(const std::string& stage) const {
  try {
    const auto json = nlohmann::json::parse(read_file(record_path(stage)));
    StageRecord record{json.at("key"), {}, json.at("seconds")};
    for (const auto& file : json.at("files"))
      record.files.push_back({file.at("name"), file.at("bytes"), file.at("digest")});
    return record;
  } catch (const Error&) {
  } catch (const nlohmann::json::exception&) {
  }
  return {};
}

// Ascending by name, without the record.
std::vector<fs::path> StageStore::files_of(const std::string& stage) const {
  std::vector<fs::path> files;
  std::error_code error;
  for (fs::directory_iterator entry(folder_, error), end; !error && entry != end; entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (name == stage || name.starts_with(stage + "-")) files.push_back(entry->path());
  }
  if (error) throw Error(folder_.string() + ": cannot be read: " + error.message());
  std::sort(files.begin(), files.end());
  return files;
}

StageStore::State StageStore::state(const std::string& stage, const Digest& key) const {
  std::error_code ignored;
  if (!kept_ || !fs::exists(record_path(stage), ignored)) return State::kMissing;
  const std::optional<StageRecord> record = read_record(stage);
  if (!record) return State::kDamaged;
  if (record->key != key.hex()) return State::kOtherKey;
  try {
    for (const StageRecord::File& file : record->files) {
      const FileDigest found = digest_of_file(folder_ / file.name);
      if (found.bytes != file.bytes || found.digest.hex() != file.digest) return State::kDamaged;
    }
    return State::kWhole;
  } catch (const Error&) {
    return State::kDamaged;  // missing, or the disk fails
  }
}

StageRecord StageStore::record(const std::string& stage) const {
  const std::optional<StageRecord> record = read_record(stage);
  KT_CHECK(record.has_value());
  return *record;
}

void StageStore::clear(const std::string& stage) {
  std::error_code ignored;
  if (!fs::is_directory(folder_, ignored)) return;
  remove_file(record_path(stage));
  for (const fs::path& path : files_of(stage)) remove_file(path);
}

void StageStore::open() {
  std::error_code error;
  fs::create_directories(folder_, error);
  if (error) throw Error(folder_.string() + ": cannot be made: " + error.message());
  if (lock_ < 0) lock();
}

void StageStore::finish(const std::string& stage, const Digest& key, double seconds) {
  if (!kept_) return;
  nlohmann::ordered_json files = nlohmann::ordered_json::array();
  for (const fs::path& path : files_of(stage)) {
    const FileDigest written = digest_of_file(path);
    files.push_back(
        {{"name", path.filename().string()}, {"bytes", written.bytes}, {"digest", written.digest.hex()}});
  }
  const nlohmann::ordered_json json = {{"key", key.hex()}, {"files", files}, {"seconds", seconds}};
  const fs::path written = record_path(stage).string() + ".tmp";
  write_file(written, json.dump(2) + "\n");
  rename_file(written, record_path(stage));
}

}  // namespace kt
