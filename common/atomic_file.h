// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Files that are either whole or not there: written beside their place, flushed to disk, then renamed over it.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <span>
#include <string_view>

namespace arpent {

/// Receives a part of the file's bytes, in order.
using WriteBytes = std::function<void(std::span<const std::byte>)>;

/// Calls `produce`, which hands over the content in as many parts as it likes; when it returns, the content is synced
/// to disk and renamed to `path`, and the folder is synced. If anything fails (disk full, no such folder, `produce`
/// throws) the temporary file is removed, whatever was at `path` stays, and InputError (or `produce`'s exception) is
/// thrown.
void atomic_write(const std::filesystem::path& path, const std::function<void(const WriteBytes&)>& produce);
void atomic_write(const std::filesystem::path& path, std::string_view content);

}  // namespace arpent
