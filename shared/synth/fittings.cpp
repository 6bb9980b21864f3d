// Furniture that hangs on walls: pictures, windows, curtains and doors.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/synth/furniture.h"
#include "shared/synth/palette.h"

namespace kt {

void Furnisher::picture(const Pose& T, double width, double height, uint32_t seed) {
  static constexpr Vec3f kGrounds[] = {
      {0.75f, 0.70f, 0.60f}, {0.15f, 0.25f, 0.45f}, {0.60f, 0.20f, 0.12f}, {0.20f, 0.40f, 0.25f}};
  static constexpr Vec3f kAccents[] = {
      {0.10f, 0.10f, 0.12f}, {0.80f, 0.70f, 0.30f}, {0.85f, 0.80f, 0.70f}, {0.05f, 0.10f, 0.20f}};
  box(T, {0, 0.010, 0}, {width + 0.06, 0.020, height + 0.06}, palette::walnut());
  box(T, {0, 0.013, 0}, {width, 0.026, height},
      palette::poster(kGrounds[seed % 4], kAccents[seed / 4 % 4], seed));
}

void Furnisher::window(const Pose& T, double width, double height) {
  box(T, {0, 0.015, 0}, {width, 0.03, height},
      palette::wallpaper({0.72f, 0.82f, 0.95f}, {0.42f, 0.60f, 0.50f}, 0.3));
  const Material frame = palette::white_paint();
  for (const double x : {-0.5, 0.0, 0.5}) box(T, {x * width, 0.03, 0}, {0.06, 0.06, height + 0.06}, frame);
  for (const double z : {-0.5, 0.15, 0.5}) box(T, {0, 0.03, z * height}, {width - 0.06, 0.05, 0.06}, frame);
  box(T, {0, 0.06, -height / 2 - 0.045}, {width + 0.1, 0.12, 0.03}, frame);
}

void Furnisher::curtain(const Pose& T, double width, double height, const Material& material) {
  const int folds = static_cast<int>(width / 0.08);
  for (int i = 0; i < folds; ++i) {
    const double x = ((i + 0.5) / folds - 0.5) * width;
    cylinder(T, {x, 0.09 + (i % 2 ? 0.015 : 0), -height / 2}, 0.044, height, material);
  }
}

void Furnisher::door(const Pose& T, const Material& material, bool same_everywhere) {
  const Material frame = palette::white_paint();
  box(T, {0, 0.015, 1.0}, {0.86, 0.03, 2.0}, material, same_everywhere);
  for (const double x : {-0.47, 0.47}) box(T, {x, 0.025, 1.035}, {0.08, 0.05, 2.07}, frame, same_everywhere);
  box(T, {0, 0.025, 2.035}, {0.86, 0.05, 0.07}, frame, same_everywhere);
  for (const double z : {0.55, 1.45})
    box(T, {0, 0.02, z}, {0.6, 0.04, 0.7}, material, same_everywhere);  // panels
  box(T, {0.34, 0.065, 1.02}, {0.12, 0.02, 0.025}, palette::metal(), same_everywhere);
  box(T, {0.385, 0.05, 1.02}, {0.03, 0.05, 0.025}, palette::metal(), same_everywhere);
}

}  // namespace kt
