// SPDX-License-Identifier: MIT
// Names for the members of option structs, so that a settings file, the command line and the printed settings
// share one list. In: TOML text or `key=value`. Out: the bound members, or every problem found at once.
// Thread: set-up only. Allocates. toml++ throws inside; nothing leaves this file but problems as text.
#pragma once
#include <functional>
#include <initializer_list>
#include <limits>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace loopsift {

/// An enum member seen by the names of its values.
struct EnumMember {
  std::vector<std::string> names;
  std::function<std::string()> get;
  std::function<void(const std::string& name)> set;  ///< only with one of `names`
};

/// Binds `member` to the given name of each of its values.
template <class E>
[[nodiscard]] EnumMember by_name(E* member, std::initializer_list<std::pair<const char*, E>> values) {
  const std::vector<std::pair<std::string, E>> table(values.begin(), values.end());
  EnumMember bound;
  for (const auto& [name, value] : table) bound.names.push_back(name);
  bound.get = [member, table] {
    for (const auto& [name, value] : table)
      if (value == *member) return name;
    return std::string();
  };
  bound.set = [member, table](const std::string& wanted) {
    for (const auto& [name, value] : table)
      if (name == wanted) *member = value;
  };
  return bound;
}

/// Closed interval that a number must lie in; without meaning for other types.
struct OptionRange {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
};

/// One key. The member must outlive the table.
struct Option {
  std::string key;
  std::variant<bool*, int*, float*, double*, std::string*, std::vector<std::string>*, EnumMember> member;
  std::string comment;  ///< one line, for a person
  OptionRange range{};
};

/// One TOML table; the name may be dotted ("odometry.icp").
struct OptionSection {
  std::string name;
  std::string comment;
  std::vector<Option> options;
};
using OptionTable = std::vector<OptionSection>;

/// Sets the bound members from a TOML file. Appends a line `FILE:LINE: KEY: what is wrong` for every unknown
/// key (with the nearest valid one), wrong type and value out of range; a syntax error or an unreadable file
/// is a single one. False when anything was appended; members named in no problem are set all the same.
bool read_toml_file(const std::string& path, const OptionTable& table, std::vector<std::string>* problems);

/// Sets one member from `section.key=value` as the command line gives it; strings and names need no quotes.
bool assign(const std::string& assignment, const OptionTable& table, std::vector<std::string>* problems);

/// The table as TOML with every key, its comment, range and present value. Reading it back gives equal
/// values.
[[nodiscard]] std::string to_toml(const OptionTable& table);

}  // namespace loopsift
