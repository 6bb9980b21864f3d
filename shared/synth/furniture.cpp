// Tables, seats, shelves and other things that stand on the floor.
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/synth/furniture.h"

#include <algorithm>

#include "shared/core/rng.h"
#include "shared/synth/palette.h"

namespace kt {

using Eigen::Vector3d;

namespace {

// Deterministic variety within a piece: the n-th call of `next` depends on the seed and n alone.
class Dice {
 public:
  explicit Dice(uint64_t seed) : seed_(seed) {}
  double between(double low, double high) { return low + (high - low) * random_uniform(seed_, 0, count_++); }
  Vec3f colour() {
    const auto channel = [this] { return static_cast<float>(between(0.08, 0.65)); };
    const float r = channel(), g = channel(), b = channel();
    return {r, g, b};
  }

 private:
  uint64_t seed_;
  uint64_t count_ = 0;
};

Pose moved(const Pose& T, double x, double y, double z) { return T * Eigen::Translation3d(x, y, z); }

Pose turned_to(const Pose& T, double facing_x, double facing_y) {
  return T * place(0, 0, facing_x, facing_y);
}

}  // namespace

Pose place(double x, double y, double facing_x, double facing_y, double z) {
  const Vector3d front = Vector3d(facing_x, facing_y, 0).normalized();
  Pose T = Pose::Identity();
  T.linear().col(0) = Vector3d(front.y(), -front.x(), 0);
  T.linear().col(1) = front;
  T.translation() = Vector3d(x, y, z);
  return T;
}

void Furnisher::box(const Pose& T, const Vector3d& centre, const Vector3d& size, const Material& material,
                    bool same_everywhere) {
  scene_.add({ShapeKind::kBox, size / 2}, moved(T, centre.x(), centre.y(), centre.z()), material,
             same_everywhere);
}

void Furnisher::sphere(const Pose& T, const Vector3d& centre, double radius, const Material& material) {
  scene_.add({ShapeKind::kSphere, Vector3d::Constant(radius)}, moved(T, centre.x(), centre.y(), centre.z()),
             material);
}

void Furnisher::cylinder(const Pose& T, const Vector3d& foot, double radius, double height,
                         const Material& material) {
  scene_.add({ShapeKind::kCylinder, {radius, radius, height / 2}},
             moved(T, foot.x(), foot.y(), foot.z() + height / 2), material);
}

void Furnisher::table(const Pose& T, double width, double depth, double height, const Material& top,
                      const Material& legs) {
  box(T, {0, 0, height - 0.02}, {width, depth, 0.04}, top);
  box(T, {0, 0, height - 0.075}, {width - 0.12, depth - 0.12, 0.07}, legs);
  for (const double x : {-1.0, 1.0}) {
    for (const double y : {-1.0, 1.0}) {
      box(T, {x * (width / 2 - 0.06), y * (depth / 2 - 0.06), (height - 0.04) / 2},
          {0.06, 0.06, height - 0.04}, legs);
    }
  }
}

void Furnisher::round_table(const Pose& T, double radius, double height, const Material& top) {
  cylinder(T, {0, 0, height - 0.035}, radius, 0.035, top);
  cylinder(T, {0, 0, 0.03}, 0.045, height - 0.065, palette::metal());
  cylinder(T, {0, 0, 0}, radius * 0.55, 0.03, palette::metal());
}

void Furnisher::chair(const Pose& T, const Material& wood, const Material& seat) {
  box(T, {0, 0, 0.445}, {0.44, 0.44, 0.05}, seat);
  for (const double x : {-0.19, 0.19}) {
    box(T, {x, 0.19, 0.21}, {0.045, 0.045, 0.42}, wood);
    box(T, {x, -0.2, 0.47}, {0.045, 0.04, 0.94}, wood);
  }
  for (const double z : {0.62, 0.75, 0.88}) box(T, {0, -0.2, z}, {0.34, 0.025, 0.07}, wood);
}

void Furnisher::sofa(const Pose& T, double width, const Material& cover, const Material& pillows) {
  box(T, {0, 0, 0.16}, {width, 0.9, 0.2}, cover);
  for (const double x : {-1.0, 1.0}) {
    box(T, {x * (width / 2 - 0.09), 0, 0.36}, {0.18, 0.9, 0.48}, cover);
    for (const double y : {-0.38, 0.38})
      cylinder(T, {x * (width / 2 - 0.1), y, 0}, 0.025, 0.07, palette::walnut());
  }
  box(T, {0, -0.34, 0.5}, {width - 0.36, 0.22, 0.72}, cover);
  const int seats = width > 1.2 ? 2 : 1;
  const double seat_width = (width - 0.38) / seats;
  for (int i = 0; i < seats; ++i) {
    const double x = (i - (seats - 1) / 2.0) * seat_width;
    box(T, {x, 0.11, 0.345}, {seat_width - 0.015, 0.67, 0.17}, cover);
    const Pose T_pillow = turned_to(moved(T, x * 1.25, -0.13, 0.6), i ? -0.25 : 0.3, 1);
    box(T_pillow, {0, 0, 0}, {0.4, 0.13, 0.36}, pillows);
  }
}

void Furnisher::bed(const Pose& T, double width, const Material& wood, const Material& blanket) {
  box(T, {0, 0, 0.17}, {width, 2.05, 0.3}, wood);
  box(T, {0, -1.0, 0.5}, {width, 0.06, 1.0}, wood);
  box(T, {0, 0.02, 0.4}, {width - 0.08, 1.96, 0.17}, palette::linen());
  box(T, {0, 0.35, 0.45}, {width - 0.02, 1.32, 0.13}, blanket);
  const int sleepers = width > 1.2 ? 2 : 1;
  for (int i = 0; i < sleepers; ++i) {
    const Pose T_pillow =
        turned_to(moved(T, (i - (sleepers - 1) / 2.0) * 0.75, -0.7, 0.53), i ? 0.12 : -0.08, 1);
    box(T_pillow, {0, 0, 0}, {0.6, 0.38, 0.12}, palette::linen());
  }
}

void Furnisher::bookshelf(const Pose& T, double width, double height, uint32_t seed) {
  Dice dice(seed);
  const double depth = 0.3, board = 0.025;
  for (const double x : {-1.0, 1.0})
    box(T, {x * (width - board) / 2, 0, height / 2}, {board, depth, height}, palette::birch());
  box(T, {0, -depth / 2 + 0.006, height / 2}, {width - 2 * board, 0.012, height}, palette::birch());
  const int rows = static_cast<int>(height / 0.36);
  const double pitch = (height - board) / rows;
  for (int row = 0; row <= rows; ++row) {
    const double z = row * pitch + board / 2;
    box(T, {0, 0.006, z}, {width - 2 * board, depth - 0.012, board}, palette::birch());
    if (row == rows) break;
    const double inner = width / 2 - board;
    double x = -inner;
    while (true) {
      if (dice.between(0, 1) < 0.1) {  // a gap, some with an ornament
        const double gap = dice.between(0.08, 0.2), radius = gap * 0.4;
        if (x + gap > inner) break;
        const Material material = palette::paint(dice.colour(), 0.3f);
        if (dice.between(0, 1) < 0.6)
          sphere(T, {x + gap / 2, 0.02, z + board / 2 + radius}, radius, material);
        x += gap;
        continue;
      }
      const double thickness = dice.between(0.018, 0.05), tall = dice.between(0.18, 0.3),
                   deep = dice.between(0.15, 0.23);
      if (x + thickness > inner) break;
      const Vec3f cover = dice.colour(), ink = dice.colour();
      box(T, {x + thickness / 2, -depth / 2 + 0.012 + deep / 2, z + board / 2 + tall / 2},
          {thickness - 0.002, deep, tall}, palette::print(cover, ink, 0.03));
      x += thickness;
    }
  }
}

void Furnisher::cabinet(const Pose& T, double width, double depth, double height, int doors,
                        const Material& body) {
  box(T, {0, 0, height / 2 + 0.03}, {width, depth, height - 0.06}, body);
  box(T, {0, -0.02, 0.03}, {width - 0.06, depth - 0.08, 0.06}, palette::walnut());
  const double door_width = width / doors;
  for (int i = 0; i < doors; ++i) {
    const double x = (i - (doors - 1) / 2.0) * door_width;
    box(T, {x, depth / 2 + 0.009, height / 2 + 0.03}, {door_width - 0.012, 0.018, height - 0.1}, body);
    const double knob = x + (i % 2 ? -1 : 1) * (door_width / 2 - 0.05);
    sphere(T, {knob, depth / 2 + 0.03, height * 0.55}, 0.016, palette::metal());
  }
}

void Furnisher::television(const Pose& T, double width) {
  const double height = width * 0.58;
  box(T, {0, 0, 0.01}, {width * 0.4, 0.2, 0.02}, palette::paint({0.05f, 0.05f, 0.05f}));
  box(T, {0, 0, 0.05}, {0.06, 0.05, 0.08}, palette::paint({0.05f, 0.05f, 0.05f}));
  box(T, {0, 0, 0.09 + height / 2}, {width, 0.045, height}, palette::paint({0.06f, 0.06f, 0.06f}));
  box(T, {0, 0.024, 0.09 + height / 2}, {width - 0.05, 0.004, height - 0.05}, palette::screen());
}

void Furnisher::desk(const Pose& T, double width, uint32_t seed) {
  table(T, width, 0.65, 0.74, palette::birch(), palette::metal());
  const Pose T_top = moved(T, 0, 0, 0.74);
  cabinet(moved(T, width / 2 - 0.32, 0, 0), 0.4, 0.55, 0.62, 1, palette::white_paint());
  television(turned_to(moved(T_top, -0.15, -0.18, 0), 0.15, 1), 0.56);
  box(T_top, {-0.15, 0.14, 0.011}, {0.44, 0.14, 0.022},
      palette::print({0.12f, 0.12f, 0.12f}, {0.7f, 0.7f, 0.7f}, 0.02));
  clutter(moved(T_top, width / 2 - 0.25, 0, 0), 0.4, 0.5, 6, seed);
}

void Furnisher::kitchen_row(const Pose& T, double width) {
  const int units = std::max(1, static_cast<int>(width / 0.55));
  cabinet(T, width, 0.58, 0.88, units, palette::paint({0.55f, 0.60f, 0.50f}, 0.2f));
  box(T, {0, 0.01, 0.9}, {width, 0.62, 0.04}, palette::stone_tiles());
  box(T, {-width / 4, 0, 0.922}, {0.56, 0.5, 0.004}, palette::screen());  // hob
  cylinder(T, {-width / 4 - 0.12, -0.1, 0.924}, 0.11, 0.14, palette::metal());
  cylinder(T, {-width / 4 + 0.13, 0.08, 0.924}, 0.09, 0.08, palette::clay());
  cylinder(T, {width / 4, -0.2, 0.92}, 0.018, 0.28, palette::metal());  // tap
  box(T, {width / 4, -0.12, 1.19}, {0.03, 0.18, 0.025}, palette::metal());
  clutter(moved(T, width / 4 + 0.32, -0.05, 0.92), 0.4, 0.4, 5, 77);
  const Pose T_upper = moved(T, 0, -0.12, 1.45);
  cabinet(T_upper, width, 0.34, 0.7, units, palette::paint({0.62f, 0.66f, 0.56f}, 0.2f));
}

void Furnisher::fridge(const Pose& T) {
  box(T, {0, 0, 0.92}, {0.62, 0.62, 1.76}, palette::white_paint());
  box(T, {0, 0.315, 0.55}, {0.6, 0.012, 0.98}, palette::white_paint());
  box(T, {0, 0.315, 1.42}, {0.6, 0.012, 0.72}, palette::white_paint());
  for (const double z : {0.85, 1.25}) box(T, {0.25, 0.34, z}, {0.025, 0.03, 0.3}, palette::metal());
  Dice dice(5);
  for (int i = 0; i < 7; ++i) {  // magnets and notes
    const double x = dice.between(-0.22, 0.18), z = dice.between(1.15, 1.7), size = dice.between(0.05, 0.13);
    const Vec3f paper = dice.colour();
    box(T, {x, 0.324, z}, {size, 0.005, size * 1.3}, palette::print(paper, {0.05f, 0.05f, 0.1f}, 0.012));
  }
}

void Furnisher::floor_lamp(const Pose& T) {
  cylinder(T, {0, 0, 0}, 0.15, 0.03, palette::metal());
  cylinder(T, {0, 0, 0.03}, 0.014, 1.45, palette::metal());
  cylinder(T, {0, 0, 1.4}, 0.19, 0.3, palette::cloth({0.85f, 0.75f, 0.5f}, {0.65f, 0.5f, 0.3f}, 0.04));
}

void Furnisher::plant(const Pose& T, double height, uint32_t seed) {
  Dice dice(seed);
  cylinder(T, {0, 0, 0}, 0.15, 0.28, palette::clay());
  cylinder(T, {0, 0, 0.28}, 0.012, height - 0.35, palette::walnut());
  for (int i = 0; i < 26; ++i) {
    // A leaf: a triangle with its base at the stem, hanging outwards.
    const Vector3d out =
        Vector3d(dice.between(-1, 1), dice.between(-1, 1), dice.between(-0.35, 0.75)).normalized();
    const Vector3d side =
        out.cross(Vector3d(dice.between(-0.4, 0.4), dice.between(-0.4, 0.4), 1)).normalized();
    const double length = dice.between(0.16, 0.32), width = dice.between(0.08, 0.15);
    Pose leaf = Pose::Identity();
    leaf.linear() << side, out, side.cross(out);
    leaf.translation() = Vector3d(0, 0, dice.between(0.45, height)) + 0.03 * out - side * width / 2;
    scene_.add({ShapeKind::kTriangle, {width, width / 2, length}}, T * leaf, palette::leaf());
  }
}

void Furnisher::rug(const Pose& T, double width, double depth, const Material& material) {
  box(T, {0, 0, 0.006}, {width, depth, 0.012}, material);
}

void Furnisher::clutter(const Pose& T, double width, double depth, int count, uint32_t seed) {
  Dice dice(seed);
  for (int i = 0; i < count; ++i) {
    // One thing per strip of the width, so that they do not run into each other.
    const double x = ((i + 0.5) / count - 0.5) * width, y = dice.between(-0.35, 0.35) * depth;
    const double size = std::min(0.5 * width / count, 0.09);
    const Vec3f colour = dice.colour(), accent = dice.colour();
    switch (static_cast<int>(dice.between(0, 4))) {
      case 0:
        sphere(T, {x, y, size}, size, palette::cloth(colour, accent, 0.02));
        break;
      case 1:
        cylinder(T, {x, y, 0}, size * 0.7, dice.between(0.08, 0.2), palette::print(colour, accent, 0.025));
        break;
      default: {
        const Pose T_thing = turned_to(moved(T, x, y, 0), dice.between(-1, 1), 1.5);
        const double tall = dice.between(0.03, 0.22);
        box(T_thing, {0, 0, tall / 2}, {1.4 * size, dice.between(1.2, 2.2) * size, tall},
            palette::print(colour, accent, 0.03));
      }
    }
  }
}

}  // namespace kt
