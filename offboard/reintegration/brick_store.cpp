// One place of fixed size in the file for each brick.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/reintegration/brick_store.h"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <unistd.h>
#include <utility>

#include "shared/core/check.h"

namespace kt {
namespace {

constexpr auto kBytes = static_cast<int64_t>(sizeof(StoredBrick));

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& what) {
  throw Error(path.string() + ": " + what + ": " + std::strerror(errno) +
              "; it holds the voxels of the whole map, choose an --output with room for it");
}

}  // namespace

BrickStore::BrickStore(std::filesystem::path file) : path_(std::move(file)) {
  file_ = open(path_.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (file_ < 0) fail(path_, "cannot be made");
}

BrickStore::~BrickStore() {
  close(file_);
  std::error_code ignored;
  std::filesystem::remove(path_, ignored);
}

void BrickStore::put(std::span<const StoredBrick> bricks) {
  for (const StoredBrick& stored : bricks) {
    const auto [at, is_new] = places_.try_emplace({stored.brick.z, stored.brick.y, stored.brick.x});
    if (is_new && free_.empty()) {
      at->second = end_++;
    } else if (is_new) {
      at->second = free_.back();
      free_.pop_back();
    }
    const auto* bytes = reinterpret_cast<const char*>(&stored);
    for (int64_t done = 0; done < kBytes;) {
      const ssize_t count =
          pwrite(file_, bytes + done, static_cast<size_t>(kBytes - done), at->second * kBytes + done);
      if (count < 0 && errno == EINTR) continue;
      if (count <= 0) fail(path_, "cannot be written");
      done += count;
    }
  }
}

template <typename Visit>
void BrickStore::for_each_within(const VoxelBounds& bounds, const Visit& visit) const {
  auto at = places_.lower_bound({bounds.low.z >> kLog2BrickSide, INT32_MIN, INT32_MIN});
  while (at != places_.end() && at->first[0] * kBrickSide < bounds.high.z) {
    const auto [key, place] = *at++;  // the visitor may erase it
    if (bounds.contains({key[2] * kBrickSide, key[1] * kBrickSide, key[0] * kBrickSide})) visit(key, place);
  }
}

void BrickStore::read(const VoxelBounds& bounds,
                      const std::function<void(std::span<const StoredBrick>)>& visit) const {
  constexpr size_t kAtOnce = 4096;
  std::vector<StoredBrick> bricks;
  for_each_within(bounds, [&](const Key&, int64_t place) {
    auto* bytes = reinterpret_cast<char*>(&bricks.emplace_back());
    for (int64_t done = 0; done < kBytes;) {
      const ssize_t count =
          pread(file_, bytes + done, static_cast<size_t>(kBytes - done), place * kBytes + done);
      if (count < 0 && errno == EINTR) continue;
      if (count <= 0) fail(path_, "cannot be read");
      done += count;
    }
    if (bricks.size() < kAtOnce) return;
    visit(bricks);
    bricks.clear();
  });
  if (!bricks.empty()) visit(bricks);
}

void BrickStore::erase(const VoxelBounds& bounds) {
  for_each_within(bounds, [this](const Key& key, int64_t place) {
    free_.push_back(place);
    places_.erase(key);
  });
}

std::vector<Vec3i> BrickStore::bricks() const {
  std::vector<Vec3i> all;
  for (const auto& [key, place] : places_) all.push_back({key[2], key[1], key[0]});
  return all;
}

}  // namespace kt
