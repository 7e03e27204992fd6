// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// `./arpent certificate check DIR`: does what a mission says about the surface that it left hold in the true world?
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "common/atomic_file.h"
#include "common/error.h"
#include "tools/certificate/check.h"

namespace {

using namespace arpent;
using namespace arpent::tools;

constexpr std::size_t kShown = 20;

void print_false(const CertificateCheck& check) {
  std::size_t shown = 0;
  for (const CheckedElement& checked : check.elements) {
    if (checked.finding != Finding::kFalse) continue;
    if (++shown > kShown) continue;
    const auto& p = checked.element.place_m;
    fmt::print("  false: ({:.2f}, {:.2f}, {:.2f}) m {}: {}\n", p.x(), p.y(), p.z(),
               planning::to_text(checked.element.verdict), checked.remark);
  }
  if (shown > kShown) fmt::print("  and {} more\n", shown - kShown);
}

nlohmann::json rows_of(const CertificateCheck& check) {
  nlohmann::json rows = nlohmann::json::array();
  const auto add = [&](const char* name, double value, const char* unit) {
    rows.push_back({{"name", std::string("certificate.") + name}, {"value", value}, {"unit", unit}});
  };
  add("valid_percent", check.valid_percent(), "%");
  add("true_percent", check.true_percent(), "%");
  add("elements", static_cast<double>(check.elements.size()), "1");
  add("true", check.true_count, "1");
  add("moot", check.moot_count, "1");
  add("false", check.false_count, "1");
  add("unfinished", check.unfinished, "1");
  add("small_pieces", check.small_pieces, "1");
  add("uncovered_m2", check.uncovered_m2, "m2");
  add("in_contact_percent", check.in_contact_percent, "%");
  return rows;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Certificates of termination."};
  app.name("arpent certificate");
  std::string folder, world, json_file;
  auto* check = app.add_subcommand("check", "verify a mission's certificate against the true world");
  check->add_option("DIR", folder, "what ./arpent mission wrote")->required();
  check->add_option("--world", world, "world file instead of the one in the mission's log");
  check->add_option("--json", json_file, "write the figures as JSON");
  app.require_subcommand(1);
  try {
    app.parse(argc, argv);
    const CertificateCheck result = check_folder(folder, world);
    const nlohmann::json rows = rows_of(result);
    for (const auto& row : rows) {
      fmt::print("  {:32} {:.6g} {}\n", row["name"].get<std::string>(), row["value"].get<double>(),
                 row["unit"].get<std::string>());
    }
    print_false(result);
    if (!json_file.empty()) atomic_write(json_file, rows.dump(1) + "\n");
    return result.false_count == 0 ? 0 : 1;
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const InputError& error) {
    std::fprintf(stderr, "certificate: %s\n", error.what());
    return 2;
  }
}
