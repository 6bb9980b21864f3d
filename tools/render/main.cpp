// kintsugi-render: a picture of a map, without a screen.
// SPDX-License-Identifier: BSD-3-Clause
#include <charconv>
#include <cstdio>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "shared/cli/program.h"
#include "shared/core/check.h"
#include "shared/io/image_file.h"
#include "shared/io/ply.h"
#include "shared/io/trajectory_file.h"
#include "tools/render/rasteriser.h"
#include "tools/render/view.h"

namespace kt {
namespace {

constexpr int kSupersampling = 3;  // samples per pixel and direction
constexpr Rgb8 kGold{230, 168, 23};
const std::map<std::string, Rgb8> kBackgrounds = {{"white", {255, 255, 255}}, {"dark", {22, 24, 29}}};

struct Options {
  std::string map, picture, trajectory, size = "1280x960", up = "-y", background = "dark";
  std::optional<float> cut_ceiling_m;
  ViewOptions view;
};

void parse_size(const std::string& text, ViewOptions& view) {
  const char* end = text.data() + text.size();
  const auto width = std::from_chars(text.data(), end, view.width);
  if (width.ec == std::errc() && width.ptr != end && *width.ptr == 'x') {
    const auto height = std::from_chars(width.ptr + 1, end, view.height);
    if (height.ec == std::errc() && height.ptr == end) return;
  }
  throw Error("--size " + text + ": give width and height as in 1280x960");
}

/// Leaves out the triangles with a corner higher than `limit_m` above the floor, and the vertices that no
/// triangle needs.
Mesh below_ceiling(const Mesh& mesh, Vec3f up_map, std::optional<float> limit_m) {
  const HeightAboveFloor height_m(mesh.vertices, up_map);
  Mesh kept;
  std::vector<uint32_t> new_index(mesh.vertices.size(), UINT32_MAX);
  for (auto triangle : mesh.triangles) {
    bool keep = true;
    for (const uint32_t corner : triangle)
      keep = keep && !(limit_m && height_m(mesh.vertices[corner]) > *limit_m);
    if (!keep) continue;
    for (uint32_t& corner : triangle) {
      uint32_t& index = new_index[corner];
      if (index == UINT32_MAX) {
        index = static_cast<uint32_t>(kept.vertices.size());
        kept.vertices.push_back(mesh.vertices[corner]);
        if (!mesh.normals.empty()) kept.normals.push_back(mesh.normals[corner]);
        if (!mesh.colours.empty()) kept.colours.push_back(mesh.colours[corner]);
      }
      corner = index;
    }
    kept.triangles.push_back(triangle);
  }
  return kept;
}

void run(Options& options) {
  parse_size(options.size, options.view);
  Mesh mesh = read_ply(options.map);
  options.view.up_map = levelled_up(mesh.normals, axis_from_text(options.up));
  mesh = below_ceiling(mesh, options.view.up_map, options.cut_ceiling_m);
  if (mesh.triangles.empty())
    throw Error(options.map + ": holds no triangle to draw" +
                (options.cut_ceiling_m ? " below --cut-ceiling" : ""));
  std::vector<Vec3f> path_map;
  if (!options.trajectory.empty())
    for (const StampedPose& pose : read_trajectory(options.trajectory))
      path_map.push_back(to_rigid3f(pose.T_odom_camera).t);

  const Viewpoint view = frame_points(mesh.vertices, options.view).enlarged(kSupersampling);
  light(mesh, view);
  Canvas canvas(view, kBackgrounds.at(options.background));
  canvas.draw(mesh);
  canvas.shade_depth_edges(2 * kSupersampling, 12.0f);
  canvas.draw_path(path_map, kGold, 2.5f * kSupersampling);
  write_colour(options.picture, shrunk(canvas.colour(), kSupersampling));
  std::printf("%s: %d x %d, %zu triangles\n", options.picture.c_str(), options.view.width,
              options.view.height, mesh.triangles.size());
}

}  // namespace
}  // namespace kt

int main(int argc, char** argv) {
  kt::Options options;
  CLI::App app("Draws a map as a picture. Surfaces that turn their back are left out, so that rooms open up.",
               "kintsugi-render");
  app.add_option("map", options.map, "mesh to draw (.ply)")->required();
  app.add_option("picture", options.picture, "picture to write (.png or .jpg)")->required();
  app.add_option("--view", options.view.name, "iso (from above a corner), top, or inside (from the origin)")
      ->check(CLI::IsMember({"iso", "top", "inside"}))
      ->capture_default_str();
  app.add_option("--trajectory", options.trajectory, "path of the camera to draw in gold (TUM format)");
  app.add_option("--size", options.size, "width and height in pixels")->capture_default_str();
  app.add_option("--cut-ceiling", options.cut_ceiling_m,
                 "leave out what is higher above the floor than this (m)");
  app.add_option("--up", options.up,
                 "axis of the map that points up, roughly: it is levelled to the floor (a map begins in its "
                 "first camera)")
      ->capture_default_str();
  app.add_option("--azimuth", options.view.azimuth_deg, "iso: direction from which to look (degrees)")
      ->capture_default_str();
  app.add_option("--elevation", options.view.elevation_deg,
                 "iso: height of the viewer over the horizon (degrees)")
      ->capture_default_str();
  app.add_option("--background", options.background, "dark or white")
      ->check(CLI::IsMember({"dark", "white"}))
      ->capture_default_str();
  return kt::run_program(app, argc, argv, [&] { kt::run(options); });
}
