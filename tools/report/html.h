// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The report page: one HTML file that needs nothing else. Sections of figures, pictures, plots and tables, written by
// us as plain HTML and SVG.
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace arpent::report {

struct Figure {
  std::string name;
  std::string value;  ///< with its unit
  std::string remark;
};

struct Curve {
  std::string name;
  std::string color;  ///< CSS
  std::vector<std::pair<double, double>> points;
};

class Page {
 public:
  Page(std::string title, std::string subtitle) : title_(std::move(title)), subtitle_(std::move(subtitle)) {}

  void section(const std::string& heading, const std::string& text = "");
  void figures(const std::vector<Figure>& figures);
  /// Pictures side by side (BGR or grey), each with its caption.
  void pictures(const std::vector<std::pair<cv::Mat, std::string>>& pictures);
  /// Frames of equal size, one after the other in an endless loop of `seconds`, the last one held for a while.
  void film(const std::vector<cv::Mat>& frames, double seconds, const std::string& caption);
  /// Curves without a name have no legend. `equal_axes`: a map; otherwise a plot over x.
  void plot(const std::vector<Curve>& curves, const std::string& x_label, const std::string& y_label, bool equal_axes);
  void table(const std::vector<std::string>& head, const std::vector<std::vector<std::string>>& rows);
  void list(const std::vector<std::string>& items);

  /// Writes `folder`/report.html, all of it or nothing. Throws InputError.
  void write(const std::filesystem::path& folder) const;

 private:
  std::string title_;
  std::string subtitle_;
  std::string body_;
};

/// Text made safe for HTML.
[[nodiscard]] std::string escape(const std::string& text);
/// Colours for [least, most], missing (0) grey.
[[nodiscard]] cv::Mat3b colour(const cv::Mat1f& values, double least, double most);

}  // namespace arpent::report
