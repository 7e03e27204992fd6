// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The certificate of termination: what stayed incomplete at the end of a mission, each element with its reason, and all
// that somebody else needs to check it: robot, camera, voxel size, the poses that were tried (docs/certificates.md).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "planning/viewpoints/certificate.h"

namespace arpent::planning {

/// Under which circumstances the reasons were given.
struct CertificateContext {
  std::string end = "done";  ///< done or aborted
  std::string reason = {};   ///< why aborted
  std::string map_frame = "world";
  double voxel_m = 0.1;
  double known_weight = 0.3;    ///< W_th
  double give_up_factor = 4.0;  ///< looks worth this many W_th were enough: the lesser of the two of ViewpointParams
  double least_piece_m = 0;     ///< smaller pieces of incomplete surface were left (ViewpointParams)
  Pose2 start = {};             ///< of the mission, map frame
  double semi_long_m = 0.55, semi_short_m = 0.25;
  LevelCamera camera = {};
  double lattice_m = 0.25;        ///< spacing of the poses that were tried (ViewpointParams)
  std::vector<Pose2> poses = {};  ///< Certifier::poses(): those that could be reached; empty: not kept
};

/// An element left, as read back. Places are in the map frame.
struct CertifiedElement {
  VoxelIndex voxel = VoxelIndex::Zero();
  Verdict verdict = Verdict::kCompletable;
  Eigen::Vector3d place_m = Eigen::Vector3d::Zero();  ///< the unknown voxel in the way, or the element itself
  int in_view = 0;
  int in_sight = 0;
  bool small_piece = false;
};

struct CertificateFile {
  CertificateContext context;
  std::vector<CertifiedElement> elements;
};

/// All of the file or nothing. Poses are kept as cells of the lattice with a bit for each heading; they must lie on it
/// (Certifier). Throws InputError if the disk refuses.
void write_certificates(const std::filesystem::path& file, const CertificateContext& context,
                        const std::vector<Certificate>& certificates);

/// Throws InputError with the file's name if it is damaged or of another format.
[[nodiscard]] CertificateFile read_certificates(const std::filesystem::path& file);

}  // namespace arpent::planning
