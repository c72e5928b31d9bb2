// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/program/command_pages.h"

#include <algorithm>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sightline {
namespace {

// "TEXT:{none,auto}" of a type's name; what else a type may say ("INT in [1 - 1024]") is no choice.
std::vector<std::string> choices_in(const std::string& type) {
  const size_t begin = type.find(":{");
  if (begin == std::string::npos || type.back() != '}') return {};
  return CLI::detail::split(type.substr(begin + 2, type.size() - begin - 3), ',');
}

OptionPage option_page(const CLI::Option& option) {
  OptionPage page;
  if (option.get_positional()) page.names.push_back(option.get_name(true));
  for (const std::string& name : option.get_lnames()) page.names.push_back("--" + name);
  for (const std::string& name : option.get_snames()) page.names.push_back("-" + name);
  const std::string type = option.get_type_name();
  if (option.get_items_expected_max() > 0) page.value = type.substr(0, type.find(':'));
  page.text = option.get_description();
  page.choices = choices_in(type);
  page.standard = option.get_default_str();
  page.is_required = option.get_required();
  return page;
}

CommandPage command_page(const CLI::App& command) {
  CommandPage page{command.get_name(), command.get_description(), {}, {}};
  for (const CLI::Option* option : command.get_options()) {
    if (option->get_group().empty()) continue;  // hidden
    auto& list = option->get_positional() ? page.positionals : page.options;
    list.push_back(option_page(*option));
  }
  return page;
}

// A text for groff: backslashes and hyphens escaped (a plain hyphen would be set as a dash, which
// nobody can copy to a shell), and no line that begins like a request.
std::string roff(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '\\') {
      out += "\\e";
    } else if (c == '-') {
      out += "\\-";
    } else {
      out += c;
    }
  }
  const bool is_request = out.starts_with('.') || out.starts_with('\'');
  return is_request ? "\\&" + out : out;
}

std::string usage_of(const OptionPage& positional) {
  const std::string name = "\\fI" + roff(positional.names.front()) + "\\fR";
  return positional.is_required ? name : "[" + name + "]";
}

std::string entry_of(const OptionPage& option) {
  std::vector<std::string> names;
  for (const std::string& name : option.names) names.push_back("\\fB" + roff(name) + "\\fR");
  std::string head = fmt::to_string(fmt::join(names, ", "));
  if (!option.value.empty()) head += " \\fI" + roff(option.value) + "\\fR";
  std::string text = roff(option.text);
  if (!option.choices.empty()) {
    text +=
        fmt::format("\n.br\nOne of: {}.", roff(fmt::to_string(fmt::join(option.choices, ", "))));
  }
  if (!option.standard.empty()) text += fmt::format("\n.br\nDefault: {}.", roff(option.standard));
  return fmt::format(".TP\n{}\n{}\n", head, text);
}

std::string head_of(const std::string& title, const std::string& text) {
  return fmt::format(".TH {} 1 \"\" \"Sightline {}\" \"Sightline\"\n.SH NAME\n{} \\- {}\n", title,
                     SIGHTLINE_VERSION, roff(title), roff(text));
}

constexpr const char* kExitCodes =
    ".SH EXIT STATUS\n0 good; 1 an input that cannot be used, which one line on standard error "
    "names; 2 a command line that cannot be read; 3 \\fBcompare\\fR found a regression, or "
    "\\fBscore\\fR a figure that is not as required; 4 some trials could not be run; 130 "
    "interrupted.\n";

}  // namespace

std::vector<CommandPage> command_pages(const CLI::App& app) {
  std::vector<CommandPage> pages;
  for (const CLI::App* command :
       app.get_subcommands([](const CLI::App* sub) { return !sub->get_group().empty(); })) {
    pages.push_back(command_page(*command));
  }
  return pages;
}

std::string manual_page(const CommandPage& command) {
  std::string text = head_of("sightline-" + command.name, command.text);
  text += fmt::format(".SH SYNOPSIS\n\\fBsightline {}\\fR [\\fIoptions\\fR]", command.name);
  for (const OptionPage& positional : command.positionals) text += " " + usage_of(positional);
  text += "\n";
  if (!command.positionals.empty()) text += ".SH ARGUMENTS\n";
  for (const OptionPage& positional : command.positionals) text += entry_of(positional);
  text += ".SH OPTIONS\n";
  for (const OptionPage& option : command.options) text += entry_of(option);
  return text + kExitCodes + ".SH SEE ALSO\n\\fBsightline\\fR(1)\n";
}

std::string manual_page(const std::vector<CommandPage>& commands) {
  std::string text =
      head_of("sightline", "render targets, estimate their pose, measure every step");
  text +=
      ".SH SYNOPSIS\n\\fBsightline\\fR \\fIcommand\\fR [\\fIoptions\\fR]\n"
      ".SH DESCRIPTION\nSightline renders meshed targets under known poses, extracts features from "
      "the images, estimates the six\\-degree\\-of\\-freedom pose from them, and measures every "
      "step against the ground truth and against the Cramer\\-Rao bound.\n"
      ".PP\nBegin with \\fBsightline demo\\fR, then \\fBsightline list\\fR.\n.SH COMMANDS\n";
  for (const CommandPage& command : commands) {
    text += fmt::format(".TP\n\\fBsightline\\-{}\\fR(1)\n{}\n", command.name, roff(command.text));
  }
  text += kExitCodes;
  text +=
      ".SH ENVIRONMENT\n.TP\n\\fBSIGHTLINE_ASSETS\\fR\nThe folder of the targets and studies that "
      "are called by name, instead of the installed one.\n"
      ".SH SEE ALSO\n";
  std::vector<std::string> pages;
  for (const CommandPage& command : commands) {
    pages.push_back(fmt::format("\\fBsightline\\-{}\\fR(1)", command.name));
  }
  return text + fmt::format("{}\n", fmt::join(pages, ", "));
}

}  // namespace sightline
