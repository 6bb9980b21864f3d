// Keeps and finds the files of stages.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/stages/stage_store.h"

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
namespace {

namespace fs = std::filesystem;

void remove_file(const fs::path& path) {
  std::error_code error;
  fs::remove(path, error);
  if (error) throw Error(path.string() + ": cannot be removed: " + error.message());
}

void rename_file(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::rename(from, to, error);
  if (error) throw Error(to.string() + ": cannot be written: " + error.message());
}

fs::path temporary(const fs::path& path) { return path.string() + ".tmp"; }

}  // namespace

StageStore::StageStore(fs::path folder) : folder_(std::move(folder)) {
  std::error_code ignored;
  if (keeps() && fs::is_directory(folder_, ignored)) lock();
}

StageStore::~StageStore() {
  if (lock_ >= 0) close(lock_);
}

void StageStore::lock() {
  lock_ = open(folder_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (lock_ < 0) throw Error(folder_.string() + ": cannot be read: " + std::strerror(errno));
  // Some file systems know no locks; there whoever runs two at a time must name two folders.
  if (flock(lock_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
    throw Error(folder_.string() + ": another process works there: wait for its end, or name another folder");
}

std::optional<StageRecord> StageStore::read_record(const std::string& stage) const {
  try {
    const auto json = nlohmann::json::parse(read_file(record_path(stage)));
    return StageRecord{json.at("key"), json.at("bytes"), json.at("digest"), json.at("seconds")};
  } catch (const Error&) {
  } catch (const nlohmann::json::exception&) {
  }
  return {};
}

StageStore::State StageStore::state(const std::string& stage, const Digest& key) const {
  std::error_code ignored;
  if (!keeps() || !fs::exists(record_path(stage), ignored)) return State::kMissing;
  const std::optional<StageRecord> record = read_record(stage);
  if (!record) return State::kDamaged;
  if (record->key != key.hex()) return State::kOtherKey;
  try {
    const FileDigest found = digest_of_file(file(stage));
    const bool is_whole = found.bytes == record->bytes && found.digest.hex() == record->digest;
    return is_whole ? State::kWhole : State::kDamaged;
  } catch (const Error&) {
    return State::kDamaged;  // missing, or the disk fails
  }
}

StageRecord StageStore::record(const std::string& stage) const {
  const std::optional<StageRecord> record = read_record(stage);
  KT_CHECK(record.has_value());
  return *record;
}

void StageStore::keep(const std::string& stage, const Digest& key, double seconds,
                      const std::function<void(const fs::path&)>& write) {
  if (!keeps()) return;
  std::error_code error;
  fs::create_directories(folder_, error);
  if (error) throw Error(folder_.string() + ": cannot be made: " + error.message());
  if (lock_ < 0) lock();
  const fs::path file_now = temporary(file(stage)), record_now = temporary(record_path(stage));
  remove_file(record_path(stage));
  remove_file(file(stage));  // first: there may be no room for two
  try {
    write(file_now);
    const FileDigest written = digest_of_file(file_now);
    rename_file(file_now, file(stage));
    const nlohmann::ordered_json json = {
        {"key", key.hex()}, {"bytes", written.bytes}, {"digest", written.digest.hex()}, {"seconds", seconds}};
    write_file(record_now, json.dump(2) + "\n");
    rename_file(record_now, record_path(stage));
  } catch (...) {
    fs::remove(file_now, error);
    fs::remove(record_now, error);
    throw;
  }
}

}  // namespace kt
