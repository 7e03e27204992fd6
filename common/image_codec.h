// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// image_t <-> cv::Mat: raw, zstd or PNG (all lossless), with CRC-32C. Sizes are checked against each other before
// anything is allocated or decoded.
#pragma once

#include <arpent/image_t.hpp>
#include <opencv2/core.hpp>

#include "common/result.h"

namespace arpent {

/// kZstd: rows as differences from the row above, then zstd; decodes ten times as fast as PNG, and is about as small.
enum class Compression { kNone, kPng, kZstd };

/// `image`: CV_8UC1 or CV_16UC1.
[[nodiscard]] image_t encode_image(const cv::Mat& image, Compression compression = Compression::kNone);
/// CV_8UC1 or CV_16UC1 with its own memory, or what is wrong with the message.
[[nodiscard]] Result<cv::Mat> decode_image(const image_t& message);

}  // namespace arpent
