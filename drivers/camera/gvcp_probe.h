// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Is there a GigE Vision camera at an address? One discovery command by unicast (GVCP, GigE Vision 2.0, 14.1.1), one
// answer. Aravis' own search takes seconds and holds a lock on everything else while it waits; this does not.
#pragma once

#include <string>

#include "common/time.h"

namespace arpent::camera {

[[nodiscard]] bool is_ipv4(const std::string& text);
/// Waits at most `patience` for the answer.
[[nodiscard]] bool gige_camera_answers(const std::string& ipv4, Duration patience);

}  // namespace arpent::camera
