// A mesh of any size, handed over in blocks.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "shared/core/digest.h"
#include "shared/io/mesh.h"

namespace kt {

/// What a mesh has, and how to go over it, as often as one likes, always in the same order.
struct MeshStream {
  using TakeVertices = std::function<void(const Mesh& block)>;
  using TakeTriangles = std::function<void(std::span<const std::array<uint32_t, 3>> block)>;

  uint64_t vertices = 0, triangles = 0;
  bool has_normals = false, has_colours = false, has_quality = false;
  /// The next vertices and what they carry; the blocks' own triangles mean nothing.
  std::function<void(const TakeVertices&)> for_each_vertices;
  /// The next triangles, as indices into all vertices.
  std::function<void(const TakeTriangles&)> for_each_triangles;
};

/// In one block; the mesh has to live as long.
MeshStream stream_of(const Mesh& mesh);

/// Bounds of the positions; zero for none.
struct MeshBounds {
  Vec3f low, high;
};
MeshBounds bounds_of(const MeshStream& mesh);

/// Digest of everything the mesh holds.
Digest mesh_digest(const MeshStream& mesh);

/// Takes the bytes of a file, some at a time.
using ByteSink = std::function<void(std::string_view)>;

/// Values as they lie in memory, handed on in blocks.
class ByteBlocks {
 public:
  explicit ByteBlocks(const ByteSink& sink) : sink_(sink) {}
  template <typename T>
  void put(const T& value) {
    char bytes[sizeof(T)];
    std::memcpy(bytes, &value, sizeof value);
    text({bytes, sizeof bytes});
  }
  void text(std::string_view bytes) {
    block_ += bytes;
    if (block_.size() >= kBlock) flush();
  }
  /// To be called behind the last.
  void flush() {
    if (!block_.empty()) sink_(block_);
    block_.clear();
  }

 private:
  static constexpr size_t kBlock = size_t{1} << 20;
  const ByteSink& sink_;
  std::string block_;
};

/// What write(sink) hands over, as one text.
template <typename Write>
std::string gathered_bytes(const Write& write) {
  std::string all;
  write(ByteSink([&all](std::string_view bytes) { all += bytes; }));
  return all;
}

}  // namespace kt
