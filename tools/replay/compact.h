// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Messages as they are kept in logs: images and depth compressed without loss, all else as published. The same for what
// is compact already, so that messages can be compared with those of a log whoever wrote it.
#pragma once

#include <string>

#include "common/bus/bus.h"

namespace arpent::tools {

/// What cannot be decoded stays as it is.
[[nodiscard]] Bytes compact_for_log(const std::string& channel, BytesView bytes);

}  // namespace arpent::tools
