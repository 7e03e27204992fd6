// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Reads asymmetric travelling salesman problems in the format of TSPLIB 95 (Reinelt): TYPE ATSP (or TSP) with an
// explicit FULL_MATRIX. Whatever else a file asks for is refused, never guessed.
#pragma once

#include <filesystem>
#include <string>

#include "planning/tour/matrix.h"

namespace arpent::tour {

struct TsplibProblem {
  std::string name;
  Matrix cost;  ///< row = from; the diagonal is 0, whatever the file forbids it with
  bool whole_numbers = true;
};

/// Throws InputError with the file and line of the fault.
[[nodiscard]] TsplibProblem read_tsplib(const std::filesystem::path& file);
/// The same from text; `name` stands for the file in messages.
[[nodiscard]] TsplibProblem parse_tsplib(const std::string& text, const std::string& name);

}  // namespace arpent::tour
