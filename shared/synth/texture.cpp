// Value noise and the patterns of texture.h; every step of brightness is box-filtered by the footprint.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/synth/texture.h"

#include <algorithm>
#include <cmath>

namespace kt {
namespace {

// Integer hash of a lattice point (finaliser constants of MurmurHash3).
uint32_t lattice_hash(int32_t x, int32_t y, uint32_t seed) {
  uint32_t h =
      seed * 0x9e3779b9u + static_cast<uint32_t>(x) * 0x85ebca6bu + static_cast<uint32_t>(y) * 0xc2b2ae35u;
  h = (h ^ (h >> 16)) * 0x85ebca6bu;
  h = (h ^ (h >> 13)) * 0xc2b2ae35u;
  return h ^ (h >> 16);
}

double unit(uint32_t hash) { return hash * 0x1.0p-32; }  // [0, 1)

double clamp01(double x) { return x < 0 ? 0 : x > 1 ? 1 : x; }

Vec3f mix(Vec3f a, Vec3f b, double share) { return a + (b - a) * static_cast<float>(share); }

// 1 where x > 0, 0 where x < 0, averaged over a window of `width`.
double step(double x, double width) { return clamp01(x / std::max(width, 1e-6) + 0.5); }

// How much of a detail of size `wavelength` survives the averaging: all from 4 footprints on, nothing
// below 2.
double visible(double wavelength, double footprint) { return clamp01(wavelength / (2 * footprint) - 1); }

// Smoothly interpolated lattice noise in [-1, 1], period 1.
double value_noise(double x, double y, uint32_t seed) {
  const double fx = std::floor(x), fy = std::floor(y);
  const auto ix = static_cast<int32_t>(fx), iy = static_cast<int32_t>(fy);
  const double tx = x - fx, ty = y - fy;
  const double sx = tx * tx * (3 - 2 * tx), sy = ty * ty * (3 - 2 * ty);
  const double a = unit(lattice_hash(ix, iy, seed)), b = unit(lattice_hash(ix + 1, iy, seed));
  const double c = unit(lattice_hash(ix, iy + 1, seed)), d = unit(lattice_hash(ix + 1, iy + 1, seed));
  const double low = a + (b - a) * sx, high = c + (d - c) * sx;
  return 2 * (low + (high - low) * sy) - 1;
}

// Sum of octaves from `wavelength` (m) down to what the footprint still shows, in about [-1, 1].
double fractal_noise(double u, double v, double wavelength, int octaves, double footprint, uint32_t seed) {
  constexpr double kLacunarity = 2.1;
  double sum = 0, amplitude = 0.5, frequency = 1 / wavelength, room = wavelength / (2 * footprint);
  for (int octave = 0; octave < octaves && room > 1; ++octave) {
    const double weight = amplitude * clamp01(room - 1);  // as `visible`
    sum += weight * value_noise(u * frequency, v * frequency, seed + static_cast<uint32_t>(octave));
    // Turning the lattice by the angle of the triangle 3-4-5 hides its axes.
    const double turned = 0.8 * u - 0.6 * v;
    v = 0.6 * u + 0.8 * v;
    u = turned;
    frequency *= kLacunarity;
    room *= 1 / kLacunarity;
    amplitude *= 0.75;
  }
  return sum;
}

struct Cell {
  int32_t x, y;
  double u, v;  // from the cell's corner, in cells
};

Cell cell_of(double u, double v) {
  const double fu = std::floor(u), fv = std::floor(v);
  return {static_cast<int32_t>(fu), static_cast<int32_t>(fv), u - fu, v - fv};
}

// Share of a line of `width` around whole numbers of x (x, width and footprint in cells) that the footprint
// sees.
double joint(double x, double width, double footprint) {
  const double distance = std::abs(x - std::floor(x + 0.5));
  const double share = step(width / 2 - distance, footprint);
  return footprint > 1 ? width : footprint > width ? share * width / footprint : share;
}

// Piecewise constant random value per unit of x, box-filtered at its steps and towards 0.5 where they get too
// small.
double random_steps(double x, double footprint, uint32_t seed) {
  const double base = std::floor(x + 0.5);
  const auto index = static_cast<int32_t>(base);
  const double before = unit(lattice_hash(index - 1, 0, seed)), after = unit(lattice_hash(index, 0, seed));
  const double value = before + (after - before) * step(x - base, footprint);
  return 0.5 + (value - 0.5) * visible(2, footprint);
}

double motif(const Cell& cell, double footprint, uint32_t seed) {
  const uint32_t hash = lattice_hash(cell.x, cell.y, seed);
  const double x = cell.u - 0.5, y = cell.v - 0.5;
  const double size = 0.18 + 0.25 * ((hash >> 8) & 255) / 255.0;
  double distance = 0;
  switch (hash & 3) {
    case 0:
      distance = std::sqrt(x * x + y * y);
      break;  // disc
    case 1:
      distance = std::abs(std::sqrt(x * x + y * y) - size / 2) + size * 0.7;
      break;  // ring
    case 2:
      distance = std::abs(x) + std::abs(y);
      break;  // diamond
    default:
      distance = std::max(std::abs(x), std::abs(y));
      break;  // square
  }
  return step(size - distance, footprint) * visible(1.5, footprint) * (0.4 + 0.6 * unit(hash * 0x9e3779b9u));
}

// Ink of text-like marks: lines of height 1 with glyphs of 3 x 5 dots; spaces between words.
double print(double u, double v, double footprint, uint32_t seed) {
  const Cell glyph = cell_of(u / 0.6, v);
  const uint32_t hash = lattice_hash(glyph.x, glyph.y, seed);
  const double coverage = 0.22;
  if (glyph.v > 0.7) return 0;
  const int column = static_cast<int>(glyph.u * 4), row = static_cast<int>(glyph.v / 0.14);
  const bool space = (hash >> 24) < 45;
  const double ink = !space && column < 3 && ((hash >> (3 * row + column)) & 1) ? 1 : 0;
  return coverage + (ink - coverage) * visible(0.6, footprint);
}

// Lively block colours around the poster's two.
Vec3f block_colour(const Material& material, uint32_t hash) {
  const Vec3f mixed = mix(material.colour, material.accent, unit(hash));
  const Vec3f tint{static_cast<float>(hash & 255) / 255, static_cast<float>((hash >> 8) & 255) / 255,
                   static_cast<float>((hash >> 16) & 255) / 255};
  return mix(mixed, tint, 0.3);
}

// Mean over 2 x 2 points of the footprint, for patterns with too many hard edges to filter one by one.
template <typename Colour>
Vec3f averaged(const Footprint& at, const Colour& colour) {
  Vec3f sum;
  for (const double du : {-0.25, 0.25}) {
    for (const double dv : {-0.25, 0.25}) sum = sum + colour(at.u + du * at.du, at.v + dv * at.dv) * 0.25f;
  }
  return sum;
}

Vec3f poster(const Material& material, uint32_t seed, double u, double v, double footprint) {
  // Blocks nest twice; the footprint blends a block into its parent, and that into the mean of all.
  const double cells = 1 / material.scale_m;
  const Cell big = cell_of(u * cells, v * cells);
  const uint32_t hash = lattice_hash(big.x, big.y, seed);
  const Vec3f mean = mix(mix(material.colour, material.accent, 0.5), {0.5f, 0.5f, 0.5f}, 0.3);
  const Vec3f base = mix(mean, block_colour(material, hash), visible(2, footprint * cells));
  const double small_footprint = footprint * cells * 4;
  const uint32_t kind = (hash >> 12) & 7;
  if (kind < 2) return base;
  if (kind < 4) {  // a field of print
    return mix(base, material.accent, 0.9 * print(u * cells * 5, v * cells * 5, footprint * cells * 5, hash));
  }
  const Cell small = cell_of(big.u * 4, big.v * 4);
  const uint32_t part = lattice_hash(small.x, small.y, hash);
  const Vec3f inner = (part & 1) ? block_colour(material, part) : base;
  return mix(base, inner, visible(1.5, small_footprint));
}

// Pattern before the grain is laid over it.
Vec3f ground_colour(const Material& m, uint32_t seed, const Footprint& at, double footprint) {
  const double u = at.u, v = at.v, s = 1 / m.scale_m;
  switch (m.pattern) {
    case Pattern::kPlain:
      return m.colour;
    case Pattern::kMottled: {
      const double noise = fractal_noise(u, v, m.scale_m, 6, footprint, seed + 11);
      return mix(m.colour, m.accent, clamp01(0.5 + 2.5 * noise));
    }
    case Pattern::kWood: {
      const auto row = static_cast<int32_t>(std::floor(v * s));
      const double shift = unit(lattice_hash(row, 1, seed));
      const double along = u * s / 7 + shift;
      const double tone = unit(lattice_hash(row, static_cast<int32_t>(std::floor(along)), seed + 3));
      const double grain = fractal_noise(u / 9 + 3.7 * tone, v, 0.03, 3, at.dv, seed + 5);
      const double seam = std::max(joint(v * s, 0.035, at.dv * s), joint(along, 0.005, at.du * s / 7));
      const Vec3f board = mix(m.colour, m.accent, clamp01(0.55 * tone + 0.45 * (0.5 + grain)));
      return board * static_cast<float>(1 - 0.6 * seam);
    }
    case Pattern::kTiles: {
      const Cell cell = cell_of(u * s, v * s);
      const double tone = 0.85 + 0.3 * unit(lattice_hash(cell.x, cell.y, seed)) * visible(2, footprint * s);
      const double seam = std::max(joint(u * s, 0.03, at.du * s), joint(v * s, 0.03, at.dv * s));
      return mix(m.colour * static_cast<float>(tone), m.accent, seam);
    }
    case Pattern::kMotifs:
      return mix(m.colour, m.accent, motif(cell_of(u * s, v * s), footprint * s, seed));
    case Pattern::kTartan: {
      const double across = random_steps(u * s, at.du * s, seed + 1),
                   along = random_steps(v * s, at.dv * s, seed + 2);
      return mix(m.colour, m.accent, (across + along) / 2);
    }
    case Pattern::kPrint:
      return averaged(at, [&](double x, double y) {
        return mix(m.colour, m.accent, print(x * s, y * s, footprint * s / 2, seed));
      });
    case Pattern::kPoster:
      return averaged(at, [&](double x, double y) { return poster(m, seed, x, y, footprint / 2); });
  }
  return m.colour;
}

}  // namespace

Vec3f reflectance(const Material& material, uint32_t face, const Footprint& at) {
  const uint32_t seed = material.seed + 104729u * face;
  // Patterns without their own axes are filtered by the longer side of the footprint.
  const double footprint = std::max(at.du, at.dv);
  const Vec3f ground = ground_colour(material, seed, at, footprint);
  if (material.grain == 0) return ground;
  const double grain = fractal_noise(at.u, at.v, 0.11, 5, footprint, seed + 17);
  return ground * static_cast<float>(1 + material.grain * grain);
}

}  // namespace kt
