// Writes gnuplot scripts with their data inline and pipes them to gnuplot.
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/eval/plot.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <numeric>
#include <sstream>
#include <string>

#include "shared/core/check.h"
#include "shared/io/file.h"
#include "shared/io/number_text.h"

namespace kt {
namespace {

/// Looked up before the pipe is opened: the shell's own "not found" would come too late for a clear message.
void require_gnuplot() {
  const char* path = std::getenv("PATH");
  std::stringstream folders(path ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');) {
    std::error_code ignored;
    if (std::filesystem::exists(std::filesystem::path(folder) / "gnuplot", ignored)) return;
  }
  throw Error("gnuplot was not found, plots need it: install the package gnuplot-nox");
}

void run_gnuplot(const std::string& script, const std::filesystem::path& png) {
  require_gnuplot();
  std::string quoted;  // in gnuplot's single quotes, a quote is written twice
  for (const char c : png.string()) quoted += c == '\'' ? std::string("''") : std::string(1, c);
  const std::string text =
      "set terminal pngcairo size 1200,900 font ',11'\nset output '" + quoted + "'\nset grid\n" + script;
  remove_file(png);  // so that what stands there afterwards is new
  std::FILE* pipe = popen("gnuplot >/dev/null 2>&1", "w");
  if (!pipe) throw Error("gnuplot could not be started");
  const bool sent = std::fwrite(text.data(), 1, text.size(), pipe) == text.size();
  std::error_code ignored;
  if (pclose(pipe) != 0 || !sent || !std::filesystem::exists(png, ignored)) {
    throw Error(png.string() + ": gnuplot could not draw it; is the folder there and writable?");
  }
}

std::string row(std::initializer_list<double> values) {
  std::string text;
  for (const double value : values) text += number_text(value) + ' ';
  return text + '\n';
}

/// The share of the distances up to each of 400 steps.
std::string cumulative(std::vector<double> distances_m, double limit_m) {
  std::sort(distances_m.begin(), distances_m.end());
  std::string text;
  for (int step = 0; step <= 400; ++step) {
    const double distance_m = limit_m * step / 400;
    const auto end = std::upper_bound(distances_m.begin(), distances_m.end(), distance_m);
    text += row({1000 * distance_m, 100.0 * static_cast<double>(end - distances_m.begin()) /
                                        static_cast<double>(distances_m.size())});
  }
  return text;
}

}  // namespace

void plot_trajectory_error(const AbsoluteTrajectoryError& error, const std::filesystem::path& png) {
  Eigen::Vector3d low = error.samples.front().p_groundtruth, high = low;
  for (const auto& sample : error.samples) {
    low = low.cwiseMin(sample.p_groundtruth);
    high = high.cwiseMax(sample.p_groundtruth);
  }
  std::array<int, 3> axes = {0, 1, 2};
  std::stable_sort(axes.begin(), axes.end(), [&](int a, int b) { return (high - low)[a] > (high - low)[b]; });
  std::sort(axes.begin(), axes.begin() + 2);

  std::string data;
  for (const auto& sample : error.samples) {
    const double seconds =
        static_cast<double>(sample.timestamp_us - error.samples.front().timestamp_us) * 1e-6;
    data += row({seconds, 1000 * sample.error_m, sample.p_groundtruth[axes[0]], sample.p_groundtruth[axes[1]],
                 sample.p_estimate[axes[0]], sample.p_estimate[axes[1]]});
  }
  const char names[] = "xyz";
  std::string script = "$poses << EOD\n" + data + "EOD\nset multiplot layout 2,1\n";
  script += "set size ratio -1\nset key outside\n";
  script += std::string("set xlabel '") + names[axes[0]] + " (m)'\nset ylabel '" + names[axes[1]] + " (m)'\n";
  script += "plot $poses using 3:4 with lines lc rgb '#404040' title 'ground truth', ";
  script += "$poses using 5:6 with lines lc rgb '#c02020' title 'estimate'\n";
  script += "set size noratio\nset xlabel 'time (s)'\nset ylabel 'error (mm)'\nset yrange [0:]\n";
  script += "rmse = " + number_text(1000 * error.translation_m.rmse) + "\n";
  script += "plot $poses using 1:2 with lines lc rgb '#c02020' title 'position error', ";
  script += "rmse with lines dt 2 lc rgb '#404040' title sprintf('RMSE %.1f mm', rmse)\nunset multiplot\n";
  run_gnuplot(script, png);
}

void plot_surface_error(const SurfaceError& error, double threshold_m, const std::filesystem::path& png) {
  const double limit_m = 3 * threshold_m;
  std::string script = "$accuracy << EOD\n" + cumulative(error.accuracy_distances_m, limit_m) + "EOD\n";
  script += "$completeness << EOD\n" + cumulative(error.completeness_distances_m, limit_m) + "EOD\n";
  script +=
      "set xlabel 'distance (mm)'\nset ylabel 'share within it (%)'\nset yrange [0:100]\nset key bottom "
      "right\n";
  const std::string threshold_mm = number_text(1000 * threshold_m);
  script +=
      "set arrow from " + threshold_mm + ",0 to " + threshold_mm + ",100 nohead dt 2 lc rgb '#404040'\n";
  script += "plot $accuracy with lines lw 2 lc rgb '#c02020' title 'map to true surface (accuracy)', ";
  script += "$completeness with lines lw 2 lc rgb '#2040c0' title 'true surface to map (completeness)'\n";
  run_gnuplot(script, png);
}

}  // namespace kt
