// SPDX-License-Identifier: MIT
#include "firmware_app/option_table.hpp"

#include <toml++/toml.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <numeric>
#include <optional>
#include <sstream>

namespace loopsift {
namespace {

std::string format_number(double value) {
  char text[400];  // the largest double has 309 digits
  const auto end = std::to_chars(text, text + sizeof text, value, std::chars_format::fixed);
  return {text, end.ptr};
}

std::string describe(const OptionRange& range) {
  if (std::isinf(range.min) && std::isinf(range.max)) return "";
  if (std::isinf(range.max)) return "at least " + format_number(range.min);
  if (std::isinf(range.min)) return "at most " + format_number(range.max);
  return format_number(range.min) + " to " + format_number(range.max);
}

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "\"" : ", \"") + name + "\"";
  return text;
}

/// Levenshtein distance.
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0]++;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
    }
  }
  return row[b.size()];
}

bool is_section_or_parent(const std::string& path, const OptionTable& table) {
  return std::any_of(table.begin(), table.end(), [&](const OptionSection& section) {
    return section.name == path || section.name.compare(0, path.size() + 1, path + ".") == 0;
  });
}

/// The valid key most like `path`; an unknown section counts little beside a key that fits.
std::string nearest_key(const std::string& path, const OptionTable& table) {
  const std::size_t dot = path.rfind('.');
  const std::string key = path.substr(dot + 1);  // npos + 1 is 0
  const std::string section_name = dot == std::string::npos ? "" : path.substr(0, dot);
  const double section_weight = is_section_or_parent(section_name, table) ? 1.0 : 0.1;
  std::string best;
  double best_distance = std::numeric_limits<double>::infinity();
  for (const OptionSection& section : table)
    for (const Option& option : section.options) {
      const double distance = static_cast<double>(edit_distance(key, option.key)) +
                              section_weight * static_cast<double>(edit_distance(section_name, section.name));
      if (distance >= best_distance) continue;
      best_distance = distance;
      best = section.name + "." + option.key;
    }
  return best;
}

const Option* find_option(const std::string& path, const OptionTable& table) {
  for (const OptionSection& section : table)
    for (const Option& option : section.options)
      if (section.name + "." + option.key == path) return &option;
  return nullptr;
}

/// What is wrong with a value for an option; empty when it was set.
struct SetMember {
  const toml::node& node;
  const OptionRange& range;

  std::string operator()(bool* member) const {
    const auto value = node.value_exact<bool>();
    if (!value) return "expected true or false";
    *member = *value;
    return "";
  }
  std::string operator()(int* member) const {
    const auto value = node.value_exact<std::int64_t>();
    if (!value) return "expected a whole number";
    if (*value < std::numeric_limits<int>::min() || *value > std::numeric_limits<int>::max())
      return "is too large a number";
    if (std::string wrong = out_of_range(static_cast<double>(*value)); !wrong.empty()) return wrong;
    *member = static_cast<int>(*value);
    return "";
  }
  template <class Real>
  std::string set_real(Real* member) const {
    if (!node.is_number()) return "expected a number";
    const double value = *node.value<double>();
    if (!std::isfinite(static_cast<Real>(value))) return "expected a finite number";
    if (std::string wrong = out_of_range(value); !wrong.empty()) return wrong;
    *member = static_cast<Real>(value);
    return "";
  }
  std::string operator()(float* member) const { return set_real(member); }
  std::string operator()(double* member) const { return set_real(member); }
  std::string operator()(std::string* member) const {
    const auto value = node.value_exact<std::string>();
    if (!value) return "expected a string in quotes";
    *member = *value;
    return "";
  }
  std::string operator()(std::vector<std::string>* member) const {
    const toml::array* list = node.as_array();
    if (list == nullptr || (!list->empty() && !list->is_homogeneous(toml::node_type::string)))
      return "expected a list of strings, as in [\"a\", \"b\"]";
    member->clear();
    for (const toml::node& element : *list) member->push_back(*element.value_exact<std::string>());
    return "";
  }
  std::string operator()(const EnumMember& member) const {
    const auto value = node.value_exact<std::string>();
    if (!value || std::find(member.names.begin(), member.names.end(), *value) == member.names.end())
      return "expected one of " + joined(member.names);
    member.set(*value);
    return "";
  }
  std::string out_of_range(double value) const {
    if (value >= range.min && value <= range.max) return "";
    return format_number(value) + " is out of range: " + describe(range);
  }
};

void set_option(const std::string& where, const std::string& path, const toml::node& node,
                const OptionTable& table, std::vector<std::string>* problems) {
  const Option* option = find_option(path, table);
  if (option == nullptr) {
    problems->push_back(where + ": " + path + ": there is no such key; the nearest is " +
                        nearest_key(path, table));
    return;
  }
  const std::string wrong = std::visit(SetMember{node, option->range}, option->member);
  if (!wrong.empty()) problems->push_back(where + ": " + path + ": " + wrong);
}

void set_from_table(const std::string& file, const std::string& prefix, const toml::table& values,
                    const OptionTable& table, std::vector<std::string>* problems) {
  for (const auto& [key, node] : values) {
    const std::string path = prefix + std::string(key.str());
    const std::string where = file + ":" + std::to_string(key.source().begin.line);
    if (node.is_table() && (!node.as_table()->empty() || is_section_or_parent(path, table))) {
      set_from_table(file, path + ".", *node.as_table(), table, problems);
    } else {
      set_option(where, path, node, table, problems);
    }
  }
}

/// `text` as a TOML value; nothing when it is none.
std::optional<toml::table> parse_value(const std::string& text) {
  try {
    return toml::parse("value = " + text);
  } catch (const toml::parse_error&) {
    return std::nullopt;
  }
}

/// A value as TOML.
struct FormatMember {
  std::string operator()(const bool* value) const { return *value ? "true" : "false"; }
  std::string operator()(const int* value) const { return std::to_string(*value); }
  std::string operator()(const float* value) const { return real(*value); }
  std::string operator()(const double* value) const { return real(*value); }
  std::string operator()(const std::string* value) const { return quoted(*value); }
  std::string operator()(const std::vector<std::string>* list) const {
    std::string text;
    for (const std::string& element : *list) text += (text.empty() ? "" : ", ") + quoted(element);
    return "[" + text + "]";
  }
  std::string operator()(const EnumMember& member) const { return quoted(member.get()); }

  /// The shortest text that reads back to the same number.
  template <class Real>
  static std::string real(Real value) {
    char text[48];
    const auto end = std::to_chars(text, text + sizeof text, value);
    const std::string shortest(text, end.ptr);
    return shortest.find_first_of(".e") == std::string::npos ? shortest + ".0" : shortest;
  }
  static std::string quoted(const std::string& value) {
    std::ostringstream text;
    const toml::value<std::string> node(value);
    text << toml::toml_formatter(node, toml::format_flags::none);
    return text.str();
  }
};

std::string format_comment(const Option& option) {
  const auto* member = std::get_if<EnumMember>(&option.member);
  const std::string allowed = member != nullptr ? joined(member->names) : describe(option.range);
  return "# " + option.comment + (allowed.empty() ? "" : " (" + allowed + ")") + "\n";
}

}  // namespace

bool read_toml_file(const std::string& path, const OptionTable& table, std::vector<std::string>* problems) {
  const std::size_t before = problems->size();
  std::ifstream file(path);
  std::error_code ignored;
  if (!file.is_open() || std::filesystem::is_directory(path, ignored)) {
    problems->push_back(path + ": cannot be read; name a settings file that exists");
    return false;
  }
  const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  try {
    set_from_table(path, "", toml::parse(text, path), table, problems);
  } catch (const toml::parse_error& error) {
    problems->push_back(path + ":" + std::to_string(error.source().begin.line) +
                        ": is not TOML: " + std::string(error.description()));
  }
  return problems->size() == before;
}

bool assign(const std::string& assignment, const OptionTable& table, std::vector<std::string>* problems) {
  const std::size_t before = problems->size();
  const std::string where = "--set " + assignment;
  const std::size_t equals = assignment.find('=');
  if (equals == std::string::npos || equals == 0) {
    problems->push_back(where + ": expected section.key=value");
    return false;
  }
  const std::string path = assignment.substr(0, equals), text = assignment.substr(equals + 1);
  const std::optional<toml::table> parsed = parse_value(text);
  const toml::value<std::string> literal(text);
  const Option* option = find_option(path, table);
  const bool wants_text = option != nullptr && (std::holds_alternative<std::string*>(option->member) ||
                                                std::holds_alternative<EnumMember>(option->member));
  const toml::node* node = parsed ? parsed->get("value") : nullptr;
  if (node == nullptr || (wants_text && !node->is_string())) node = &literal;
  set_option(where, path, *node, table, problems);
  return problems->size() == before;
}

std::string to_toml(const OptionTable& table) {
  std::string text;
  for (const OptionSection& section : table) {
    if (!text.empty()) text += "\n";
    text += "# " + section.comment + "\n[" + section.name + "]\n";
    for (const Option& option : section.options)
      text += format_comment(option) + option.key + " = " + std::visit(FormatMember{}, option.member) + "\n";
  }
  return text;
}

}  // namespace loopsift
