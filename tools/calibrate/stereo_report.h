// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A calibration for people (HTML page, sentences) and for scripts (JSON).
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "calib/quality.h"

namespace arpent::tools {

/// Lines for the terminal: figures, what was left out, verdict and advice.
[[nodiscard]] std::string summarize(const calib::Calibration& calibration, const calib::Quality& quality);
[[nodiscard]] nlohmann::json to_json(const calib::Calibration& calibration, const calib::Quality& quality);
/// Writes `folder`/report.html. Throws InputError.
void write_report(const calib::Calibration& calibration, const calib::Quality& quality,
                  const std::filesystem::path& folder);

}  // namespace arpent::tools
