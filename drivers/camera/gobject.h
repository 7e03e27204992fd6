// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What GLib needs to be safe in C++: owned objects, and errors that cannot be forgotten.
#pragma once

#include <glib-object.h>

#include <memory>
#include <string>

#include "drivers/camera/frame_source.h"

namespace arpent::camera {

struct Unref {
  void operator()(gpointer object) const { g_object_unref(object); }
};
template <class T>
using Owned = std::unique_ptr<T, Unref>;

/// A GError of one call; hand it over as its last argument.
class GFault {
 public:
  GFault() = default;
  ~GFault() { g_clear_error(&error_); }
  GFault(const GFault&) = delete;
  GFault& operator=(const GFault&) = delete;
  operator GError**() {  // NOLINT(google-explicit-constructor): that is what it is for
    g_clear_error(&error_);
    return &error_;
  }
  [[nodiscard]] bool failed() const { return error_ != nullptr; }
  [[nodiscard]] std::string text() const { return failed() ? error_->message : ""; }
  /// Throws DeviceLost if the call before failed.
  void require(const std::string& what) const {
    if (failed()) throw DeviceLost(what + ": " + text());
  }

 private:
  GError* error_ = nullptr;
};

}  // namespace arpent::camera
