#include "run_jobs.hpp"

#include <fmt/format.h>
#include <sys/wait.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <map>

#include "base/say.hpp"
#include "base/stop.hpp"
#include "engine/child.hpp"
#include "engine/symbols.hpp"
#include "exit_code.hpp"
#include "io/file.hpp"
#include "studies/studies.hpp"

namespace veriflex {

namespace {

using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

// Whether times of the case are among its numbers: another case beside it would spoil them.
bool is_timed(const Job& job, const Options& options) {
  try {
    const io::Table top = engine::parse_case(io::read_file(job.path), job.path.string(), options.overrides);
    const std::vector<std::string> topics = top.texts("topics");
    if (std::find(topics.begin(), topics.end(), "cost") != topics.end()) return true;
    const std::vector<std::string> tables = studies::tables();
    return std::any_of(tables.begin(), tables.end(),
                       [&](const std::string& study) { return top.shown(study + ".timed") == "true"; });
  } catch (const std::exception&) {  // its own run says what is wrong
    return false;
  }
}

// A case that runs, and what it says.
struct Running {
  Running(const Job& which, const Options& options, int threads, bool with_tables)
      : job(which),
        child(words(which, options, threads, with_tables), {out.descriptor(), err.descriptor()},
              "Let the system have more processes, or use fewer --jobs") {}

  static std::vector<std::string> words(const Job& job, const Options& options, int threads,
                                        bool with_tables) {
    std::vector<std::string> all{std::filesystem::read_symlink("/proc/self/exe").string(),
                                 "job",
                                 job.path.string(),
                                 "--out",
                                 options.out,
                                 "--cases",
                                 options.case_folder,
                                 "--threads",
                                 std::to_string(threads)};
    for (const std::string& one : options.overrides) all.insert(all.end(), {"--set", one});
    if (options.json) all.emplace_back("--json");
    if (options.resume) all.emplace_back("--resume");
    if (!with_tables) all.emplace_back("--brief");
    return all;
  }

  Job job;
  engine::FileInMemory out, err;
  engine::Child child;
  Clock::time_point start = Clock::now();
};

class Jobs {
 public:
  Jobs(const Options& options, bool with_tables, engine::TotalProgress& progress, Json& all, int& code)
      : options_(options), with_tables_(with_tables), progress_(progress), all_(all), code_(code) {}

  // Returns those that were not started.
  std::vector<std::size_t> run(const std::vector<Job>& jobs, int at_once) {
    const int threads = std::max(1, options_.threads / at_once);
    auto next = jobs.begin();
    while (next != jobs.end() || !running_.empty()) {
      while (next != jobs.end() && may_start() && running_.size() < static_cast<std::size_t>(at_once)) {
        running_.try_emplace(next->number, *next, options_, threads, with_tables_);
        ++next;
      }
      if (running_.empty()) break;
      progress_.show(fmt::format("{} running", running_.size()));
      wait_for_one();
    }
    std::vector<std::size_t> left;
    for (; next != jobs.end(); ++next) left.push_back(next->number);
    return left;
  }

 private:
  bool may_start() const { return !stop::asked() && !(options_.fail_fast && !exit_code::is_well(code_)); }

  // Until a case ends, or until it is time to look whether all are to stop.
  void wait_for_one() {
    std::vector<const engine::Child*> children;
    for (const auto& [i, one] : running_) children.push_back(&one.child);
    std::size_t k = 0;
    const std::vector<bool> ended = engine::wait_for_any(children, asked_to_stop_);
    for (auto at = running_.begin(); at != running_.end(); ++k) {
      if (!ended[k]) {
        ++at;
        continue;
      }
      finish(at->second);
      at = running_.erase(at);
    }
  }

  void finish(Running& one) {
    const int status = one.child.wait();
    progress_.clear();
    progress_.done(one.job.number, std::chrono::duration<double>(Clock::now() - one.start).count());
    std::fputs(one.err.text().c_str(), stderr);
    const std::string said = one.out.text();
    if (WIFSIGNALED(status)) {
      // Its place among the results is held by one that says so.
      complain("{}: killed by signal {} ({}). Give it more memory, or use fewer --jobs",
               one.job.path.string(), WTERMSIG(status), strsignal(WTERMSIG(status)));
      code_ = exit_code::first_of(code_, exit_code::numerical);
    } else {
      code_ = exit_code::first_of(code_, WEXITSTATUS(status));
    }
    if (!options_.json) {
      say("{}", said);
      std::fflush(stdout);
      return;
    }
    const Json document = Json::parse(said, nullptr, false);
    if (document.is_array() && document.size() == 1) {
      all_[one.job.number] = document.front();
    } else {
      all_[one.job.number] = {{"id", one.job.path.stem().string()}, {"verdict", "error"}};
    }
  }

  const Options& options_;
  bool with_tables_;
  engine::TotalProgress& progress_;
  Json& all_;
  int& code_;
  std::map<std::size_t, Running> running_;
  bool asked_to_stop_ = false;
};

}  // namespace

std::vector<std::size_t> run_side_by_side(const std::vector<Job>& jobs, const Options& options,
                                          bool with_tables, engine::TotalProgress& progress, Json& all,
                                          int& code) {
  std::vector<Job> untimed, timed;
  for (const Job& job : jobs) (is_timed(job, options) ? timed : untimed).push_back(job);
  Jobs runner(options, with_tables, progress, all, code);
  std::vector<std::size_t> left = runner.run(untimed, options.jobs);
  const std::vector<std::size_t> more = runner.run(timed, 1);
  left.insert(left.end(), more.begin(), more.end());
  return left;
}

}  // namespace veriflex
