/// The `veriflex` command.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <new>

#include "base/error.hpp"
#include "case_commands.hpp"
#include "claims_command.hpp"
#include "contract_commands.hpp"
#include "exit_code.hpp"
#include "law_commands.hpp"
#include "revision.hpp"

namespace exit_code = veriflex::exit_code;

namespace {

int report_error(const std::exception& error, int code) {
  fmt::print(stderr, "veriflex: {}\n", error.what());
  return code;
}

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
    const std::string near = veriflex::nearest_name(word.substr(0, word.find('=')), known);
    if (!near.empty()) return fmt::format("'{}' is not known. Did you mean '{}'?", word, near);
  }
  return fmt::format("See veriflex {}--help", given.empty() ? "" : asked.get_name() + " ");
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Verification of elastic bodies in lattice Boltzmann flow", "veriflex");
  app.set_version_flag("--version",
                       fmt::format("veriflex {} ({})", veriflex::build::version, veriflex::build::revision));
  app.require_subcommand(1);
  app.footer(
      "Exit codes: 0 all checks passed, 1 a check failed, 2 bad input, 3 a run left its validity, 4 output "
      "failed.\n"
      "Example: veriflex verify --tier quick");
  int code = exit_code::success;
  veriflex::add_case_commands(app, code);
  veriflex::add_claims_command(app, code);
  veriflex::add_contract_commands(app, code);
  veriflex::add_derive_command(app);
  veriflex::add_calibrate_command(app);
  try {
    app.parse(argc, argv);
    return code;
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
    fmt::print(stderr, "veriflex: command line: {}. {}\n", error.what(), suggestion(app));
    return exit_code::input;
  } catch (const veriflex::InputError& error) {
    return report_error(error, exit_code::input);
  } catch (const veriflex::NumericalFailure& error) {
    return report_error(error, exit_code::numerical);
  } catch (const veriflex::OutputError& error) {
    return report_error(error, exit_code::output);
  } catch (const std::bad_alloc&) {
    fmt::print(stderr, "veriflex: out of memory. Use a smaller scene (see veriflex plan)\n");
    return exit_code::numerical;
  }
}
