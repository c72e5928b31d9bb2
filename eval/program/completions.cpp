// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "eval/program/command_pages.h"

namespace sightline {
namespace {

std::string words(const std::vector<std::string>& list) {
  return fmt::to_string(fmt::join(list, " "));
}

std::vector<std::string> option_names(const CommandPage& command) {
  std::vector<std::string> names;
  for (const OptionPage& option : command.options) {
    names.insert(names.end(), option.names.begin(), option.names.end());
  }
  return names;
}

// Of a positional argument that may be one of the program's own: the list that knows its names.
std::string list_of(const CommandPage& command) {
  if (command.positionals.empty()) return {};
  const std::string& name = command.positionals.front().names.front();
  if (command.name == "study") return "studies";
  if (name == "target" || name == "mesh" || command.name == "render") return "targets";
  return {};
}

// A text within single quotes of a shell.
std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) {
    if (c == '\'') {
      out += "'\\''";
    } else {
      out += c == '\n' ? ' ' : c;
    }
  }
  return out + "'";
}

// The same for a description of zsh's, in which brackets and colons divide.
std::string zsh_text(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '[' || c == ']' || c == ':' || c == '\\') out += '\\';
    out += c;
  }
  return out;
}

std::string zsh_value(const OptionPage& option) {
  if (option.value.empty()) return {};
  if (!option.choices.empty()) return fmt::format(":value:({})", words(option.choices));
  return fmt::format(":{}:_files", option.value);
}

}  // namespace

std::string bash_completions(const std::vector<CommandPage>& commands) {
  std::vector<std::string> names;
  std::string values, cases;
  for (const CommandPage& command : commands) {
    names.push_back(command.name);
    for (const OptionPage& option : command.options) {
      if (option.choices.empty()) continue;
      for (const std::string& name : option.names) {
        values +=
            fmt::format("    '{} {}') words='{}' ;;\n", command.name, name, words(option.choices));
      }
    }
    cases += fmt::format("      {}) words='{}'; list='{}' ;;\n", command.name,
                         words(option_names(command)), list_of(command));
  }
  return fmt::format(
      R"sh(# bash completion for sightline, as `sightline completions bash` prints it
_sightline() {{
  local current=${{COMP_WORDS[COMP_CWORD]}} previous=${{COMP_WORDS[COMP_CWORD - 1]}} words='' list=''
  COMPREPLY=()
  if [ "$COMP_CWORD" = 1 ]; then
    mapfile -t COMPREPLY < <(compgen -W '{} --help --version' -- "$current")
    return
  fi
  case "${{COMP_WORDS[1]}} $previous" in
{}  esac
  if [ -z "$words" ]; then
    case "${{COMP_WORDS[1]}}" in
{}    esac
    if [[ $current != -* ]]; then
      words=''
      # The entries of a list are indented; its title is not.
      [ -z "$list" ] || words=$(sightline list "$list" 2>/dev/null | sed -n 's/^  \([^ ]*\).*/\1/p')
    fi
  fi
  mapfile -t COMPREPLY < <(compgen -W "$words" -- "$current")
}}
complete -o bashdefault -o default -F _sightline sightline
)sh",
      words(names), values, cases);
}

std::string zsh_completions(const std::vector<CommandPage>& commands) {
  std::string names, cases;
  for (const CommandPage& command : commands) {
    names += fmt::format("    {}\n", quoted(fmt::format("{}:{}", command.name, command.text)));
    cases += fmt::format("    {})\n      _arguments", command.name);
    for (const OptionPage& option : command.options) {
      for (const std::string& name : option.names) {
        cases += fmt::format(
            " \\\n        {}",
            quoted(fmt::format("*{}[{}]{}", name, zsh_text(option.text), zsh_value(option))));
      }
    }
    const std::string list = list_of(command);
    cases += list.empty() ? " \\\n        '*:file:_files' ;;\n"
                          : fmt::format(" \\\n        '*:{}:_sightline_names {}' ;;\n", list, list);
  }
  return fmt::format(R"sh(#compdef sightline
# zsh completion for sightline, as `sightline completions zsh` prints it
_sightline_names() {{
  local -a names
  names=(${{(f)"$(sightline list $1 2>/dev/null | sed -n 's/^  \([^ ]*\).*/\1/p')"}})
  compadd -a names
  _files
}}
_sightline() {{
  local -a commands
  commands=(
{}  )
  if (( CURRENT == 2 )); then
    _describe 'command' commands
    return
  fi
  local command=$words[2]
  shift words
  (( CURRENT -= 1 ))
  case $command in
{}  esac
}}
_sightline "$@"
)sh",
                     names, cases);
}

std::string fish_completions(const std::vector<CommandPage>& commands) {
  std::string out =
      "# fish completion for sightline, as `sightline completions fish` prints it\n"
      "complete -c sightline -n __fish_use_subcommand -l help -s h -d 'Print help'\n"
      "complete -c sightline -n __fish_use_subcommand -l version -d 'Print the version'\n";
  for (const CommandPage& command : commands) {
    out += fmt::format("complete -c sightline -f -n __fish_use_subcommand -a {} -d {}\n",
                       command.name, quoted(command.text));
    const std::string here =
        fmt::format("complete -c sightline -n '__fish_seen_subcommand_from {}'", command.name);
    if (const std::string list = list_of(command); !list.empty()) {
      out += fmt::format(
          "{} -a \"(sightline list {} 2>/dev/null | string match -r '^  \\S+' | string trim)\"\n",
          here, list);
    }
    for (const OptionPage& option : command.options) {
      std::string names;
      for (const std::string& name : option.names) {
        names += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
      }
      std::string value;
      if (!option.value.empty()) value = " -r";
      if (!option.choices.empty()) value = fmt::format(" -x -a '{}'", words(option.choices));
      out += fmt::format("{}{}{} -d {}\n", here, names, value, quoted(option.text));
    }
  }
  return out;
}

}  // namespace sightline
