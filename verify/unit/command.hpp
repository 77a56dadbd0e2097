// Runs the real command in a folder of its own.
#pragma once

#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace veriflex::unit {

namespace fs = std::filesystem;

inline std::string contents(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

/// How a case begins; no test reads its words.
inline std::string case_head(const std::string& id, const std::string& driver = "scene") {
  return "schema = 2\nid = \"" + id +
         "\"\ntitle = \"t\"\nquestion = \"q\"\nequation = \"e\"\nsources = []\n" +
         "tier = \"quick\"\ntopics = []\ndriver = \"" + driver + "\"\n";
}

struct Ran {
  int code;
  std::string out, err;
};

/// The command that is tested: what was built with the tests, or another program that VERIFLEX_COMMAND in the
/// environment names.
inline std::string command() {
  const char* other = std::getenv("VERIFLEX_COMMAND");
  return other != nullptr ? other
                          : fs::read_symlink("/proc/self/exe").parent_path().parent_path() / "veriflex";
}

/// A folder that is removed at the end.
class Folder {
 public:
  Folder() {
    std::string name = (fs::temp_directory_path() / "veriflex-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) std::abort();
    path_ = name;
  }
  ~Folder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  const fs::path& path() const { return path_; }

  void write(const std::string& name, const std::string& text) const {
    fs::create_directories((path_ / name).parent_path());
    std::ofstream(path_ / name, std::ios::binary) << text;
  }

  Ran run(const std::vector<std::string>& arguments) const {
    std::string line = "\"$V\"";
    for (const std::string& argument : arguments) line += " '" + argument + "'";
    return shell(line);
  }

  /// A line of sh here, in which "$V" is the command.
  Ran shell(const std::string& line) const {
    const std::string there = "cd '" + path_.string() + "' && { V='" + command() + "'; " + line + "; }";
    const int status = std::system((there + " >.stdout 2>.stderr").c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), contents(path_ / ".stdout"),
            contents(path_ / ".stderr")};
  }

  /// Files that a writer has left behind.
  std::vector<std::string> left_aside() const {
    std::vector<std::string> names;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(path_)) {
      const std::string name = entry.path().filename().string();
      if (name.find(".part") != std::string::npos) names.push_back(name);
    }
    return names;
  }

 private:
  fs::path path_;
};

/// Words of sh that wait until a condition of it holds, a minute at most.
inline std::string until(const std::string& condition) {
  return "for i in $(seq 6000); do " + condition + " && break; sleep 0.01; done";
}

/// `text` with the first `from` replaced.
inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  if (at == std::string::npos) std::abort();
  return text.replace(at, from.size(), to);
}

/// A good case named "bad": each test spoils it in one way.
inline const std::string good_case = R"(schema = 2
id = "bad"
title = "Bar of harmonic bonds"
question = "Is a bar of harmonic bonds as stiff as one bond says?"
equation = "E = k/r0"
sources = ["wu-qi-2014, Eq. 13"]
tier = "quick"
topics = ["tensile"]
driver = "tensile"

[bond]
law = "fene-lj"
epsilon = 1.0
sigma = 1.0

[solid]
shape = "bar"
nodes = [2, 2, 4]
lateral = "fixed"

[tensile]
control = "displacement"
strains = [-0.01, 0.01]

[[check]]
kind = "verification"
statement = "E = U''(r_eq)/r_eq"
metric = "young_modulus"
target = 1021.186296534041763399964
target_kind = "high-precision"
source = "40-digit arithmetic"
tolerance = { relative = 1e-9, reason = "differences of forces" }
)";

}  // namespace veriflex::unit
