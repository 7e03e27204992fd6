// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Checks a certificate of termination against the true world and the mission's log: whether each reason that the robot
// gave for leaving an element incomplete holds there (docs/certificates.md says what exactly is asked).
#pragma once

#include <string>
#include <vector>

#include "planning/viewpoints/certificate_file.h"
#include "tools/evaluation/reconstruction.h"

namespace arpent::tools {

/// Why an element counts as rightly left.
enum class Finding : std::uint8_t {
  kTrue,   ///< the reason holds in the true world
  kMoot,   ///< the reason does not, but no true surface that could be seen is missing there
  kFalse,  ///< neither: a legal pose could have completed surface that is missing
};

struct CheckedElement {
  planning::CertifiedElement element;
  Finding finding = Finding::kFalse;
  std::string remark;  ///< what was found
};

struct CertificateCheck {
  std::vector<CheckedElement> elements;
  int true_count = 0, moot_count = 0, false_count = 0;
  int unfinished = 0;       ///< elements that are listed as completable: none when the mission says that it is done
  int small_pieces = 0;     ///< elements left because their piece is small
  double uncovered_m2 = 0;  ///< visible true surface that the mesh lacks, all over the world
  double in_contact_percent = 0;  ///< of the poses that the robot calls reachable: those that touch the true world
  /// Share of the elements that were rightly left; 100 if there are none.
  [[nodiscard]] double valid_percent() const;
  [[nodiscard]] double true_percent() const;
};

/// A camera's pose at a depth image of the mission.
using Looks = std::vector<Pose2>;

/// What the check is made against: poses that are legal in the true world with the certificate's own robot, the body
/// grown by half a voxel's diagonal (the map tells no less); visible surface and what of it the mesh covers; the body's
/// poses at the depth images that went into the map.
struct CertificateEvidence {
  const evaluation::LegalViews& views;
  const evaluation::TrueSurface& truth;
  const evaluation::Reconstruction& reconstruction;
  const Looks& looks;
};
[[nodiscard]] CertificateCheck check_certificates(const planning::CertificateFile& file,
                                                  const CertificateEvidence& evidence);

/// Reads `folder` and checks its certificate.json. Throws InputError.
[[nodiscard]] CertificateCheck check_folder(const std::filesystem::path& folder, const std::filesystem::path& world);

/// Reads the body's poses at all depth images that a map could use (PAIR_POSE with a DEPTH of the same time).
[[nodiscard]] Looks read_looks(const std::filesystem::path& log);

}  // namespace arpent::tools
