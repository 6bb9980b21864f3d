// The files of one segment, and the folders of all but the main one.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "offboard/report/map_report.h"

namespace kt {

/// "segment-3"
std::string segment_folder(int number);

/// Makes the folder where it is missing; throws kt::Error where it cannot.
void create_folder(const std::filesystem::path& folder);

/// "map.glb"
std::string map_file(const std::string& format);

/// Name within `output`, size and digest of the file at `path`.
MapFile described(const std::filesystem::path& output, const std::filesystem::path& path);

/// Writes the map in every one of `formats` (ply, obj, glb, pcd), trajectory.txt and poses.g2o to map.folder
/// within `output`, replacing what stands there; says what was written.
std::vector<MapFile> write_group(const std::filesystem::path& output, const GroupMap& map,
                                 const PlacedMission& placed, const Calibration& calibration,
                                 const std::vector<std::string>& formats);

/// Removes those files from all segment-N in `output`, and the folders that are empty then. What
/// somebody else put there stays. Throws kt::Error where a file cannot be removed.
void remove_segment_folders(const std::filesystem::path& output);

}  // namespace kt
