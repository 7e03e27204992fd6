// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Views of a board from what a user has: folders of pictures, corners of another detector as CSV, an LCM log.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "calib/views.h"

namespace arpent::tools {

/// Told how many of how many pictures are done.
using Progress = std::function<void(std::size_t done, std::size_t total)>;

/// Files of each camera by the name of their view. Subfolders cam0, cam1, … or left, right (each perhaps with a folder
/// `data`, as in EuRoC's mav0); or names that begin so in one folder; or all files, one camera. `extensions` in lower
/// case with the dot.
[[nodiscard]] std::map<std::string, std::map<std::string, std::filesystem::path>> find_camera_files(
    const std::filesystem::path& folder, const std::vector<std::string>& extensions);

/// Throws InputError: nothing found, unreadable pictures, a camera whose pictures differ in size.
[[nodiscard]] calib::BoardViews views_from_images(const calib::Target& target, const std::filesystem::path& folder,
                                                  const Progress& progress);
/// CSV with at least kp_x, kp_y [px] and p_x, p_y, p_z [m] by name in the first line. `size`: width and height, or {0,
/// 0}: the smallest usual size that holds all corners. Throws InputError, also for corners that are not on the board.
[[nodiscard]] calib::BoardViews views_from_corners(const calib::Target& target, const std::filesystem::path& folder,
                                                   std::array<int, 2> size);
/// STEREO_IMAGES of a log: pairs between which the board has moved, `most` at most.
[[nodiscard]] calib::BoardViews views_from_log(const calib::Target& target, const std::filesystem::path& log,
                                               std::size_t most, const Progress& progress);

}  // namespace arpent::tools
