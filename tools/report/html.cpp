// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/report/html.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "common/atomic_file.h"

namespace arpent::report {
namespace {

constexpr const char* kStyle = R"css(
:root{--ink:#1d2329;--soft:#5d6873;--line:#d9dee3;--paper:#fbfbf9;--card:#fff;--accent:#0b6e69}
@media(prefers-color-scheme:dark){:root{--ink:#e6e9ec;--soft:#9aa5b0;--line:#343c44;--paper:#14181c;--card:#1c2227;--accent:#4fc3b8}}
*{box-sizing:border-box}body{margin:0;background:var(--paper);color:var(--ink);font:16px/1.55 system-ui,-apple-system,"Segoe UI",Roboto,sans-serif}
main{max-width:1180px;margin:0 auto;padding:2.5rem 1.5rem 4rem}h1{font-size:2rem;line-height:1.2;margin:0 0 .3rem;letter-spacing:-.01em}
h2{font-size:1.25rem;margin:2.6rem 0 .6rem;padding-top:1.2rem;border-top:1px solid var(--line)}p{margin:.4rem 0 1rem;color:var(--soft);max-width:75ch}
.figures{display:grid;grid-template-columns:repeat(auto-fill,minmax(190px,1fr));gap:.8rem;margin:1.2rem 0}
.figure{background:var(--card);border:1px solid var(--line);border-radius:10px;padding:.8rem 1rem}.figure b{display:block;font-size:1.5rem;font-weight:650;font-variant-numeric:tabular-nums}
.figure span{color:var(--soft);font-size:.85rem}.figure i{display:block;color:var(--soft);font-size:.78rem;font-style:normal}
.pictures{display:flex;flex-wrap:wrap;gap:1rem}.pictures figure{flex:1 1 300px;margin:0;background:var(--card);border:1px solid var(--line);border-radius:10px;overflow:hidden}
.pictures img{display:block;width:100%;height:auto}.pictures figcaption{padding:.5rem .8rem;color:var(--soft);font-size:.85rem}
.film{width:100%;background-repeat:no-repeat;animation:film linear infinite}@keyframes film{from{background-position:0 0}85%,to{background-position:100% 0}}
svg{width:100%;height:auto;background:var(--card);border:1px solid var(--line);border-radius:10px}svg text{fill:var(--soft);font-size:12px}
table{border-collapse:collapse;width:100%;font-size:.92rem;font-variant-numeric:tabular-nums}th,td{text-align:left;padding:.35rem .7rem;border-bottom:1px solid var(--line)}
th{color:var(--soft);font-weight:600}td+td,th+th{text-align:right}.legend{display:flex;gap:1.2rem;margin:.4rem 0;font-size:.85rem;color:var(--soft)}.legend i{display:inline-block;width:1.4em;height:3px;vertical-align:middle;margin-right:.4em}
li{margin:.2rem 0}@media print{main{max-width:none}h2{break-after:avoid}}
)css";

std::string base64(const std::vector<std::uint8_t>& bytes) {
  static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t word = 0;
    for (std::size_t k = 0; k < 3; ++k) word = word << 8 | (i + k < bytes.size() ? bytes[i + k] : 0U);
    for (std::size_t k = 0; k < 4; ++k) text += i + k <= bytes.size() ? kDigits[word >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

std::string png_url(const cv::Mat& picture) {
  std::vector<std::uint8_t> png;
  cv::imencode(".png", picture, png, {cv::IMWRITE_PNG_COMPRESSION, 7});
  return "data:image/png;base64," + base64(png);
}

/// A step of 1, 2 or 5 times a power of ten that divides `range` into about `parts`.
double nice_step(double range, double parts) {
  const double raw = std::max(range, 1e-12) / parts;
  const double power = std::pow(10.0, std::floor(std::log10(raw)));
  for (const double m : {1.0, 2.0, 5.0}) {
    if (m * power >= raw) return m * power;
  }
  return 10 * power;
}

struct Axes {
  double x0 = 0, x1 = 1, y0 = 0, y1 = 1;
  double width = 1100, height = 420;
  static constexpr double kLeft = 56, kRight = 16, kTop = 14, kBottom = 42;

  [[nodiscard]] double u(double x) const { return kLeft + (x - x0) / (x1 - x0) * (width - kLeft - kRight); }
  [[nodiscard]] double v(double y) const { return height - kBottom - (y - y0) / (y1 - y0) * (height - kTop - kBottom); }
};

Axes fit_axes(const std::vector<Curve>& curves, bool equal) {
  Axes axes;
  bool first = true;
  for (const Curve& curve : curves) {
    for (const auto& [x, y] : curve.points) {
      axes.x0 = first ? x : std::min(axes.x0, x);
      axes.x1 = first ? x : std::max(axes.x1, x);
      axes.y0 = first ? y : std::min(axes.y0, y);
      axes.y1 = first ? y : std::max(axes.y1, y);
      first = false;
    }
  }
  if (!equal) axes.y0 = std::min(0.0, axes.y0);
  const double pad_x = std::max(1e-6, 0.03 * (axes.x1 - axes.x0)), pad_y = std::max(1e-6, 0.06 * (axes.y1 - axes.y0));
  axes.x1 += pad_x;
  axes.y1 += pad_y;
  if (!equal) return axes;
  axes.x0 -= pad_x;
  axes.y0 -= pad_y;
  const double inner = axes.width - Axes::kLeft - Axes::kRight;
  const double wanted = inner * (axes.y1 - axes.y0) / (axes.x1 - axes.x0);
  axes.height = std::clamp(wanted, 160.0, 620.0) + Axes::kTop + Axes::kBottom;
  // Widen the axis that has room to spare, so that a metre is as long on both.
  const double per_x = (axes.x1 - axes.x0) / inner;
  const double per_y = (axes.y1 - axes.y0) / (axes.height - Axes::kTop - Axes::kBottom);
  const double scale = std::max(per_x, per_y);
  const double grow_x = 0.5 * (scale / per_x - 1) * (axes.x1 - axes.x0),
               grow_y = 0.5 * (scale / per_y - 1) * (axes.y1 - axes.y0);
  axes.x0 -= grow_x;
  axes.x1 += grow_x;
  axes.y0 -= grow_y;
  axes.y1 += grow_y;
  return axes;
}

std::string draw_grid(const Axes& axes, const std::string& x_label, const std::string& y_label) {
  std::string svg;
  const double step_x = nice_step(axes.x1 - axes.x0, 9), step_y = nice_step(axes.y1 - axes.y0, 5);
  for (double x = std::ceil(axes.x0 / step_x) * step_x; x <= axes.x1; x += step_x) {
    svg += fmt::format(
        "<line x1='{0:.1f}' x2='{0:.1f}' y1='{1:.1f}' y2='{2:.1f}' stroke='var(--line)'/><text x='{0:.1f}' y='{3:.1f}' "
        "text-anchor='middle'>{4:g}</text>",
        axes.u(x), Axes::kTop, axes.height - Axes::kBottom, axes.height - Axes::kBottom + 16,
        std::abs(x) < 1e-9 ? 0.0 : x);
  }
  for (double y = std::ceil(axes.y0 / step_y) * step_y; y <= axes.y1; y += step_y) {
    svg += fmt::format(
        "<line x1='{1:.1f}' x2='{2:.1f}' y1='{0:.1f}' y2='{0:.1f}' stroke='var(--line)'/><text x='{3:.1f}' y='{4:.1f}' "
        "text-anchor='end'>{5:g}</text>",
        axes.v(y), Axes::kLeft, axes.width - Axes::kRight, Axes::kLeft - 6, axes.v(y) + 4,
        std::abs(y) < 1e-9 ? 0.0 : y);
  }
  svg += fmt::format("<text x='{:.0f}' y='{:.0f}' text-anchor='end'>{}</text>", axes.width - Axes::kRight,
                     axes.height - 8, escape(x_label));
  svg += fmt::format("<text x='14' y='{0:.0f}' transform='rotate(-90 14 {0:.0f})' text-anchor='middle'>{1}</text>",
                     axes.height / 2, escape(y_label));
  return svg;
}

}  // namespace

std::string escape(const std::string& text) {
  std::string safe;
  for (const char c : text) {
    if (c == '<')
      safe += "&lt;";
    else if (c == '>')
      safe += "&gt;";
    else if (c == '&')
      safe += "&amp;";
    else if (c == '"')
      safe += "&quot;";
    else
      safe += c;
  }
  return safe;
}

cv::Mat3b colour(const cv::Mat1f& values, double least, double most) {
  cv::Mat1b levels;
  values.convertTo(levels, CV_8U, 255.0 / (most - least), -255.0 * least / (most - least));
  cv::Mat3b colours;
  cv::applyColorMap(levels, colours, cv::COLORMAP_TURBO);
  colours.setTo(cv::Vec3b(96, 96, 96), values <= 0);
  return colours;
}

void Page::section(const std::string& heading, const std::string& text) {
  body_ += fmt::format("<h2>{}</h2>\n", escape(heading));
  if (!text.empty()) body_ += fmt::format("<p>{}</p>\n", escape(text));
}

void Page::figures(const std::vector<Figure>& figures) {
  body_ += "<div class='figures'>";
  for (const Figure& f : figures) {
    body_ += fmt::format("<div class='figure'><span>{}</span><b>{}</b><i>{}</i></div>", escape(f.name), escape(f.value),
                         escape(f.remark));
  }
  body_ += "</div>\n";
}

void Page::pictures(const std::vector<std::pair<cv::Mat, std::string>>& pictures) {
  body_ += "<div class='pictures'>";
  for (const auto& [picture, caption] : pictures) {
    body_ += fmt::format("<figure><img alt=\"{0}\" src='{1}'><figcaption>{0}</figcaption></figure>", escape(caption),
                         png_url(picture));
  }
  body_ += "</div>\n";
}

void Page::film(const std::vector<cv::Mat>& frames, double seconds, const std::string& caption) {
  if (frames.empty()) return;
  cv::Mat strip;
  cv::hconcat(frames, strip);
  body_ += fmt::format(
      "<div class='pictures'><figure><div class='film' role='img' aria-label=\"{0}\" style=\"aspect-ratio:{1}/{2};"
      "background-image:url('{3}');background-size:{4}% 100%;animation-duration:{5}s;"
      "animation-timing-function:steps({6},jump-none)\"></div><figcaption>{0}</figcaption></figure></div>\n",
      escape(caption), frames.front().cols, frames.front().rows, png_url(strip), 100 * frames.size(), seconds,
      std::max<std::size_t>(2, frames.size()));
}

void Page::plot(const std::vector<Curve>& curves, const std::string& x_label, const std::string& y_label,
                bool equal_axes) {
  const Axes axes = fit_axes(curves, equal_axes);
  body_ += "<div class='legend'>";
  for (const Curve& curve : curves) {
    if (curve.name.empty()) continue;
    body_ += fmt::format("<span><i style='background:{}'></i>{}</span>", curve.color, escape(curve.name));
  }
  body_ += fmt::format("</div><svg viewBox='0 0 {:.0f} {:.0f}' role='img'>", axes.width, axes.height);
  body_ += draw_grid(axes, x_label, y_label);
  for (const Curve& curve : curves) {
    std::string points;
    for (const auto& [x, y] : curve.points) points += fmt::format("{:.1f},{:.1f} ", axes.u(x), axes.v(y));
    body_ += fmt::format("<polyline points='{}' fill='none' stroke='{}' stroke-width='2.2' stroke-linejoin='round'/>",
                         points, curve.color);
  }
  body_ += "</svg>\n";
}

void Page::table(const std::vector<std::string>& head, const std::vector<std::vector<std::string>>& rows) {
  body_ += "<table><thead><tr>";
  for (const auto& cell : head) body_ += fmt::format("<th>{}</th>", escape(cell));
  body_ += "</tr></thead><tbody>";
  for (const auto& row : rows) {
    body_ += "<tr>";
    for (const auto& cell : row) body_ += fmt::format("<td>{}</td>", escape(cell));
    body_ += "</tr>";
  }
  body_ += "</tbody></table>\n";
}

void Page::list(const std::vector<std::string>& items) {
  body_ += "<ul>";
  for (const auto& item : items) body_ += fmt::format("<li>{}</li>", escape(item));
  body_ += "</ul>\n";
}

void Page::write(const std::filesystem::path& folder) const {
  std::filesystem::create_directories(folder);
  atomic_write(
      folder / "report.html",
      fmt::format(
          "<!doctype html><html lang='en'><head><meta charset='utf-8'><meta name='viewport' "
          "content='width=device-width'>"
          "<title>{0}</title><style>{1}</style></head><body><main><h1>{0}</h1><p>{2}</p>\n{3}</main></body></html>\n",
          escape(title_), kStyle, escape(subtitle_), body_));
}

}  // namespace arpent::report
