// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/tags/detector.h"

#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>

#include <algorithm>
#include <tuple>

#include "common/error.h"

namespace arpent::tags {
namespace {

/// Where libapriltag has the centre of the top-left pixel.
constexpr double kLibraryPixelCentre = 0.5;
/// Fewer pixels than the eight cells of a tag have cannot be decoded.
constexpr int kMinPartPx = 16;

struct FamilyDeleter {
  void operator()(apriltag_family_t* family) const { tag36h11_destroy(family); }
};
struct LibraryDeleter {
  void operator()(apriltag_detector_t* detector) const { apriltag_detector_destroy(detector); }
};
struct DetectionsDeleter {
  void operator()(zarray_t* detections) const { apriltag_detections_destroy(detections); }
};

TagDetection from_library(const apriltag_detection_t& found, const cv::Point& origin) {
  TagDetection tag{found.id, found.hamming, static_cast<double>(found.decision_margin), {}};
  for (std::size_t k = 0; k < 4; ++k) {
    tag.corners_px[k] = {found.p[k][0] - kLibraryPixelCentre + origin.x,
                         found.p[k][1] - kLibraryPixelCentre + origin.y};
  }
  return tag;
}

}  // namespace

struct TagDetector::Detector {
  DetectorParams params;
  std::unique_ptr<apriltag_family_t, FamilyDeleter> family{tag36h11_create()};
  std::unique_ptr<apriltag_detector_t, LibraryDeleter> library{apriltag_detector_create()};

  explicit Detector(const DetectorParams& detector_params) : params(detector_params) {
    // The library's table of codes grows with the bits that it corrects: 1 MB for one, 19 MB for two.
    apriltag_detector_add_family_bits(library.get(), family.get(), params.max_hamming);
    library->nthreads = 1;
  }

  std::vector<TagDetection> run(const cv::Mat1b& image, const cv::Point& origin, double decimate) const {
    library->quad_decimate = static_cast<float>(decimate);
    // The library's own refinement repairs what decimation costs; at full resolution it only loses tags (45 instead of
    // 47 on its public photos).
    library->refine_edges = decimate > 1;
    image_u8_t view{image.cols, image.rows, static_cast<int>(image.step), image.data};
    const std::unique_ptr<zarray_t, DetectionsDeleter> found(apriltag_detector_detect(library.get(), &view));
    std::vector<TagDetection> tags;
    for (int i = 0; i < zarray_size(found.get()); ++i) {
      apriltag_detection_t* detection = nullptr;
      zarray_get(found.get(), i, &detection);
      if (detection->hamming > params.max_hamming || detection->decision_margin < params.min_decision_margin) continue;
      tags.push_back(from_library(*detection, origin));
    }
    std::sort(tags.begin(), tags.end(), [](const TagDetection& a, const TagDetection& b) {
      return std::make_tuple(a.id, a.corners_px[0].x(), a.corners_px[0].y()) <
             std::make_tuple(b.id, b.corners_px[0].x(), b.corners_px[0].y());
    });
    return tags;
  }
};

TagDetector::TagDetector(const DetectorParams& params) : detector_(std::make_unique<Detector>(params)) {}
TagDetector::~TagDetector() = default;
TagDetector::TagDetector(TagDetector&&) noexcept = default;
TagDetector& TagDetector::operator=(TagDetector&&) noexcept = default;

std::vector<TagDetection> TagDetector::detect(const cv::Mat1b& image) const {
  ARPENT_ASSERT(!image.empty());
  return detector_->run(image, {0, 0}, detector_->params.decimate);
}

std::vector<TagDetection> TagDetector::detect_in(const cv::Mat1b& image, const cv::Rect& part) const {
  const cv::Rect inside = part & cv::Rect(0, 0, image.cols, image.rows);
  if (inside.width < kMinPartPx || inside.height < kMinPartPx) return {};
  return detector_->run(image(inside), inside.tl(), 1.0);
}

}  // namespace arpent::tags
