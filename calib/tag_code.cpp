// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calib/tag_code.h"

#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>

#include <cstdlib>
#include <memory>

#include "common/error.h"

namespace arpent::calib {
namespace {

constexpr int kBits = 6;  // along a side

struct FamilyDeleter {
  void operator()(apriltag_family_t* family) const { tag36h11_destroy(family); }
};

}  // namespace

TagCode::TagCode(int id, int border_cells) : cells_(kBits + 2 * border_cells) {
  ARPENT_ASSERT(border_cells == 1 || border_cells == 2);
  const std::unique_ptr<apriltag_family_t, FamilyDeleter> family(tag36h11_create());
  ARPENT_ASSERT(id >= 0 && id < static_cast<int>(family->ncodes));
  image_u8_t* image = apriltag_to_image(family.get(), static_cast<std::uint32_t>(id));
  // The picture has a white margin of one cell and a border of one.
  ARPENT_ASSERT(image->width == kBits + 4 && image->height == kBits + 4);
  black_.assign(static_cast<std::size_t>(cells_ * cells_), true);
  for (int row = 0; row < kBits; ++row) {
    for (int column = 0; column < kBits; ++column) {
      black_[static_cast<std::size_t>((row + border_cells) * cells_ + column + border_cells)] =
          image->buf[(row + 2) * image->stride + column + 2] < 128;
    }
  }
  // What image_u8_destroy does, which Debian's library does not export.
  std::free(image->buf);
  std::free(image);
}

}  // namespace arpent::calib
