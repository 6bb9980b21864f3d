// Tiles as they lie in memory, list by list, each with a digest.
// SPDX-License-Identifier: BSD-3-Clause
#include "offboard/map/tile_file.h"

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstring>
#include <string>
#include <type_traits>
#include <utility>

#include "shared/core/check.h"
#include "shared/core/digest.h"
#include "shared/io/mesh_stream.h"

namespace kt {
namespace {

static_assert(std::endian::native == std::endian::little, "tiles are written as they lie in memory");
static_assert(sizeof(TileEntry) == 64 && std::is_trivially_copyable_v<TileEntry>, "no byte is left open");

constexpr uint64_t kHeadMagic = 0x3130454c4954544b;  // "KTTILE01"
constexpr uint64_t kTailMagic = 0x3130444e4554544b;  // "KTTEND01"

struct Head {
  uint64_t magic = kHeadMagic;
  int64_t side = 0;  // of the grid
};

struct Tail {
  uint64_t count = 0, digest = 0;  // of the index before it
  uint64_t magic = kTailMagic;
};

// Calls visit(list) for each list of a tile, in the order of the file.
template <typename MeshOfATile, typename Visit>
void for_each_list(MeshOfATile& mesh, const Visit& visit) {
  visit(mesh.keys);
  visit(mesh.vertices);
  visit(mesh.normals);
  visit(mesh.colours);
  visit(mesh.quality);
  visit(mesh.triangles);
}

template <typename T>
size_t byte_count(const std::vector<T>& list) {
  return list.size() * sizeof(T);
}

}  // namespace

TileWriter::TileWriter(std::filesystem::path path, const TileGrid& grid) : file_(std::move(path)) {
  KT_CHECK(grid.side >= 2);
  Head head;
  head.side = grid.side;
  write(&head, sizeof head);
}

void TileWriter::write(const void* bytes, size_t size) {
  file_.write({static_cast<const char*>(bytes), size});
  end_ += static_cast<int64_t>(size);
}

void TileWriter::add(const MeshTile& tile) {
  const WeldedMesh& mesh = tile.mesh;
  if (mesh.triangles.empty()) return;
  const size_t count = mesh.vertices.size();
  for (const size_t size : {mesh.keys.size(), mesh.normals.size(), mesh.colours.size(), mesh.quality.size()})
    KT_CHECK(size == count, "a tile lacks what its vertices carry");
  TileEntry entry;
  entry.id = tile.id;
  entry.vertices = static_cast<uint32_t>(count);
  entry.triangles = static_cast<uint32_t>(mesh.triangles.size());
  const auto [low, high] = bounds_of(stream_of(mesh));
  entry.low = low, entry.high = high;
  entry.offset = end_;
  Digest digest;
  for_each_list(mesh, [&](const auto& list) {
    digest.add_bytes(list.data(), byte_count(list));
    write(list.data(), byte_count(list));
  });
  entry.digest = digest.value();
  index_.push_back(entry);
}

void TileWriter::finish() {
  std::sort(index_.begin(), index_.end(), [](const TileEntry& a, const TileEntry& b) { return a.id < b.id; });
  Digest digest;
  digest.add_bytes(index_.data(), byte_count(index_));
  write(index_.data(), byte_count(index_));
  const Tail tail{index_.size(), digest.value(), kTailMagic};
  write(&tail, sizeof tail);
  file_.close();
}

TileFile::TileFile(std::filesystem::path path) : path_(std::move(path)), file_(path_, std::ios::binary) {
  if (!file_) throw Error(path_.string() + ": cannot be read: " + std::strerror(errno));
  const auto read = [this](int64_t offset, void* bytes, size_t size) {
    file_.seekg(offset);
    if (!file_.read(static_cast<char*>(bytes), static_cast<std::streamsize>(size)))
      fail_damaged("is not whole");
  };
  Head head;
  read(0, &head, sizeof head);
  if (head.magic != kHeadMagic || head.side < 2 || head.side > EdgeKey::kLimit)
    throw Error(path_.string() + ": is no file of tiles");
  grid_.side = static_cast<int32_t>(head.side);
  file_.seekg(0, std::ios::end);
  const int64_t size = file_.tellg();
  Tail tail;
  const auto tail_at = size - static_cast<int64_t>(sizeof tail);
  if (tail_at < static_cast<int64_t>(sizeof head)) fail_damaged("is not whole");
  read(tail_at, &tail, sizeof tail);
  if (tail.magic != kTailMagic || tail.count > static_cast<uint64_t>(tail_at) / sizeof(TileEntry))
    fail_damaged("is not whole");
  index_.resize(tail.count);
  read(tail_at - static_cast<int64_t>(byte_count(index_)), index_.data(), byte_count(index_));
  Digest digest;
  digest.add_bytes(index_.data(), byte_count(index_));
  if (digest.value() != tail.digest) fail_damaged("its list of tiles is damaged");
}

void TileFile::fail_damaged(const std::string& where) const {
  throw Error(path_.string() + ": " + where + ": remove it and run kintsugi-map again");
}

std::optional<size_t> TileFile::find(const TileId& id) const {
  const auto found = std::lower_bound(index_.begin(), index_.end(), id,
                                      [](const TileEntry& entry, const TileId& i) { return entry.id < i; });
  if (found == index_.end() || found->id != id) return {};
  return static_cast<size_t>(found - index_.begin());
}

MeshTile TileFile::read(size_t place) const {
  const TileEntry& entry = index_.at(place);
  MeshTile tile{entry.id, {}};
  WeldedMesh& mesh = tile.mesh;
  for_each_list(mesh, [&](auto& list) { list.resize(entry.vertices); });
  mesh.triangles.resize(entry.triangles);
  const std::string name = "tile " + std::to_string(place) + " is damaged";
  file_.clear();
  file_.seekg(entry.offset);
  Digest digest;
  for_each_list(mesh, [&](auto& list) {
    if (!file_.read(reinterpret_cast<char*>(list.data()), static_cast<std::streamsize>(byte_count(list))))
      fail_damaged(name);
    digest.add_bytes(list.data(), byte_count(list));
  });
  if (digest.value() != entry.digest) fail_damaged(name);
  return tile;
}

}  // namespace kt
