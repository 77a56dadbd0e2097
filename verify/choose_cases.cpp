#include "choose_cases.hpp"

#include <fmt/format.h>
#include <fnmatch.h>

#include <algorithm>

#include "base/error.hpp"
#include "run_cases.hpp"

namespace veriflex {

namespace fs = std::filesystem;

namespace {

using engine::CaseHead;

bool is_pattern(const std::string& name) {
  std::error_code unknown;
  return name.find_first_of("*?[") != std::string::npos && !fs::exists(name, unknown);
}

std::string in_words(const Options& options) {
  std::string words = fmt::format("{} holds no case", options.case_folder);
  if (!options.tier.empty()) words += fmt::format(" of tier '{}'", options.tier);
  if (!options.topic.empty()) words += fmt::format(" with topic '{}'", options.topic);
  return words;
}

}  // namespace

std::vector<CaseHead> heads_chosen(const Options& options) {
  std::vector<CaseHead> heads = engine::find_cases(options.case_folder);
  std::erase_if(heads, [&](const CaseHead& head) {
    const bool of_tier = options.tier.empty() || head.tier == options.tier || !head.problem.empty();
    const bool of_topic = options.topic.empty() || std::find(head.topics.begin(), head.topics.end(),
                                                             options.topic) != head.topics.end();
    return !of_tier || !of_topic;
  });
  return heads;
}

std::vector<std::string> chosen_cases(const Options& options) {
  const bool by_label = !options.tier.empty() || !options.topic.empty();
  if (options.cases.empty() && !by_label) {
    throw InputError({}, "no case is named", "there is nothing to do",
                     "Give paths, ids or patterns like 'cost-*', or --tier or --topic; see veriflex list");
  }
  std::vector<CaseHead> heads;
  if (options.cases.empty() || std::any_of(options.cases.begin(), options.cases.end(), is_pattern)) {
    heads = heads_chosen(options);
  }
  std::vector<std::string> names;
  const auto add_matching = [&](const std::string& pattern) {
    std::size_t matches = 0;
    for (const CaseHead& head : heads) {
      if (fnmatch(pattern.c_str(), head.id.c_str(), 0) != 0) continue;
      ++matches;
      const std::string path = head.path.string();
      const bool known = std::any_of(names.begin(), names.end(), [&](const std::string& name) {
        return name == path || name == head.id;
      });
      if (!known) names.push_back(path);
    }
    if (matches > 0) return;
    throw InputError({}, fmt::format("'{}' matches nothing", pattern),
                     fmt::format("{} whose id is like that", in_words(options)), "See veriflex list");
  };
  if (options.cases.empty()) {
    if (heads.empty()) throw InputError({}, in_words(options), "there is nothing to do", "See veriflex list");
    add_matching("*");
  }
  for (const std::string& name : options.cases) {
    if (is_pattern(name)) {
      add_matching(name);
    } else {
      names.push_back(name);
    }
  }
  return names;
}

}  // namespace veriflex
