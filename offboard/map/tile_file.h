// The surface of a map in tiles, in a file: what deforming or fusing hands over to meshing.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <span>
#include <vector>

#include "offboard/map/mesh_parts.h"
#include "offboard/map/tile_grid.h"
#include "shared/io/file.h"

namespace kt {

/// The triangles of a tile, and all vertices that they use. Vertices of one patch with equal keys are one,
/// and equal bit for bit in all tiles that hold them. With normals, colours and quality.
struct MeshTile {
  TileId id;
  WeldedMesh mesh;
};

/// What the index tells of a tile.
struct TileEntry {
  TileId id;
  uint32_t vertices = 0, triangles = 0;
  Vec3f low, high;      ///< bounds of its positions (m)
  int64_t offset = 0;   ///< in the file
  uint64_t digest = 0;  ///< of its bytes there
};

/// Writes the file: a head, the tiles, then the index; in host byte order (little endian).
class TileWriter {
 public:
  /// Replaces the file. Throws kt::Error as OutputFile; unless it is finished, the file is removed.
  TileWriter(std::filesystem::path path, const TileGrid& grid);
  /// Each tile once, in any order; one without triangles is left out.
  void add(const MeshTile& tile);
  void finish();

 private:
  void write(const void* bytes, size_t size);
  OutputFile file_;
  std::vector<TileEntry> index_;
  int64_t end_ = 0;
};

class TileFile {
 public:
  /// Reads the index. Throws kt::Error where the file cannot be read, is not whole, or is damaged there.
  explicit TileFile(std::filesystem::path path);

  const TileGrid& grid() const { return grid_; }
  std::span<const TileEntry> tiles() const { return index_; }  ///< ascending by id
  /// The place of a tile in tiles(), where there is one.
  std::optional<size_t> find(const TileId& id) const;
  /// The tile at a place. Throws kt::Error for damage.
  MeshTile read(size_t place) const;

 private:
  [[noreturn]] void fail_damaged(const std::string& where) const;
  std::filesystem::path path_;
  mutable std::ifstream file_;
  TileGrid grid_;
  std::vector<TileEntry> index_;
};

}  // namespace kt
