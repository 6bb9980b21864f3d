// The materials that furniture and buildings are made of.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "shared/synth/texture.h"

namespace kt::palette {

inline Material oak() {
  return {Pattern::kWood, {0.50f, 0.33f, 0.18f}, {0.30f, 0.18f, 0.09f}, 0.3, 0.25f, 1, 1};
}
inline Material walnut() {
  return {Pattern::kWood, {0.24f, 0.14f, 0.08f}, {0.12f, 0.07f, 0.04f}, 0.3, 0.25f, 1, 2};
}
inline Material birch() {
  return {Pattern::kWood, {0.68f, 0.55f, 0.38f}, {0.54f, 0.40f, 0.25f}, 0.25, 0.2f, 1, 3};
}
inline Material parquet() {
  return {Pattern::kWood, {0.46f, 0.29f, 0.15f}, {0.25f, 0.14f, 0.07f}, 0.09, 0.3f, 1, 4};
}
inline Material white_paint() { return {Pattern::kPlain, {0.78f, 0.77f, 0.74f}, {}, 1, 0.12f, 1, 5}; }
inline Material ceiling() {
  return {Pattern::kTiles, {0.74f, 0.74f, 0.72f}, {0.50f, 0.50f, 0.50f}, 0.6, 0.12f, 1, 6};
}
inline Material stone_tiles() {
  return {Pattern::kTiles, {0.52f, 0.49f, 0.44f}, {0.24f, 0.23f, 0.22f}, 0.3, 0.3f, 1, 7};
}
inline Material wall_tiles() {
  return {Pattern::kTiles, {0.62f, 0.72f, 0.74f}, {0.38f, 0.40f, 0.40f}, 0.15, 0.15f, 1, 8};
}
inline Material plaster() {
  return {Pattern::kMottled, {0.66f, 0.60f, 0.50f}, {0.53f, 0.46f, 0.37f}, 0.25, 0.2f, 1, 9};
}
inline Material metal() { return {Pattern::kPlain, {0.40f, 0.41f, 0.43f}, {}, 1, 0.15f, 0.9f, 10}; }
inline Material screen() { return {Pattern::kPlain, {0.02f, 0.02f, 0.025f}, {}, 1, 0.3f, 0.15f, 11}; }
inline Material leaf() {
  return {Pattern::kMottled, {0.12f, 0.32f, 0.08f}, {0.22f, 0.42f, 0.14f}, 0.05, 0.3f, 1, 12};
}
inline Material clay() {
  return {Pattern::kMottled, {0.52f, 0.24f, 0.13f}, {0.40f, 0.17f, 0.09f}, 0.06, 0.2f, 1, 13};
}
inline Material linen() {
  return {Pattern::kTartan, {0.72f, 0.70f, 0.64f}, {0.50f, 0.55f, 0.62f}, 0.05, 0.2f, 1, 14};
}

inline Material wallpaper(Vec3f ground, Vec3f accent, double size_m = 0.16) {
  return {Pattern::kMotifs, ground, accent, size_m, 0.18f, 1, 20};
}
inline Material cloth(Vec3f ground, Vec3f accent, double stripe_m = 0.035) {
  return {Pattern::kTartan, ground, accent, stripe_m, 0.35f, 1, 21};
}
inline Material paint(Vec3f colour, float grain = 0.15f) {
  return {Pattern::kPlain, colour, {}, 1, grain, 1, 22};
}
inline Material poster(Vec3f ground, Vec3f accent, uint32_t seed) {
  return {Pattern::kPoster, ground, accent, 0.16, 0.1f, 1, 1000 + seed};
}
inline Material print(Vec3f paper, Vec3f ink, double line_m) {
  return {Pattern::kPrint, paper, ink, line_m, 0.1f, 1, 24};
}

}  // namespace kt::palette
