#include "describe_command.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "base/say.hpp"
#include "measures/drivers.hpp"
#include "new_case.hpp"
#include "repository.hpp"
#include "revision.hpp"

namespace veriflex {

namespace {

namespace fs = std::filesystem;

// The file that standard output goes to has the name that its case must have.
std::string id_of_output() {
  std::error_code unknown;
  const fs::path output = fs::read_symlink("/proc/self/fd/1", unknown);
  return !unknown && output.extension() == ".toml" ? output.stem().string() : "mine";
}

// Commands that are shown, in the order of --help.
std::vector<const CLI::App*> commands_of(const CLI::App& app) {
  std::vector<const CLI::App*> all;
  for (const CLI::App* command : app.get_subcommands(nullptr)) {
    if (!command->get_group().empty()) all.push_back(command);
  }
  return all;
}

bool takes_cases(const CLI::App& command) {
  const std::vector<const CLI::Option*> options = command.get_options();
  return std::any_of(options.begin(), options.end(),
                     [](const CLI::Option* option) { return option->get_name() == "case"; });
}

std::vector<std::string> words_of(const CLI::App& command) {
  std::vector<std::string> words;
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& name : option->get_lnames()) words.push_back("--" + name);
    for (const std::string& name : option->get_snames()) words.push_back("-" + name);
  }
  return words;
}

// The values that an option takes, where they are a list: CLI11 writes it into the type, `TEXT:{a,b}`.
std::string values_of(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const std::size_t open = type.find('{'), close = type.find('}');
  if (open == std::string::npos || close == std::string::npos) return "";
  std::string values = type.substr(open + 1, close - open - 1);
  std::replace(values.begin(), values.end(), ',', ' ');
  return values;
}

// Options complete by name, their values where they are a list, cases by id and by file.
void print_bash(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : commands_of(app)) names.push_back(command->get_name());
  say("# bash completion of veriflex: source it, or put it into\n"
      "# ~/.local/share/bash-completion/completions/veriflex\n"
      "_veriflex() {{\n"
      "  local now=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD-1]}} words= cases=\n"
      "  if [ \"$COMP_CWORD\" = 1 ]; then\n"
      "    COMPREPLY=($(compgen -W \"{} --help --version\" -- \"$now\"))\n"
      "    return\n"
      "  fi\n"
      "  case ${{COMP_WORDS[1]}} in\n",
      fmt::join(names, " "));
  for (const CLI::App* command : commands_of(app)) {
    say("    {}) words='{}'{} ;;\n", command->get_name(), fmt::join(words_of(*command), " "),
        takes_cases(*command) ? " cases=yes" : "");
  }
  say("  esac\n"
      "  case ${{COMP_WORDS[1]}}$before in\n");
  for (const CLI::App* command : commands_of(app)) {
    for (const CLI::Option* option : command->get_options()) {
      const std::string values = values_of(*option);
      if (values.empty() || option->get_lnames().empty()) continue;
      say("    {}--{}) COMPREPLY=($(compgen -W '{}' -- \"$now\")); return ;;\n", command->get_name(),
          option->get_lnames().front(), values);
    }
  }
  say("  esac\n"
      "  [ -z \"$cases\" ] || cases=$(\"${{COMP_WORDS[0]}}\" list 2>/dev/null | cut -d' ' -f1)\n"
      "  [[ $now == -* ]] || words=$cases\n"
      "  COMPREPLY=($(compgen -W \"$words\" -- \"$now\"))\n"
      "}}\n"
      "complete -o default -F _veriflex veriflex\n");
}

// Text as troff has it.
std::string troff(const std::string& text) {
  std::string safe;
  bool begins_line = true;
  for (const char c : text) {
    if (begins_line && (c == '.' || c == '\'')) safe += "\\&";
    begins_line = c == '\n';
    if (c == '\\') {
      safe += "\\e";
    } else if (c == '-') {
      safe += "\\-";
    } else {
      safe += c;
    }
  }
  return safe;
}

void print_options(const CLI::App& command) {
  for (const CLI::Option* option : command.get_options()) {
    if (option->get_group().empty()) continue;
    std::string names = option->get_name(true, true);
    if (option->get_items_expected_max() > 0 && !option->get_lnames().empty())
      names += " " + option->get_type_name();
    say(".TP\n.B {}\n{}\n", troff(names), troff(option->get_description()));
  }
}

void print_manual(const CLI::App& app) {
  say(".TH VERIFLEX 1 \"\" \"veriflex {}\" \"User Commands\"\n"
      ".SH NAME\nveriflex \\- {}\n"
      ".SH SYNOPSIS\n.B veriflex\n.I command\n[options]\n"
      ".SH DESCRIPTION\n"
      "Cases are TOML files that ask one question each; a run writes a result file with its verdict.\n"
      "{}\n.SH COMMANDS\n",
      build::version, troff(app.get_description()), troff(app.get_footer()));
  for (const CLI::App* command : commands_of(app)) {
    say(".SS {}\n{}.\n", troff(command->get_name()), troff(command->get_description()));
    print_options(*command);
    if (!command->get_footer().empty()) say(".PP\n.nf\n{}\n.fi\n", troff(command->get_footer()));
  }
  say(".SH FILES\n.TP\n.I {}\ncases, references, and README.md with the keys of a case\n"
      ".TP\n.I $XDG_CACHE_HOME/veriflex\nrates of this machine and figures of reports, both made anew when "
      "they are gone\n",
      troff("share/veriflex"));
}

}  // namespace

// The driver meant by a word of its name alone, "wave" for "plane-wave"; what is given, where none or several
// have it.
std::string driver_by_word(const std::vector<std::string>& drivers, const std::string& given) {
  std::vector<std::string> found;
  for (const std::string& name : drivers) {
    if (name == given) return given;
    if (("-" + name + "-").find("-" + given + "-") != std::string::npos) found.push_back(name);
  }
  return found.size() == 1 ? found.front() : given;
}

void add_new_command(CLI::App& app) {
  struct Words {
    std::string driver, id;
  };
  const auto words = std::make_shared<Words>();
  std::vector<std::string> drivers;
  for (const engine::Driver& driver : measures::all()) drivers.push_back(driver.name);
  CLI::App* command =
      app.add_subcommand("new", "print a case of a driver, with comments, that runs as it stands");
  command
      ->add_option("--driver", words->driver,
                   "the kind of study; a word that one of them alone has is enough")
      ->required()
      ->check(CLI::IsMember(drivers))
      ->transform([drivers](const std::string& given) { return driver_by_word(drivers, given); });
  command->add_option("id", words->id, "its name (default: that of the file it is written to)");
  command->footer("Example: veriflex new --driver tensile > mine.toml; veriflex run mine.toml");
  command->callback([words] {
    const std::string id = words->id.empty() ? id_of_output() : words->id;
    say("{}", new_case(words->driver, id, repository::cases()));
  });
}

void add_describing_commands(CLI::App& app) {
  CLI::App* completion = app.add_subcommand("completion", "print completion for a shell");
  completion->add_option("shell")->description("which")->required()->check(CLI::IsMember({"bash"}));
  completion->footer("Example: . <(veriflex completion bash)");
  completion->callback([&app] { print_bash(app); });

  CLI::App* manual = app.add_subcommand("manual", "print the manual page");
  manual->group("");  // not shown: it is installed as a page
  manual->callback([&app] { print_manual(app); });
}

}  // namespace veriflex
