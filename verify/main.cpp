/// The `veriflex` command.
#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <filesystem>
#include <iostream>
#include <new>
#include <system_error>

#include "advise_command.hpp"
#include "audit_command.hpp"
#include "base/error.hpp"
#include "base/say.hpp"
#include "case_commands.hpp"
#include "claims_command.hpp"
#include "contract_commands.hpp"
#include "describe_command.hpp"
#include "diff_command.hpp"
#include "engine/renamed.hpp"
#include "engine/result.hpp"
#include "exit_code.hpp"
#include "law_commands.hpp"
#include "revision.hpp"
#include "show_command.hpp"
#include "study_commands.hpp"
#include "threads.hpp"
#include "units_command.hpp"

namespace exit_code = veriflex::exit_code;

namespace {

// What the words that CLI11 did not expect may be misspellings of: a command, or an option of the command
// given.
std::string suggestion(const CLI::App& app) {
  const std::vector<CLI::App*> given = app.get_subcommands();
  const CLI::App& asked = given.empty() ? app : *given.front();
  std::vector<std::string> known;
  for (const CLI::Option* option : asked.get_options()) {
    for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
  }
  for (const CLI::App* command : asked.get_subcommands(nullptr)) known.push_back(command->get_name());
  for (const std::string& word : app.remaining(true)) {
    if (const auto now = veriflex::engine::present_option(word)) {
      return fmt::format("'{}' is now '{}'", word, *now);
    }
    const std::string near = veriflex::nearest_name(word.substr(0, word.find('=')), known);
    if (!near.empty()) return fmt::format("'{}' is not known. Did you mean '{}'?", word, near);
  }
  return fmt::format("See veriflex {}--help", given.empty() ? "" : asked.get_name() + " ");
}

// A stream that was closed by the caller would give its number to the next file, which then got its words.
void occupy_standard_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    // Open for reading only, so that what cannot be said is noticed.
    while (fcntl(stream, F_GETFD) < 0 && open("/dev/null", O_RDONLY) >= 0) continue;
  }
}

// The exit code of a command that ends with `code`, when what it said has reached its reader.
int said(int code) {
  std::cout.flush();
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0 && !std::cout.bad()) return code;
  veriflex::complain("standard output: cannot be written ({}). Make room there, or leave its reader open",
                     std::strerror(errno));
  return exit_code::first_of(code, exit_code::output);
}

int run(int argc, char** argv) {
  CLI::App app("Verification of elastic bodies in lattice Boltzmann flow", "veriflex");
  app.set_version_flag("--version",
                       fmt::format("veriflex {} ({})", veriflex::build::version, veriflex::build::revision));
  app.require_subcommand(1);
  app.footer(
      "Exit codes: 0 all checks passed, 1 a check failed, 2 bad input, 3 a run left its validity or was "
      "interrupted, 4 output failed, 5 (of run) a case was skipped: this program was built without what it "
      "needs.\n"
      "Example: veriflex verify --tier quick");
  int code = exit_code::success;
  veriflex::add_case_commands(app, code);
  veriflex::add_study_commands(app, code);
  veriflex::add_advise_command(app, code);
  veriflex::add_claims_command(app, code);
  veriflex::add_contract_commands(app, code);
  veriflex::add_units_command(app);
  veriflex::add_show_command(app);
  veriflex::add_new_command(app);
  veriflex::add_diff_command(app, code);
  veriflex::add_audit_command(app, code);
  veriflex::add_derive_command(app);
  veriflex::add_calibrate_command(app);
  veriflex::add_describing_commands(app);
  try {
    app.parse(argc, argv);
    return code;
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
    veriflex::complain("command line: {}. {}", error.what(), suggestion(app));
    return exit_code::input;
  }
}

// The exit code of the command, whatever it ended by.
int ended(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::system_error& error) {
    // fmt::print could not write; of other kinds are only file names, which are the user's.
    const bool is_name = dynamic_cast<const std::filesystem::filesystem_error*>(&error) != nullptr;
    veriflex::complain("{}: {}", is_name ? "file name" : "standard output", error.what());
    return is_name ? exit_code::input : exit_code::output;
  } catch (...) {
    const veriflex::engine::Failure why = veriflex::engine::current_failure();
    veriflex::complain("{}", why.message);
    return exit_code::of_error(why.kind);
  }
}

bool has_ended = false;

// A library that ends the program (OpenMP without a thread does) does so with code 1, which is a failed
// check.
void say_who_ended() {
  if (has_ended) return;
  if (veriflex::gives_up_team())
    veriflex::complain("no memory for a team of threads. Give it more, or fewer --threads");
  else
    veriflex::complain(
        "a library ended the program, see above. Give it more threads or memory, or fewer --threads");
  std::_Exit(exit_code::numerical);
}

// Where no exception may pass (in a thread of OpenMP, in some functions of libraries), lack of memory ends
// the program all the same, with its name as far as it is known.
[[noreturn]] void end_without_memory() {
  const char* words =
      "veriflex: a library ended the program, most likely out of memory. Use a smaller scene (see veriflex "
      "plan)\n";
  try {
    if (std::current_exception()) throw;
  } catch (const std::bad_alloc&) {
    words = "veriflex: out of memory. Use a smaller scene (see veriflex plan)\n";
  } catch (...) {
    std::abort();
  }
  std::fputs(words, stderr);
  std::_Exit(exit_code::numerical);
}

}  // namespace

int main(int argc, char** argv) {
  std::atexit(say_who_ended);
  std::set_terminate(end_without_memory);
  occupy_standard_streams();
  // Both would end the program in the middle of a run: without them, writing fails and says so.
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
  const int code = said(ended(argc, argv));
  has_ended = true;
  return code;
}
