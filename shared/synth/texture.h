// Procedural surface appearance: repeatable patterns with detail at every scale, filtered to the pixel's
// footprint.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "shared/core/vec.h"

namespace kt {

enum class Pattern : uint8_t {
  kPlain,    ///< one colour
  kMottled,  ///< blotches of two colours, as stone or plaster
  kWood,     ///< planks of width `scale_m` along u, with grain
  kTiles,    ///< square tiles of size `scale_m` with joints
  kMotifs,   ///< wallpaper: discs, rings, diamonds and squares, one per cell of `scale_m`, no two rows alike
  kTartan,   ///< crossing stripes of width `scale_m`, as woven cloth
  kPrint,    ///< lines of text-like marks of height `scale_m`
  kPoster,   ///< coloured blocks of size `scale_m` above lines of print
};

/// What a surface looks like. Colours are linear reflectances in [0, 1].
struct Material {
  Pattern pattern = Pattern::kPlain;
  Vec3f colour{0.5f, 0.5f, 0.5f};  ///< ground
  Vec3f accent{0.3f, 0.3f, 0.3f};  ///< second colour of the pattern
  double scale_m = 0.1;
  float grain = 0.1f;  ///< relative strength of the fine, multi-scale detail on top
  float infrared = 1;  ///< share of the depth projector's light that comes back: 1 matt, 0 a mirror or screen
  uint32_t seed = 0;   ///< surfaces of equal seed (and size) look alike
};

/// The part of the surface that one pixel sees: a rectangle of du x dv metres around (u, v).
struct Footprint {
  double u, v, du, dv;
};

/// Reflectance averaged (to good approximation) over the footprint; `face` varies the pattern beside the
/// material's seed. Integer hashes and plain arithmetic only, so that every machine draws the same picture.
Vec3f reflectance(const Material& material, uint32_t face, const Footprint& at);

}  // namespace kt
